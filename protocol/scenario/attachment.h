#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::scenario {

/// How the nodes of a port's set hang on the port's frame.
enum class AttachmentKind {
  Rigid,      ///< every node follows the frame
  Averaging,  ///< the set's weighted least-squares frame follows it, the nodes deform
  Bushing     ///< a spring and a damper of six directions between the frame and that of the set
};

/// Weights of the nodes in the least-squares frame of their set.
enum class NodeWeights {
  Uniform,  ///< equal
  Area      ///< ∫ N_i dA over the set's surface
};

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Wrench of the bushing on the nodes, in its axes and at the port's origin: see bushing.h.
/// Directions x, y, z, then rotations about x, y, z.
struct BushingParams {
  Matrix6 stiffness = Matrix6::Zero();  ///< N/m, N, N·m/rad; symmetric, no negative eigenvalue
  Matrix6 damping = Matrix6::Zero();    ///< N·s/m, N·s, N·m·s/rad; likewise
  Eigen::Quaterniond q_PB = Eigen::Quaterniond::Identity();  ///< bushing axes in port axes
};

struct Attachment {
  AttachmentKind kind = AttachmentKind::Rigid;
  NodeWeights weights = NodeWeights::Uniform;
  BushingParams bushing{};
  [[nodiscard]] bool loose() const { return kind != AttachmentKind::Rigid; }
};

/// Keys `attachment`, `weights` and `bushing` of a port.
[[nodiscard]] std::vector<Key> attachment_keys();
[[nodiscard]] Attachment read_attachment(const Node& port);

}  // namespace tandem::scenario

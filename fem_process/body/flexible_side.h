#pragma once

#include <functional>
#include <string>

#include "fem_process/body/model.h"
#include "fem_process/body/state.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem {

/// Mean motion of a node set (unweighted), in W.
struct MeanMotion {
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
};

/// What every flexible side on a mesh offers beside the contract: the motion of its nodes.
class FlexibleSide : public FemSide {
 public:
  [[nodiscard]] virtual const Model& model() const = 0;
  /// Time, positions and velocities of all nodes; a reduced body expands its coordinates.
  [[nodiscard]] virtual State nodal_state() const = 0;
  /// Called with every accepted nodal state, from checkpoint().
  virtual void on_accepted(std::function<void(const State&)> observer) = 0;

  [[nodiscard]] MeanMotion mean_motion(const std::string& node_set) const;
};

/// The same of any nodal state.
[[nodiscard]] MeanMotion mean_motion(const Model& model, const State& state,
                                     const std::string& node_set);

}  // namespace tandem::fem

#include "fem_process/matrix/node_rotations.h"

#include <algorithm>
#include <utility>

#include "fem_process/kernels/polar_lanes.h"
#include "fem_process/matrix/node_vectors.h"
#include "fem_process/matrix/tet4.h"

namespace tandem::fem {
namespace {

/// Nodes that a thread takes at a time: whole batches of lanes.
constexpr std::size_t kGrain = 16 * kLanes;

/// Rows of F of a node.
TANDEM_INLINE void add_gradient(const BlockPattern& pattern, const Padded* G, const Padded* x,
                                int node, Double4& F0, Double4& F1, Double4& F2) {
  const auto row = static_cast<std::size_t>(node);
  Double4 x_i;
  load(x_i, x[node].at);
  F0 = F1 = F2 = Double4{};
  for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
    Double4 d;
    Double4 g;
    load(d, x[pattern.column[static_cast<std::size_t>(b)]].at);
    load(g, G[b].at);
    d -= x_i;
    F0 += d[0] * g;
    F1 += d[1] * g;
    F2 += d[2] * g;
  }
}

void set_rotation(const double (&R)[3][4], NodeRotation& rotation) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      rotation.row[i][j] = static_cast<float>(R[i][j]);
      rotation.column[j][i] = rotation.row[i][j];
    }
    rotation.row[i][3] = 0.0F;
    rotation.column[i][3] = 0.0F;
  }
}

template <class Registers>
TANDEM_INLINE void turn_body(const BlockPattern& pattern, const Padded* G, const int* nodes,
                             std::size_t count, const Padded* x, NodeRotation* rotations) {
  using Lanes = typename Registers::Double8;
  for (std::size_t first = 0; first < count; first += kLanes) {
    Double4 rows[3][kLanes];
    for (std::size_t n = 0; n < kLanes; ++n) {
      add_gradient(pattern, G, x, nodes[std::min(first + n, count - 1)], rows[0][n], rows[1][n],
                   rows[2][n]);
    }
    LaneMatrix<Lanes> F;
    LaneMatrix<Lanes> R;
    for (int r = 0; r < 3; ++r) {
      gather_lanes<Registers>(rows[r], F.at[3 * r], F.at[3 * r + 1], F.at[3 * r + 2]);
    }
    polar_lanes(F, R);
    double turned[kLanes][3][4];
    for (int r = 0; r < 3; ++r) {
      scatter_lanes<Registers>(R.at[3 * r], R.at[3 * r + 1], R.at[3 * r + 2], turned[0][r], 12);
    }
    for (std::size_t n = 0; n < kLanes && first + n < count; ++n) {
      set_rotation(turned[n], rotations[first + n]);
    }
  }
}

TANDEM_REGISTER_FUNCTION(turn, turn_body,
                         (const BlockPattern& pattern, const Padded* G, const int* nodes,
                          std::size_t count, const Padded* x, NodeRotation* rotations),
                         (pattern, G, nodes, count, x, rotations))

}  // namespace

NodeRotations::NodeRotations(const TetMesh& mesh, const BlockPattern& pattern,
                             std::vector<int> nodes)
    : pattern_(pattern), nodes_(std::move(nodes)), G_(pattern.blocks(), Padded{}) {
  std::vector<double> volume(mesh.X.size(), 0.0);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Tet& corners = mesh.tets[e];
    const TetShape shape = make_tet_shape(mesh, corners, pattern);
    for (int i : mesh.element(e)) {
      volume[static_cast<std::size_t>(i)] += shape.volume;
      for (std::size_t j = 0; j < 4; ++j) {
        Padded& G = G_[static_cast<std::size_t>(pattern.find(i, corners[j]))];
        for (int a = 0; a < 3; ++a) {
          G.at[a] += shape.volume * shape.gradients(static_cast<Eigen::Index>(j), a);
        }
      }
    }
  }
  for (std::size_t i = 0; i < volume.size(); ++i) {
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      for (double& entry : G_[static_cast<std::size_t>(b)].at) entry /= volume[i];
    }
  }
}

void NodeRotations::at(const Eigen::VectorXd& x, std::vector<NodeRotation>& rotations,
                       ThreadTeam& team) const {
  // Kept between calls; helpers have thread-local vectors of their own.
  static thread_local std::vector<Padded> padded;
  pad(x, padded);
  const Padded* const all = padded.data();
  rotations.resize(nodes_.size());
  team.run_ranges(nodes_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    turn(pattern_, G_.data(), nodes_.data() + begin, end - begin, all, rotations.data() + begin);
  });
}

}  // namespace tandem::fem

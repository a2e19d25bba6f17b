#include "fem_process/quasi_static.h"

#include <algorithm>

#include "protocol/contract/error.h"

namespace tandem::fem {

StepMap QuasiStatic::map(const State& state, double h_s) const {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(state.x.size());
  StepMap map;
  map.c_x = h_s;
  map.x_tilde = state.x;
  map.d_hat = zero;
  map.a_hat = zero;
  map.a_hat_prescribed = zero;
  map.prescribed_position = true;
  return map;
}

void require_held(const Model& model) {
  // Largest triangle on the first prescribed node and the one that is farthest from it.
  const auto X = [&](int node) { return model.mesh.X[static_cast<std::size_t>(node)]; };
  double largest = 0.0;
  if (!model.prescribed.empty()) {
    const Eigen::Vector3d a = X(model.prescribed.front());
    const auto farther = [&](int i, int j) { return (X(i) - a).norm() < (X(j) - a).norm(); };
    const Eigen::Vector3d base =
        X(*std::max_element(model.prescribed.begin(), model.prescribed.end(), farther)) - a;
    for (int node : model.prescribed) largest = std::max(largest, base.cross(X(node) - a).norm());
  }
  const double size = diagonal_of(model.mesh);
  require(largest > 1e-9 * size * size,
          "fem: the quasi-static body is not held: its ports and fixed sets have " +
              std::to_string(model.prescribed.size()) +
              " nodes, and statics needs three that are not in line. Add a port or fem.fixed, or "
              "choose another fem.integrator.kind.");
}

}  // namespace tandem::fem

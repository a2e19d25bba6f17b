#include "fem_process/body/quasi_static.h"

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

}  // namespace tandem::fem

#include "fem_process/generalised_alpha.h"

namespace tandem::fem {

GeneralisedAlpha::Weights GeneralisedAlpha::weights_of(double rho_infinity) {
  const double alpha_m = (2.0 * rho_infinity - 1.0) / (rho_infinity + 1.0);
  const double alpha_f = rho_infinity / (rho_infinity + 1.0);
  const double shift = 1.0 - alpha_m + alpha_f;
  return {
      .alpha_m = alpha_m, .alpha_f = alpha_f, .beta = 0.25 * shift * shift, .gamma = shift - 0.5};
}

GeneralisedAlpha::Weights GeneralisedAlpha::weights_of_hht(double alpha) {
  return {.alpha_m = 0.0,
          .alpha_f = -alpha,
          .beta = 0.25 * (1.0 - alpha) * (1.0 - alpha),
          .gamma = 0.5 - alpha};
}

StepMap GeneralisedAlpha::map(const State& state, double h_s) const {
  const auto& [alpha_m, alpha_f, beta, gamma] = weights_;
  StepMap map;
  map.c_x = beta * h_s / gamma;
  map.c_a = (1.0 - alpha_m) / ((1.0 - alpha_f) * gamma * h_s);
  map.x_tilde = state.x + h_s * state.v;
  map.d_hat = h_s * h_s * (0.5 - beta / gamma) * state.a - map.c_x * state.v;
  const double of_a = (alpha_m - (1.0 - alpha_m) * (1.0 - gamma) / gamma) / (1.0 - alpha_f);
  map.a_hat = -map.c_a * state.v + of_a * state.a - alpha_f / (1.0 - alpha_f) * state.acceleration;
  map.c_a_prescribed = 1.5 / h_s;
  map.a_hat_prescribed = -map.c_a_prescribed * state.v - 0.5 * state.a_mean;
  map.prescribed_position = true;
  return map;
}

void GeneralisedAlpha::keep(const State& begin, const Eigen::VectorXd& v, const Eigen::VectorXd& a,
                            double h_s, State& after) const {
  const double gamma = weights_.gamma;
  after.a_mean = (v - begin.v) / h_s;
  after.a = after.a_mean / gamma - (1.0 - gamma) / gamma * begin.a;
  after.acceleration = a;
}

}  // namespace tandem::fem

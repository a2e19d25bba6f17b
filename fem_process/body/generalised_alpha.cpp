#include "fem_process/body/generalised_alpha.h"

#include <algorithm>
#include <cmath>

namespace tandem::fem {
namespace {

constexpr double kMostTurn_rad = 2.0;

/// k = 1/θ − ½ cot(θ/2).
double end_correction(double theta) {
  if (theta > 0.05) return 1.0 / theta - 0.5 / std::tan(0.5 * theta);
  // Its series: the next term is below round-off, where the closed form cancels.
  const double square = theta * theta;
  return theta / 12.0 * (1.0 + square / 60.0 * (1.0 + square / 42.0));
}

}  // namespace

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

std::complex<double> GeneralisedAlpha::circle_lead(double turn_rad) const {
  const auto& [alpha_m, alpha_f, beta, gamma] = weights_;
  const double theta = std::min(turn_rad, kMostTurn_rad);
  if (theta == 0.0) return 0.0;
  const std::complex<double> i(0.0, 1.0);
  const double half = 0.5 * theta;
  // (z − 1)/(iθ) = exp(iθ/2) sin(θ/2)/(θ/2)
  const std::complex<double> chord = std::polar(std::sin(half) / half, half);
  const std::complex<double> g = chord / ((1.0 - alpha_f) * std::polar(1.0, theta) + alpha_f);
  const std::complex<double> lack = i * end_correction(theta) - (alpha_f - alpha_m) * (g - 1.0);
  return lack / (gamma - lack);
}

std::complex<double> GeneralisedAlpha::prescribed_circle_lead(double turn_rad) const {
  const double theta = std::min(turn_rad, kMostTurn_rad);
  const double k = end_correction(theta);
  return {-k * theta, k + 0.25 * theta - k * k * theta};
}

}  // namespace tandem::fem

#include "fem_process/integrator.h"

#include "fem_process/generalised_alpha.h"
#include "fem_process/quasi_static.h"

namespace tandem::fem {

StepMap BackwardEuler::map(const State& state, double h_s) const {
  StepMap map;
  map.c_x = h_s;
  map.c_a = 1.0 / h_s;
  map.x_tilde = state.x;
  map.d_hat = Eigen::VectorXd::Zero(state.x.size());
  map.a_hat = -state.v / h_s;
  map.c_a_prescribed = map.c_a;
  map.a_hat_prescribed = map.a_hat;
  return map;
}

StepMap Hht::map(const State& state, double h_s) const {
  const double gamma = 0.5 - alpha_;
  const double beta = 0.25 * (1.0 - alpha_) * (1.0 - alpha_);
  StepMap map;
  map.c_x = beta * h_s / gamma;
  map.c_a = 1.0 / (gamma * h_s);
  map.theta = 1.0 + alpha_;
  map.x_tilde = state.x + h_s * state.v;
  map.d_hat = h_s * h_s * (0.5 - beta / gamma) * state.a - map.c_x * state.v;
  map.a_hat = -map.c_a * state.v - (1.0 - gamma) / gamma * state.a;
  const double ahead = 0.5 + alpha_;
  map.c_a_prescribed = (1.0 + ahead) / h_s;
  map.a_hat_prescribed = -map.c_a_prescribed * state.v - ahead * state.a_mean;
  map.prescribed_position = true;
  return map;
}

void Hht::keep(const State& begin, const Eigen::VectorXd& v, const Eigen::VectorXd& a, double h_s,
               State& after) const {
  after.a_mean = (v - begin.v) / h_s;
  after.a = a;
}

std::unique_ptr<Integrator> make_integrator(const IntegratorParams& params) {
  switch (params.kind) {
    case IntegratorKind::Hht:
      return std::make_unique<Hht>(params.hht_alpha);
    case IntegratorKind::GeneralisedAlpha:
      return std::make_unique<GeneralisedAlpha>(GeneralisedAlpha::weights_of(params.rho_infinity));
    case IntegratorKind::Newmark:
      return std::make_unique<GeneralisedAlpha>(
          GeneralisedAlpha::Weights{.beta = params.newmark_beta, .gamma = params.newmark_gamma});
    case IntegratorKind::QuasiStatic:
      return std::make_unique<QuasiStatic>();
    case IntegratorKind::BackwardEuler:
      break;
  }
  return std::make_unique<BackwardEuler>();
}

}  // namespace tandem::fem

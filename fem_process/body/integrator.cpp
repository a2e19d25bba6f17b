#include "fem_process/body/integrator.h"

#include "fem_process/body/generalised_alpha.h"
#include "fem_process/body/quasi_static.h"

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

std::unique_ptr<Integrator> make_integrator(const IntegratorParams& params) {
  switch (params.kind) {
    case IntegratorKind::Hht:
      return std::make_unique<GeneralisedAlpha>(GeneralisedAlpha::weights_of_hht(params.hht_alpha));
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

#include "fem_process/body/params.h"

#include <fmt/format.h>

#include <cmath>

#include "protocol/contract/error.h"

namespace tandem::fem {

void check(const Params& params) {
  check(params.material);
  for (const MaterialSection& section : params.materials) check(section.material);
  require(params.mesh.position_m.allFinite(), "fem: the mesh position must be finite.");
  require(std::abs(params.mesh.orientation.norm() - 1.0) < 1e-9,
          "fem: the mesh orientation must be a unit quaternion.");
  require(params.damping.alpha_per_s >= 0.0 && std::isfinite(params.damping.alpha_per_s),
          "fem: damping alpha " + fmt::format("{:.6g}", params.damping.alpha_per_s) +
              " 1/s must not be negative.");
  require(params.damping.beta_s >= 0.0 && std::isfinite(params.damping.beta_s),
          "fem: damping beta " + fmt::format("{:.6g}", params.damping.beta_s) +
              " s must not be negative.");
  const double alpha = params.integrator.hht_alpha;
  require(alpha >= -1.0 / 3.0 && alpha <= 0.0,
          "fem: HHT alpha " + fmt::format("{:.6g}", alpha) +
              " must be between -1/3 (most damping) and 0 (none).");
  const double rho = params.integrator.rho_infinity;
  require(rho >= 0.0 && rho <= 1.0, "fem: rho_infinity " + fmt::format("{:.6g}", rho) +
                                        " must be between 0 (most damping) and 1 (none).");
  const double beta = params.integrator.newmark_beta;
  const double gamma = params.integrator.newmark_gamma;
  require(beta > 0.0 && beta <= 1.0,
          "fem: newmark_beta " + fmt::format("{:.6g}", beta) + " must be above 0 and at most 1.");
  require(gamma >= 0.5 && gamma <= 1.0, "fem: newmark_gamma " + fmt::format("{:.6g}", gamma) +
                                            " must be between 0.5 (no damping) and 1; below 0.5 "
                                            "motions grow.");
  require(params.integrator.newton_steps >= 0, "fem: newton_steps must not be negative.");
  require(params.integrator.newton_tolerance > 0.0 && params.integrator.newton_tolerance < 1.0,
          "fem: newton_tolerance must be above 0 and below 1.");
  const CraigBamptonParams& reduction = params.craig_bampton;
  require(reduction.modes >= 0, "fem: craig_bampton modes must not be negative.");
  require(reduction.frequency_limit_Hz.value_or(1.0) > 0.0,
          "fem: craig_bampton frequency_limit_Hz must be positive.");
  require(params.solver.tolerance > 0.0 && params.solver.tolerance < 1.0,
          "fem: solver tolerance must be above 0 and below 1.");
  require(params.solver.max_iterations > 0, "fem: solver max_iterations must be positive.");
  require(params.threads >= 1 && params.threads <= 64,
          "fem: " + std::to_string(params.threads) + " threads: there must be 1 to 64.");
  require(params.micro_step > SimTime{}, "fem: the micro step must be positive.");
  require(params.gravity_m_per_s2.allFinite(), "fem: gravity must be finite.");
  for (const Load& load : params.loads) {
    require(load.value.allFinite(), "fem: the load on '" + load.set.name + "' must be finite.");
  }
  for (std::size_t i = 1; i < params.changes.size(); ++i) {
    require(params.changes[i - 1].at <= params.changes[i].at,
            "fem: the changes must stand in the order of their times.");
  }
  const InitialVelocity& v = params.initial_velocity;
  require(v.linear_m_per_s.allFinite() && v.angular_rad_per_s.allFinite() &&
              v.about_m.allFinite() && v.gradient_per_s.allFinite(),
          "fem: the initial velocity must be finite.");
}

}  // namespace tandem::fem

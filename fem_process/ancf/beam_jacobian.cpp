#include <Eigen/Geometry>

#include "fem_process/ancf/beam_step.h"
#include "fem_process/kernels/cross_matrix.h"

namespace tandem::fem::ancf {
namespace {

/// Derivative of a force on the band with respect to the motion of its wheel
/// [p | θ with R_b = exp(θ×) R_a | v | w], the point being held. A wheel that turns takes the force
/// with it but for what d, u and w, which stay, change as seen from the wheel:
///   ∂f/∂θ = −f× + f_d d× + f_u u× + f_w w×
Eigen::Matrix<double, 3, 12> by_motion(const Touch& touch, const Motion& wheel) {
  const Eigen::Vector3d d = touch.r - wheel.p_WP;
  const Eigen::Vector3d u = touch.v - wheel.v_WP;
  const Eigen::Vector3d w = u - wheel.w_WP.cross(d);
  Eigen::Matrix<double, 3, 12> derivative;
  derivative << -touch.by_place + touch.by_slip * cross_matrix(wheel.w_WP),
      -cross_matrix(touch.force) + touch.by_place * cross_matrix(d) +
          touch.by_approach * cross_matrix(u) + touch.by_slip * cross_matrix(w),
      -touch.by_approach - touch.by_slip, touch.by_slip * cross_matrix(d);
  return derivative;
}

}  // namespace

void BeamStep::add_touches(const BeamState& state, const MotionSet& motions, Slopes& slopes) const {
  for (const Touch& touch : contact_.touches(state.q, state.v, motions, params_.friction)) {
    const Motion& wheel = motions[static_cast<std::size_t>(touch.port)];
    const Eigen::Matrix3d arm = cross_matrix(touch.r - wheel.p_WP);
    const Eigen::Matrix3d force = cross_matrix(touch.force);
    const Eigen::Matrix<double, 3, 12> of_motion = by_motion(touch, wheel);
    const Eigen::Matrix3d of_place = touch.by_place - touch.by_slip * cross_matrix(wheel.w_WP);
    const Eigen::Matrix3d of_rate = touch.by_approach + touch.by_slip;
    const Eigen::Index row = 6 * touch.port;
    const Eigen::Index column = 12 * touch.port;
    // λ = [−f | −d × f].
    slopes.direct.block<3, 12>(row, column) -= of_motion;
    slopes.direct.block<3, 12>(row + 3, column) -= arm * of_motion;
    slopes.direct.block<3, 3>(row + 3, column) -= force;
    for (const Term& term :
         system_.mesh().elements[static_cast<std::size_t>(touch.element)].terms) {
      const double s = term.factor * touch.shape(term.slot);
      const Eigen::Index at = 3 * term.vector;
      slopes.balance.block<3, 12>(at, column) += s * of_motion;
      slopes.wrench_q.block<3, 3>(at, row) -= s * of_place.transpose();
      slopes.wrench_q.block<3, 3>(at, row + 3) += s * (force - arm * of_place).transpose();
      slopes.wrench_v.block<3, 3>(at, row) -= s * of_rate.transpose();
      slopes.wrench_v.block<3, 3>(at, row + 3) -= s * (arm * of_rate).transpose();
    }
  }
}

bool BeamStep::add_attachments(const Alpha& alpha, const BeamState& state, const MotionSet& motions,
                               const std::vector<double>& step_matrix, Slopes& slopes) const {
  ElementArrays elements = system_.element_arrays();
  ContactSums sums;
  Eigen::VectorXd balance;
  if (!imbalance(state, motions, to_seconds(state.time), params_.mass_damping_per_s, 0.0, elements,
                 sums, balance)) {
    return false;
  }
  const Attachments::Derivatives ends = attachments_->derivatives(motions, balance);
  const ColumnPattern& pattern = system_.solver().pattern();
  // −∂R = K ∂q + C ∂v + M (α_M + ∂a/∂v) ∂v, from S(θ) = K + θ C.
  std::vector<double> stiffness;
  system_.sum(elements, 0.0, stiffness);
  std::vector<double> rates = step_matrix;
  ElementArrays none = system_.element_arrays();
  std::vector<double> mass;
  system_.sum(none, 1.0, mass);
  const double in_step = alpha.mass() + alpha.rate() * params_.mass_damping_per_s;
  const double in_rates = params_.mass_damping_per_s + Attachments::acceleration_rate(alpha.h);
  for (std::size_t i = 0; i < rates.size(); ++i) {
    rates[i] =
        (step_matrix[i] - stiffness[i] - in_step * mass[i]) / alpha.rate() + in_rates * mass[i];
  }
  // Loads follow the balance, which follows the motions and the free unknowns.
  slopes.balance -= pattern.times(stiffness, ends.q) + pattern.times(rates, ends.v);
  slopes.direct += slopes.wrench_q.transpose() * ends.q + slopes.wrench_v.transpose() * ends.v +
                   ends.turn + ends.loads.transpose() * slopes.balance;
  slopes.wrench_q -= pattern.transposed_times(step_matrix, ends.loads);
  return true;
}

std::optional<InterfaceJacobian> BeamStep::jacobian(const BeamState& state,
                                                    const MotionSet& motions, SimTime h) const {
  const Alpha coefficients = alpha(to_seconds(h));
  ElementArrays elements = system_.element_arrays();
  ContactSums sums;
  if (system_.kernel().tangents(state.q, state.v, coefficients.rate(), elements) > 0) {
    return std::nullopt;
  }
  contact_.add(state.q, state.v, motions, params_.friction, coefficients.rate(), elements, sums);
  std::vector<double> values;
  system_.sum(elements, coefficients.mass() + coefficients.rate() * params_.mass_damping_per_s,
              values);

  const auto ports = static_cast<Eigen::Index>(motions.size());
  const Eigen::Index n = state.q.size();
  Slopes slopes{Eigen::MatrixXd::Zero(n, 12 * ports), Eigen::MatrixXd::Zero(n, 6 * ports),
                Eigen::MatrixXd::Zero(n, 6 * ports),
                InterfaceJacobian::Zero(6 * ports, 12 * ports)};
  add_touches(state, motions, slopes);
  if (attachments_ != nullptr && !add_attachments(coefficients, state, motions, values, slopes)) {
    return std::nullopt;
  }
  system_.hold(values);
  const auto factor = system_.solver().factorize(values);
  if (!factor) return std::nullopt;
  // λ has half as many components as the motions: S⁻ᵀ (∂λ/∂q⁺)ᵀ rather than S⁻¹ ∂R/∂m.
  Eigen::MatrixXd wrench = slopes.wrench_q + coefficients.rate() * slopes.wrench_v;
  factor->solve_transposed(wrench);
  for (Eigen::Index j = 0; j < wrench.cols(); ++j) system_.clear_fixed(wrench.col(j));
  return slopes.direct + wrench.transpose() * slopes.balance;
}

}  // namespace tandem::fem::ancf

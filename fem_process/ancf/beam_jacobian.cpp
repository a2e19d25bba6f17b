#include <Eigen/Geometry>

#include "fem_process/ancf/beam_step.h"

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
  system_.assemble(elements, coefficients.mass() + coefficients.rate() * params_.mass_damping_per_s,
                   values);
  const auto factor = system_.solver().factorize(values);
  if (!factor) return std::nullopt;

  const auto ports = static_cast<Eigen::Index>(motions.size());
  Eigen::MatrixXd balance = Eigen::MatrixXd::Zero(state.q.size(), 12 * ports);  // ∂R/∂m
  Eigen::MatrixXd wrench = Eigen::MatrixXd::Zero(state.q.size(), 6 * ports);  // (∂λ/∂q⁺)ᵀ
  InterfaceJacobian total = InterfaceJacobian::Zero(6 * ports, 12 * ports);
  for (const Touch& touch : contact_.touches(state.q, state.v, motions, params_.friction)) {
    const Motion& wheel = motions[static_cast<std::size_t>(touch.port)];
    const Eigen::Matrix3d arm = cross_matrix(touch.r - wheel.p_WP);
    const Eigen::Matrix3d force = cross_matrix(touch.force);
    const Eigen::Matrix<double, 3, 12> of_motion = by_motion(touch, wheel);
    const Eigen::Matrix3d of_point = touch.by_place - touch.by_slip * cross_matrix(wheel.w_WP) +
                                     coefficients.rate() * (touch.by_approach + touch.by_slip);
    const Eigen::Index row = 6 * touch.port;
    const Eigen::Index column = 12 * touch.port;
    // λ = [−f | −d × f].
    total.block<3, 12>(row, column) -= of_motion;
    total.block<3, 12>(row + 3, column) -= arm * of_motion;
    total.block<3, 3>(row + 3, column) -= force;
    for (const Term& term :
         system_.mesh().elements[static_cast<std::size_t>(touch.element)].terms) {
      const double s = term.factor * touch.shape(term.slot);
      balance.block<3, 12>(3 * term.vector, column) += s * of_motion;
      wrench.block<3, 3>(3 * term.vector, row) -= s * of_point.transpose();
      wrench.block<3, 3>(3 * term.vector, row + 3) += s * (force - arm * of_point).transpose();
    }
  }
  // λ has half as many components as the motions: S⁻ᵀ (∂λ/∂q⁺)ᵀ rather than S⁻¹ ∂R/∂m.
  factor->solve_transposed(wrench);
  for (Eigen::Index j = 0; j < wrench.cols(); ++j) system_.clear_fixed(wrench.col(j));
  total += wrench.transpose() * balance;
  return total;
}

}  // namespace tandem::fem::ancf

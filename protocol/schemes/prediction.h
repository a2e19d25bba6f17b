#pragma once

#include <cstddef>
#include <vector>

#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem {

/// The interface at the end of an accepted macro step.
struct InterfaceSample {
  SimTime time{};
  MotionSet motions;
  WrenchSet wrenches;
};

/// What is known at the beginning of a macro step: the accepted interface at t_n and before.
struct InterfaceState {
  static constexpr std::size_t kHistory = 2;  ///< samples before t_n that are kept
  SimTime time{};
  MotionSet motions;                     ///< m_n
  WrenchSet wrenches;                    ///< λ_n
  WrenchSet own;                         ///< of them, what the flexible bodies exert; empty: all
  std::vector<InterfaceSample> history;  ///< at t_{n−1}, t_{n−2}: as far as there are any

  /// The flexible bodies' wrenches.
  [[nodiscard]] const WrenchSet& of_bodies() const { return own.empty() ? wrenches : own; }
};

/// [v_WP | w_WP] of all ports, 6 per port.
[[nodiscard]] Eigen::VectorXd twists(const MotionSet& motions);

/// Σ weights · values with the weights of the polynomial at t_n + H; `values` belong to t_n,
/// t_{n−1}, t_{n−2} and are as many as the accepted states are, up to three.
[[nodiscard]] Eigen::VectorXd extrapolate(Prediction prediction, const InterfaceState& state,
                                          SimTime H, const std::vector<Eigen::VectorXd>& values);

/// λ at t_n + H: the polynomial of degree 0 (hold), 1 (linear) or 2 (quadratic) through the last
/// accepted wrenches, whatever the steps between them. The degree is lower while the run is young.
[[nodiscard]] WrenchSet predict_wrenches(Prediction prediction, const InterfaceState& state,
                                         SimTime H);

/// m at t_n + H: velocities by the same polynomials, and the poses which they lead to,
///   p = p_n + ∫v dt,   R = exp(∫w dt ×) R_n,   both integrals over [t_n, t_n + H].
[[nodiscard]] MotionSet predict_motions(Prediction prediction, const InterfaceState& state,
                                        SimTime H);

}  // namespace tandem

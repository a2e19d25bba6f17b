#pragma once

#include <complex>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem::orchestrator {

/// What one port feels of each side within a step H, in the direction where it is worst.
struct PortRatio {
  std::string name;
  double rigid_kg = 0.0;  ///< H / largest eigenvalue of ∂v/∂f: the lightest direction
  double flexible_kg = 0.0;  ///< largest eigenvalue of −H (∂f/∂v + H ∂f/∂p): the heaviest direction
  double stiffness_N_per_m = 0.0;  ///< largest eigenvalue of −∂f/∂p
};

/// The strength of the coupling within one macro step.
struct InterfaceRatios {
  double step_s = 0.0;
  std::vector<PortRatio> ports;
  /// Eigenvalues of G = L B, with B = ∂M/∂λ of the multibody side and L = ∂Λ/∂m of the flexible
  /// side: one evaluation of both sides multiplies an error of the wrench by G.
  std::vector<std::complex<double>> gains;

  /// κ = ρ(G). For a free mass m at a port that carries a mass μ and a spring k it is
  /// (μ + H² k)/m.
  [[nodiscard]] double coupling_ratio() const;
};

/// Linearises both sides over one macro step H from their initial state, which they are in again
/// afterwards. Throws a Usage error when a side cannot linearise.
[[nodiscard]] InterfaceRatios measure_ratios(MbsSide& mbs, FemSide& fem, SimTime H);

/// By how much explicit_serial multiplies an error of the wrench per macro step when the sides are
/// held at their state: the largest root |z| over the eigenvalues g of G of
///   hold z = g,   linear z² = g (2z − 1),   quadratic z³ = g (3z² − 3z + 1).
/// For g = −κ it passes 1 at κ = 1, 1/3 and 1/7. Below 1 the scheme is stable; where the wrench
/// comes from a spring and not from inertia it may still be stable somewhat above.
[[nodiscard]] double explicit_amplification(const InterfaceRatios& ratios, Prediction prediction);

}  // namespace tandem::orchestrator

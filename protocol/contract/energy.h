#pragma once

#include <vector>

namespace tandem {

/// Energies of one side at its present state and what has been booked on it since t = 0 (J):
///   total − total(0) = external + interface − damping − numerical,   total = kinetic + potential
///   + elastic.
/// Every term is booked on its own, so the sum can fail: what is left is balance_error_J.
struct EnergyBook {
  double kinetic_J = 0.0;
  double potential_J = 0.0;  ///< gravity (zero at the world origin), springs
  double elastic_J = 0.0;    ///< strain energy, depth of contacts

  double external_work_J = 0.0;   ///< by loads, force laws and motors
  double interface_work_J = 0.0;  ///< by the port inputs on this side
  double damping_loss_J = 0.0;    ///< dampers, material and mass damping, friction
  /// What the integrator takes (negative: gives), known in closed form from the step's own
  /// quantities; see each side.
  double numerical_loss_J = 0.0;

  [[nodiscard]] double total_J() const { return kinetic_J + potential_J + elastic_J; }
  [[nodiscard]] double dissipated_J() const { return damping_loss_J + numerical_loss_J; }

  EnergyBook& operator+=(const EnergyBook& b) {
    kinetic_J += b.kinetic_J;
    potential_J += b.potential_J;
    elastic_J += b.elastic_J;
    external_work_J += b.external_work_J;
    interface_work_J += b.interface_work_J;
    damping_loss_J += b.damping_loss_J;
    numerical_loss_J += b.numerical_loss_J;
    return *this;
  }
  friend EnergyBook operator+(EnergyBook a, const EnergyBook& b) { return a += b; }
  friend bool operator==(const EnergyBook&, const EnergyBook&) = default;
};

/// The books of both sides at the same time.
struct SideEnergies {
  EnergyBook mbs;
  EnergyBook fem;
  /// Of the single worlds where there are several, then of the flexible bodies where there are.
  std::vector<EnergyBook> parts = {};
  [[nodiscard]] EnergyBook sum() const { return mbs + fem; }
  friend bool operator==(const SideEnergies&, const SideEnergies&) = default;
};

/// What the balance of a side lacks from `begin` to `end` (J): positive = energy from nowhere. Zero
/// to round-off where the integrator's balance is exact (rigid bodies, linear flexible bodies), of
/// the order of the linearisation's error elsewhere.
[[nodiscard]] inline double balance_error_J(const EnergyBook& begin, const EnergyBook& end) {
  return (end.total_J() - begin.total_J()) - (end.external_work_J - begin.external_work_J) -
         (end.interface_work_J - begin.interface_work_J) +
         (end.dissipated_J() - begin.dissipated_J());
}

}  // namespace tandem

#pragma once

#include <algorithm>

#include "protocol/contract/energy.h"

namespace tandem {

/// The largest of what both sides' books have held and booked at the times at which a run looked
/// into them (J). The energies of the end alone may be small by accident, and so may its errors.
/// Strain is counted from the start: what a part is mounted with takes no part in the run.
struct EnergyRange {
  double held_J = 0.0;              ///< T + |U − U(0)|
  double external_work_J = 0.0;     ///< |W|, by loads, force laws and motors
  double potential_change_J = 0.0;  ///< |V − V(0)|
  double released_J = 0.0;          ///< U(0) − U + V(0) − V, where positive
  double lost_J = 0.0;              ///< by the steps: numerical loss − work made by the interface
  double made_J = 0.0;              ///< by the steps: the same with the other sign
  double balance_error_J = 0.0;     ///< |balance_error_J|
  double kinetic_start_J = 0.0;

  /// Books both sides' sum `now` of a run that began with `start`. `line`: the interface is a line
  /// that stores energy (tlm), its work is no loss.
  void book(const EnergyBook& start, const EnergyBook& now, bool line);

  /// Of what was held, in motion, in strain and in height.
  [[nodiscard]] double largest_J() const { return std::max(held_J, potential_change_J); }

  /// What the run began with and was given.
  [[nodiscard]] double given_J() const { return kinetic_start_J + released_J + external_work_J; }
};

/// What the steps have lost from `start` to `now`, see EnergyRange (J); negative: made.
[[nodiscard]] double lost_by_steps_J(const EnergyBook& start, const EnergyBook& now, bool line);

}  // namespace tandem

#include "protocol/driver/energy_range.h"

#include <algorithm>
#include <cmath>

namespace tandem {

double lost_by_steps_J(const EnergyBook& start, const EnergyBook& now, bool line) {
  const double numerical_J = now.numerical_loss_J - start.numerical_loss_J;
  // Both sides book the work of the same wrench in the same motion: what is left of the sum, the
  // interface has made.
  return line ? numerical_J : numerical_J - (now.interface_work_J - start.interface_work_J);
}

void EnergyRange::book(const EnergyBook& start, const EnergyBook& now, bool line) {
  const auto keep = [](double& largest, double value) { largest = std::max(largest, value); };
  kinetic_start_J = start.kinetic_J;
  const double strained_J = now.elastic_J - start.elastic_J;
  const double raised_J = now.potential_J - start.potential_J;
  keep(held_J, now.kinetic_J + std::abs(strained_J));
  keep(external_work_J, std::abs(now.external_work_J - start.external_work_J));
  keep(potential_change_J, std::abs(raised_J));
  keep(released_J, std::max(0.0, -strained_J) + std::max(0.0, -raised_J));
  const double lost = lost_by_steps_J(start, now, line);
  keep(lost_J, lost);
  keep(made_J, -lost);
  keep(balance_error_J, std::abs(tandem::balance_error_J(start, now)));
}

}  // namespace tandem

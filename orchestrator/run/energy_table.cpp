#include "orchestrator/run/energy_table.h"

#include <fmt/format.h>

#include <string>

namespace tandem::orchestrator {
namespace {

std::string header() {
  std::string text = "macro_step,t_s";
  for (const char* side : {"mbs", "fem"}) {
    for (const char* column :
         {"kinetic_J", "potential_J", "elastic_J", "external_work_J", "interface_work_J",
          "damping_loss_J", "numerical_loss_J", "balance_error_J"}) {
      text += fmt::format(",{}.{}", side, column);
    }
  }
  return text + ",balance_error_J,interface_defect_J\n";
}

std::string columns(const EnergyBook& begin, const EnergyBook& now) {
  return fmt::format(",{},{},{},{},{},{},{},{}", now.kinetic_J, now.potential_J, now.elastic_J,
                     now.external_work_J, now.interface_work_J, now.damping_loss_J,
                     now.numerical_loss_J, balance_error_J(begin, now));
}

}  // namespace

void EnergyTable::write(const wire::StepRecord& step) {
  if (!step.energy) return;
  const SideEnergies& now = *step.energy;
  if (!file_) {
    file_.emplace(path_);
    file_->write(header());
    begin_ = now;
  }
  file_->write(
      fmt::format("{},{}", step.macro_step, to_seconds(step.time)) + columns(begin_.mbs, now.mbs) +
      columns(begin_.fem, now.fem) +
      fmt::format(",{},{}\n", balance_error_J(begin_.sum(), now.sum()), step.energy_defect_J));
}

void EnergyTable::flush() {
  if (file_) file_->flush();
}

}  // namespace tandem::orchestrator

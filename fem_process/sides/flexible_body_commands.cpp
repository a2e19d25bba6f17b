#include <fmt/format.h>

#include <string>

#include "fem_process/body/held.h"
#include "fem_process/sides/flexible_body.h"
#include "fem_process/transient/step_energy.h"
#include "protocol/contract/error.h"

namespace tandem::fem {

/// Divides the model's nodes anew and makes what depends on it. Throws before anything is changed.
void FlexibleBody::hold(const std::vector<std::string>& sets) {
  const auto divide = [this](const std::vector<std::string>& names) {
    std::vector<SetName> held;
    for (const std::string& name : names) held.push_back({.name = name});
    model_.hold(held);
  };
  divide(sets);
  if (!model_.integrator->inertia()) {
    try {
      require_held(model_);
    } catch (const Error&) {
      divide(held_);
      throw;
    }
  }
  held_ = sets;
  kept_ = {};  // their solvers refer to the step
  step_.emplace(model_, arms_);
}

CommandResult FlexibleBody::command(const std::string& text) {
  const double begin_s = now_s();
  CommandResult result;
  try {
    require(step_.has_value(), "fem: a command before initialize.");
    const Boundary after = changed(state_.boundary, text, model_.mesh);
    const bool divides = after.fixed != state_.boundary.fixed;
    if (divides) hold(after.fixed);
    if (state_.support.size() > 0) {
      // The forces that the state is in balance with stay those of before.
      Eigen::VectorXd forces = Eigen::VectorXd::Zero(state_.x.size());
      add_forces(after, model_.mesh, forces);
      state_.support -= forces;
      forces.setZero();
      add_forces(state_.boundary, model_.mesh, forces);
      state_.support += forces;
    }
    state_.boundary = after;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::Usage) throw;
    result.message = error.what();
    return result;
  }
  const double kinetic_J = kinetic_energy_J(model_, state_.v);
  const SolveReport report = step_->restart(state_);
  // The ground takes the motion of a set that is fixed.
  state_.book.damping_loss_J += kinetic_J - kinetic_energy_J(model_, state_.v);
  if (report.outcome != Outcome::Done) {
    throw Error(ErrorKind::NotSolved,
                "fem: at t = " + fmt::format("{:.6g}", to_seconds(state_.time)) +
                    " s: accelerations after '" + text + "': " + report.message);
  }
  state_.generation = ++generations_;
  step_->prepare(state_, kept_[0]);
  result.accepted = true;
  result.cost.compute_s = now_s() - begin_s;
  result.message = text + " at t = " + fmt::format("{:.6g}", to_seconds(state_.time)) +
                   " s: " + std::to_string(model_.free.size()) + " nodes free, " +
                   std::to_string(model_.prescribed.size()) + " held or following ports; " +
                   fmt::format("{:.3g}", 1e3 * result.cost.compute_s) + " ms";
  return result;
}

/// Walks through the scenario's changes, so that a wrong one is found before the run.
void FlexibleBody::check_changes() {
  Boundary boundary{.fixed = held_};
  for (const ScheduledChange& change : model_.params.changes) {
    try {
      boundary = changed(boundary, change.command, model_.mesh);
      std::vector<SetName> held;
      for (const std::string& name : boundary.fixed) held.push_back({.name = name});
      model_.hold(held);
      if (!model_.integrator->inertia()) require_held(model_);
    } catch (const Error& error) {
      throw Error(error.kind(), (change.place.file.empty() ? "" : change.place.text() + ": ") +
                                    std::string(error.what()));
    }
  }
  if (!model_.params.changes.empty()) model_.hold(model_.params.fixed);
}

void FlexibleBody::make_scheduled_changes() {
  const std::vector<ScheduledChange>& changes = model_.params.changes;
  for (auto next = static_cast<std::size_t>(state_.boundary.scheduled);
       next < changes.size() && changes[next].at <= state_.time; ++next) {
    const int done = state_.boundary.scheduled + 1;
    const CommandResult result = command(changes[next].command);
    require(result.accepted, changes[next].place.text() + ": " + result.message);
    state_.boundary.scheduled = done;
  }
}

}  // namespace tandem::fem

#include <utility>

#include "fem_process/solvers/nearby_solver.h"
#include "fem_process/transient/step_matrix.h"
#include "fem_process/transient/transient_step.h"
#include "protocol/contract/cost.h"

/// Forces, stiffness and factorised matrix that a step starts from.
namespace tandem::fem {

StepTimes TransientStep::linearise(const State& begin, double h_s, Linearisation& kept) const {
  if (kept.generation == begin.generation && kept.h_s == h_s && kept.generation != 0) return {};
  kept.generation = begin.generation;
  kept.h_s = h_s;
  kept.carried = carry_->begin(begin, h_s);
  kept.map = kept.carried.map;
  kept.has_correction = false;
  if (balances_angular()) {
    const auto times_M = [this](const Eigen::VectorXd& x) {
      return multiply_scalar(model_.pattern(), model_.mass, x);
    };
    kept.momentum = times_M(begin.v);
    if (carry_->rotates()) kept.behind = times_M(begin.x - kept.carried.begin.x);
  }
  StepTimes times = linearise_at_tilde(kept.carried, kept);
  if (remembers()) {
    const double start_s = now_s();
    multiply_eight(model_.interior.pattern, kept.S, begin.past, kept.S_past, *model_.team);
    times.factorize_s += now_s() - start_s;
  }
  return times;
}

/// f_int, K and the factorised step matrix at x̃ of the map.
StepTimes TransientStep::linearise_at_tilde(const Carried& carried, Linearisation& kept) const {
  const double start_s = now_s();
  kept.stands_in = false;
  kept.inverted_elements = model_.formulation->evaluate(kept.map.x_tilde, kept.f_int, kept.K);
  kept.f_mean = kept.f_int;
  carry_->take_mean(carried, kept.f_mean);
  const double middle_s = now_s();
  factorize(kept);
  if (kept.factorisation.outcome == Outcome::Failed && definite_) stand_in(kept);
  return {.elements_s = middle_s - start_s, .factorize_s = now_s() - middle_s};
}

/// The paper's simplified tangent, which is always positive semidefinite, in place of the exact
/// one.
void TransientStep::stand_in(Linearisation& kept) const {
  Eigen::VectorXd f_int;
  definite_->evaluate(kept.map.x_tilde, f_int, kept.K);
  kept.stands_in = true;
  factorize(kept);
}

void TransientStep::factorize(Linearisation& kept) const {
  step_matrix(kept.map, kept.K, kept.S);
  if (kept.neighbour != nullptr) {
    lean_on_neighbour(kept);
  } else if (!kept.solver) {
    kept.solver =
        make_solver(model_.params.solver, model_.interior.pattern, rest_.get(), model_.team.get());
  }
  // The linear formulation's stiffness does not turn with the nodes.
  const bool warped = rest_ && model_.params.formulation != FormulationKind::Linear &&
                      model_.params.solver.preconditioner != PreconditionerKind::RestFactor;
  kept.rotations.clear();
  if (warped || kept.neighbour != nullptr)
    node_rotations_.at(kept.map.x_tilde, kept.rotations, *model_.team);
  kept.factorisation = kept.solver->factorize(kept.S, kept.rotations);
  if (!loose_.empty() && kept.factorisation.outcome == Outcome::Done) {
    kept.factorisation = find_port_columns(kept);
  }
}

Eigen::VectorXd TransientStep::turning(const Linearisation& at, const Eigen::VectorXd& x,
                                       const Eigen::VectorXd& y, const Eigen::VectorXd& dx) const {
  if (!at.stands_in) return model_.formulation->derivative(x, y, dx);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(y.size());
  return model_.formulation->derivative(x, none, dx) + definite_->derivative(x, y, dx) -
         definite_->derivative(x, none, dx);
}

/// The nodes' rotations at the neighbour are found when first needed.
void TransientStep::lean_on_neighbour(Linearisation& kept) const {
  Linearisation& neighbour = *kept.neighbour;
  if (neighbour.rotations.empty()) {
    node_rotations_.at(neighbour.map.x_tilde, neighbour.rotations, *model_.team);
  }
  kept.solver = std::make_unique<NearbySolver>(model_.interior.pattern, *neighbour.solver,
                                               neighbour.rotations, model_.team.get());
}

/// Z and Y of LoosePorts.
SolveReport TransientStep::find_port_columns(Linearisation& kept) const {
  kept.port_columns = loose_.columns();
  const Eigen::VectorXd norms = kept.port_columns.colwise().norm();
  const SolveReport report = kept.solver->solve(kept.port_columns, norms);
  kept.port_response = loose_.coordinates_of(kept.port_columns);
  return report;
}

}  // namespace tandem::fem

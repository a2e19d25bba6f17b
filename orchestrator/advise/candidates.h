#pragma once

#include <string>
#include <vector>

#include "orchestrator/advise/load_trial.h"

namespace tandem::orchestrator {

/// The integrators of both sides. Of second order is the pair that docs/coupling.md recommends for
/// stiff parts that turn, generalised-α on both sides; where the flexible side has one integrator
/// (chains) or carries no mass of its own (nodal coupling, statics), Verlet on the multibody side.
struct IntegratorPair {
  std::string name = "own";  ///< "own" (the scenario's), "first order", "second order"
  int order = 1;             ///< of a converged macro step
  Settings settings;         ///< none for the scenario's own
};

/// The scenario's own pair, and the others that its sides allow, the one of second order first.
[[nodiscard]] std::vector<IntegratorPair> integrator_pairs(const Model& model);

/// A scheme with a pair of integrators.
struct Candidate {
  std::string scheme;
  IntegratorPair pair;
  Settings settings;  ///< of both
  [[nodiscard]] std::string name() const;
  /// Whether a macro step is iterated until the residual has converged: the error is that of the
  /// integrators then, whatever the scheme.
  [[nodiscard]] bool converges() const;
};

/// `scheme` with `pair`. The iterated scheme takes the quasi-Newton accelerator, which needs the
/// fewest evaluations, unless it is the scenario's own.
[[nodiscard]] Candidate make_candidate(const Model& model, const std::string& scheme,
                                       const IntegratorPair& pair);

/// One thing to try about how the steps are solved. It changes the cost and not the solution: inner
/// tolerances are a tenth of the coupling's relative one.
struct SolverChange {
  std::string name;
  Settings settings;
};

/// What can be tried on a model that has the candidate's settings, the most promising first.
[[nodiscard]] std::vector<SolverChange> solver_changes(const Model& model);

/// The settings that make the scenario what it is where trials change it by themselves: its
/// adaptive steps.
[[nodiscard]] Settings own_settings(const Model& model);

/// run.macro_step_s, and the sides' micro steps where the scenario sets them: as many in a macro
/// step as it has.
[[nodiscard]] Settings step_settings(const Model& model, double step_s);

}  // namespace tandem::orchestrator

#pragma once

#include <vector>

#include "protocol/scenario/node.h"
#include "protocol/scenario/scenario_file.h"

namespace tandem::orchestrator {

/// What a scenario leaves open of the numbers and methods that have to fit each other, chosen from
/// run.accuracy, a: the part of the largest wrench up to now that the iterations of a macro step
/// may leave in it.
///
/// | key | chosen | when |
/// |---|---|---|
/// | coupling.relative_tolerance | a/10; a/100 with `implicit`, whose error is several times its
///   residual | a scheme that iterates |
/// | fem.solver.kind | `pcg`; `cholmod` where its factor serves columns of loose ports, where the
///   matrix may be indefinite (exact tangents) or is solved once (statics), with a < 1e-8 |
///   left out or `automatic` |
/// | fem.solver.tolerance | 1e-4 a, 1e-13 to 1e-10: what PCG leaves in the wrench is below what the
///   iterations see | `pcg` |
/// | coupling.jacobian.fem_refresh | `broyden`; `every_step` with a < 1e-8 | `automatic`, one solid
///   on a mesh, interface_jacobian |
///
/// A pure function of the scenario, so that a run, its processes and its replay agree.
/// run.accuracy: 1e-10 chooses what is exact: factorisations, fresh Jacobians, 1e-11 of the wrench.
[[nodiscard]] std::vector<scenario::Override> chosen_settings(const scenario::Node& root);

/// "accuracy 1e-06: coupling.relative_tolerance 1e-07, fem.solver.kind pcg, …"; empty: nothing was
/// left open.
[[nodiscard]] std::string text_of(const std::vector<scenario::Override>& chosen);

}  // namespace tandem::orchestrator

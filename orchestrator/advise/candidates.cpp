#include "orchestrator/advise/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orchestrator/verdict/run_books.h"

namespace tandem::orchestrator {
namespace {

/// Whether the flexible side has no integrator to choose.
bool one_integrator(const scenario::Node& fem) {
  return fem.text("model") == "ancf" || fem.text("coupling") == "nodal" ||
         fem.section("integrator").text("kind") == "quasi_static";
}

bool has_linear_solver(const scenario::Node& fem) {
  return fem.text("model") != "ancf" && fem.text("coupling") != "nodal" &&
         fem.text("formulation") != "craig_bampton";
}

/// The other linear solver than the one that the model has.
SolverChange other_solver(const Model& model) {
  const scenario::Node solver = model.scenario.root.section("fem").section("solver");
  // As a whole: keys of PCG alone are refused beside another kind.
  if (solver.text("kind") == "pcg") return {"CHOLMOD", {"fem.solver={kind: cholmod}"}};
  // Its tolerance follows from run.accuracy.
  return {"PCG", {"fem.solver.kind=pcg"}};
}

/// In place of the whole section where it may hold keys of another integrator alone, which are
/// refused beside this one.
Settings generalised_alpha(const scenario::Node& fem) {
  const scenario::Node own = fem.section("integrator");
  if (own.text("kind") == "backward_euler") {
    return {"fem.integrator.kind=generalised_alpha", "fem.integrator.rho_infinity=0.8"};
  }
  return {
      fmt::format("fem.integrator={{kind: generalised_alpha, rho_infinity: 0.8, newton_steps: "
                  "{}, newton_tolerance: {}}}",
                  own.integer("newton_steps"), own.real("newton_tolerance"))};
}

/// In place of the whole section: keys of another integrator alone are refused beside this one.
std::string backward_euler(const scenario::Node& fem) {
  const scenario::Node own = fem.section("integrator");
  return fmt::format(
      "fem.integrator={{kind: backward_euler, newton_steps: {}, newton_tolerance: {}}}",
      own.integer("newton_steps"), own.real("newton_tolerance"));
}

/// Whether a macro step is several micro steps of the flexible side.
bool has_micro_steps(const Model& model) {
  const scenario::Node fem = model.scenario.root.section("fem");
  return fem.has("micro_step_s") &&
         fem.real("micro_step_s") < 0.999 * to_seconds(model.run.macro_step);
}

/// The other way to keep the flexible side's interface Jacobian.
SolverChange other_refresh(const Model& model) {
  const Refresh now = model.coupling.jacobian.fem_refresh;
  const bool kept = now == Refresh::Automatic ? has_micro_steps(model) : now != Refresh::EveryStep;
  return {kept ? "Jacobian at every step" : "Broyden's Jacobian",
          {std::string("coupling.jacobian.fem_refresh=") + (kept ? "every_step" : "broyden")}};
}

}  // namespace

std::vector<IntegratorPair> integrator_pairs(const Model& model) {
  const scenario::Node& root = model.scenario.root;
  const bool one = one_integrator(root.section("fem"));
  const bool rigid_second = root.section("mbs").text("integrator") != "euler";
  const bool flexible_second = is_second_order(root.section("fem"));
  const bool second = rigid_second && (one || flexible_second);
  const bool first = !rigid_second && (one || !flexible_second);
  std::vector<IntegratorPair> pairs = {{.name = "own", .order = second ? 2 : 1, .settings = {}}};
  if (!second) {
    pairs.push_back(
        {.name = "second order",
         .order = 2,
         .settings = one ? Settings{"mbs.integrator=verlet"}
                         : joined({"mbs.integrator=generalised_alpha", "mbs.rho_infinity=0.8"},
                                  generalised_alpha(root.section("fem")))});
  }
  if (!first) {
    pairs.push_back({.name = "first order", .order = 1, .settings = {"mbs.integrator=euler"}});
    if (!one) pairs.back().settings.push_back(backward_euler(root.section("fem")));
  }
  return pairs;
}

std::string Candidate::name() const {
  return pair.name == "own" ? scheme : scheme + ", " + pair.name;
}

bool Candidate::converges() const { return scheme == "implicit" || scheme == "interface_jacobian"; }

Candidate make_candidate(const Model& model, const std::string& scheme,
                         const IntegratorPair& pair) {
  Candidate candidate{.scheme = scheme, .pair = pair, .settings = {}};
  if (scheme != to_string(model.coupling.scheme)) {
    candidate.settings.push_back("coupling.scheme=" + scheme);
    if (scheme == "implicit") candidate.settings.emplace_back("coupling.relaxation=iqn_ils");
  }
  candidate.settings = joined(std::move(candidate.settings), pair.settings);
  return candidate;
}

std::vector<SolverChange> solver_changes(const Model& model) {
  std::vector<SolverChange> changes;
  if (has_linear_solver(model.scenario.root.section("fem"))) changes.push_back(other_solver(model));
  if (model.coupling.scheme == SchemeKind::InterfaceNewton) changes.push_back(other_refresh(model));
  return changes;
}

Settings own_settings(const Model& model) {
  if (!model.coupling.adaptive.active()) return {};
  return {fmt::format("coupling.adaptive.tolerance={}", model.coupling.adaptive.tolerance)};
}

Settings step_settings(const Model& model, double step_s) {
  Settings settings = {fmt::format("run.macro_step_s={}", step_s)};
  for (const std::string side : {"mbs", "fem"}) {
    const scenario::Node node = model.scenario.root.section(side);
    if (!node.has("micro_step_s")) continue;
    const double micro_steps =
        std::round(to_seconds(model.run.macro_step) / node.real("micro_step_s"));
    settings.push_back(fmt::format("{}.micro_step_s={}", side, step_s / micro_steps));
  }
  return settings;
}

}  // namespace tandem::orchestrator

#include "orchestrator/advise/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orchestrator/verdict/run_books.h"

namespace tandem::orchestrator {
namespace {

/// The section of every flexible body.
std::vector<scenario::Node> fems_of(const Model& model) {
  std::vector<scenario::Node> fems;
  for (const scenario::FlexibleBody& body : model.bodies) fems.push_back(body.root.section("fem"));
  return fems;
}

/// Those of them that `is_so`.
template <class Is>
std::vector<scenario::Node> those(std::vector<scenario::Node> fems, const Is& is_so) {
  std::erase_if(fems, [&](const scenario::Node& fem) { return !is_so(fem); });
  return fems;
}

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
SolverChange other_solver(const std::vector<scenario::Node>& bodies) {
  const bool pcg = bodies.front().section("solver").text("kind") == "pcg";
  SolverChange change{pcg ? "CHOLMOD" : "PCG", {}};
  for (const scenario::Node& fem : bodies) {
    // As a whole: keys of PCG alone are refused beside another kind. PCG's tolerance follows from
    // run.accuracy.
    change.settings.push_back(pcg ? fem.path_name("solver") + "={kind: cholmod}"
                                  : fem.path_name("solver.kind") + "=pcg");
  }
  return change;
}

/// In place of the whole section where it may hold keys of another integrator alone, which are
/// refused beside this one.
Settings generalised_alpha(const scenario::Node& fem) {
  const scenario::Node own = fem.section("integrator");
  if (own.text("kind") == "backward_euler") {
    return {own.path_name("kind") + "=generalised_alpha", own.path_name("rho_infinity") + "=0.8"};
  }
  return {
      fmt::format("{}={{kind: generalised_alpha, rho_infinity: 0.8, newton_steps: {}, "
                  "newton_tolerance: {}}}",
                  own.path_name(), own.integer("newton_steps"), own.real("newton_tolerance"))};
}

/// In place of the whole section: keys of another integrator alone are refused beside this one.
std::string backward_euler(const scenario::Node& fem) {
  const scenario::Node own = fem.section("integrator");
  return fmt::format("{}={{kind: backward_euler, newton_steps: {}, newton_tolerance: {}}}",
                     own.path_name(), own.integer("newton_steps"), own.real("newton_tolerance"));
}

/// Whether a macro step is several micro steps of a flexible body.
bool has_micro_steps(const Model& model) {
  const std::vector<scenario::Node> bodies = fems_of(model);
  return std::any_of(bodies.begin(), bodies.end(), [&](const scenario::Node& fem) {
    return fem.has("micro_step_s") &&
           fem.real("micro_step_s") < 0.999 * to_seconds(model.run.macro_step);
  });
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
  const std::vector<scenario::Node> worlds = mbs_sections(model);
  const std::vector<scenario::Node> open =
      those(fems_of(model), [](const scenario::Node& fem) { return !one_integrator(fem); });
  const bool one = open.empty();
  const auto euler = [](const scenario::Node& mbs) { return mbs.text("integrator") == "euler"; };
  const bool rigid_second = std::none_of(worlds.begin(), worlds.end(), euler);
  const bool rigid_first = std::all_of(worlds.begin(), worlds.end(), euler);
  const bool flexible_second = std::all_of(open.begin(), open.end(), is_second_order);
  const bool second = rigid_second && (one || flexible_second);
  const bool flexible_first = std::none_of(open.begin(), open.end(), is_second_order);
  const bool first = rigid_first && (one || flexible_first);
  std::vector<IntegratorPair> pairs = {{.name = "own", .order = second ? 2 : 1, .settings = {}}};
  if (!second) {
    Settings settings;
    for (const scenario::Node& mbs : worlds) {
      const std::string key = mbs.path_name("integrator");
      settings.push_back(key + (one ? "=verlet" : "=generalised_alpha"));
      if (!one) settings.push_back(mbs.path_name("rho_infinity") + "=0.8");
    }
    for (const scenario::Node& fem : open) {
      settings = joined(std::move(settings), generalised_alpha(fem));
    }
    pairs.push_back({.name = "second order", .order = 2, .settings = std::move(settings)});
  }
  if (!first) {
    pairs.push_back({.name = "first order", .order = 1, .settings = {}});
    for (const scenario::Node& mbs : worlds) {
      pairs.back().settings.push_back(mbs.path_name("integrator") + "=euler");
    }
    for (const scenario::Node& fem : open) {
      pairs.back().settings.push_back(backward_euler(fem));
    }
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
  const std::vector<scenario::Node> solving = those(fems_of(model), has_linear_solver);
  if (!solving.empty()) changes.push_back(other_solver(solving));
  if (model.coupling.scheme == SchemeKind::InterfaceNewton) changes.push_back(other_refresh(model));
  return changes;
}

Settings own_settings(const Model& model) {
  if (!model.coupling.adaptive.active()) return {};
  return {fmt::format("coupling.adaptive.tolerance={}", model.coupling.adaptive.tolerance)};
}

Settings step_settings(const Model& model, double step_s) {
  Settings settings = {fmt::format("run.macro_step_s={}", step_s)};
  std::vector<scenario::Node> sides = mbs_sections(model);
  for (const scenario::Node& fem : fems_of(model)) sides.push_back(fem);
  for (const scenario::Node& node : sides) {
    if (!node.has("micro_step_s")) continue;
    const double micro_steps =
        std::round(to_seconds(model.run.macro_step) / node.real("micro_step_s"));
    settings.push_back(fmt::format("{}={}", node.path_name("micro_step_s"), step_s / micro_steps));
  }
  return settings;
}

}  // namespace tandem::orchestrator

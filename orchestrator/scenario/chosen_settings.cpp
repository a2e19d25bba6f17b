#include "orchestrator/scenario/chosen_settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <string>

#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/flexible_bodies.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem::orchestrator {
namespace {

/// Below this PCG would have to solve to round-off, and secants would not pay.
constexpr double kExact = 1e-8;
constexpr double kFinestSolver = 1e-13;
/// What PCG leaves is a part of the momenta of all nodes, which in a stiff body may be far more
/// than the wrench; and a few more iterations cost less than those of the coupling that it
/// disturbs.
constexpr double kCoarsestSolver = 1e-10;

bool iterates(SchemeKind scheme) {
  return scheme == SchemeKind::InterfaceNewton || scheme == SchemeKind::Implicit;
}

double tolerance_of(SchemeKind scheme, double accuracy) {
  return (scheme == SchemeKind::InterfaceNewton ? 0.1 : 0.01) * accuracy;
}

bool on_mesh(const scenario::Node& fem) { return fem.text("model") != "ancf"; }

/// Whether conjugate gradients solve the steps of the scenario's body fastest.
bool suits_pcg(const scenario::Node& root) {
  const scenario::Node fem = root.section("fem");
  if (fem.text("formulation") != "corotational" || fem.text("coupling") == "nodal") return false;
  if (fem.section("integrator").text("kind") == "quasi_static") return false;
  const std::vector<scenario::PortParams> ports = scenario::read_ports(root);
  return std::none_of(ports.begin(), ports.end(),
                      [](const scenario::PortParams& port) { return port.attachment.loose(); });
}

using Choose = std::function<void(const std::string& key, const std::string& value)>;

/// What a body on a mesh leaves open of its solver.
void choose_solver(const scenario::Node& root, double accuracy, const Choose& choose) {
  const scenario::Node fem = root.section("fem");
  const scenario::Node solver = fem.section("solver");
  std::string kind = solver.text("kind");
  if (kind == "automatic") {
    kind = accuracy >= kExact && suits_pcg(root) ? "pcg" : "cholmod";
    choose(solver.path_name("kind"), kind);
  }
  if (kind == "pcg" && !solver.has("tolerance")) {
    choose(solver.path_name("tolerance"),
           fmt::format("{:.12g}", std::clamp(1e-4 * accuracy, kFinestSolver, kCoarsestSolver)));
  }
}

}  // namespace

std::vector<scenario::Override> chosen_settings(const scenario::Node& root) {
  const double accuracy = root.section("run").real("accuracy");
  const CouplingParams coupling = read_coupling(root);
  std::vector<scenario::Override> chosen;
  const Choose choose = [&](const std::string& key, const std::string& value) {
    chosen.push_back({key, value, "run.accuracy"});
  };
  if (iterates(coupling.scheme) && !root.section("coupling").has("relative_tolerance")) {
    choose("coupling.relative_tolerance",
           fmt::format("{:.12g}", tolerance_of(coupling.scheme, accuracy)));
  }
  bool all_full = true;
  for (const scenario::FlexibleBody& body : scenario::flexible_bodies(root)) {
    const scenario::Node fem = body.root.section("fem");
    const bool is_full = on_mesh(fem) && fem.text("formulation") != "craig_bampton";
    if (is_full) choose_solver(body.root, accuracy, choose);
    all_full = all_full && is_full;
  }
  if (all_full && coupling.scheme == SchemeKind::InterfaceNewton &&
      coupling.jacobian.fem_refresh == Refresh::Automatic && accuracy >= kExact) {
    choose("coupling.jacobian.fem_refresh", "broyden");
  }
  return chosen;
}

std::string text_of(const std::vector<scenario::Override>& chosen) {
  std::vector<std::string> words;
  for (const scenario::Override& setting : chosen) {
    words.push_back(setting.path + " " + setting.value);
  }
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace tandem::orchestrator

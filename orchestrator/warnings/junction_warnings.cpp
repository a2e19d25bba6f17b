#include "orchestrator/warnings/junction_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace tandem::orchestrator {
namespace {

constexpr double kUnlike = 100.0;

}  // namespace

void add_held(const scenario::Node& part, const fem::Model& body, HeldMasses& held) {
  if (body.ports.empty()) return;
  const double mass_kg = std::accumulate(body.nodal_mass.begin(), body.nodal_mass.end(), 0.0);
  const double share_kg = mass_kg / static_cast<double>(body.ports.size());
  const std::vector<scenario::PortParams> params = scenario::read_ports(part);
  for (std::size_t i = 0; i < body.ports.size(); ++i) {
    HeldNear& near = held[params[i].body];
    near.mass_kg += share_kg;
    near.inertia_kg_m2 += share_kg * body.ports[i].length_m * body.ports[i].length_m;
  }
}

mbs::Params with_held(mbs::Params params, const HeldMasses& held) {
  for (mbs::BodyParams& body : params.bodies) {
    const auto found = held.find(body.name);
    if (!body.massless || found == held.end()) continue;
    body.massless = false;
    body.mass_kg = found->second.mass_kg;
    body.inertia_kg_m2.fill(0.0);
    std::fill_n(body.inertia_kg_m2.begin(), 3, found->second.inertia_kg_m2);
  }
  return params;
}

std::vector<Finding> unlike_stand_in(const Model& model, const mbs::Params& params,
                                     const fem::Model& body) {
  std::vector<Finding> findings;
  const bool matters = params.integrator != mbs::IntegratorKind::Euler ||
                       model.coupling.scheme == SchemeKind::Implicit;
  const scenario::Node mbs = model.scenario.root.section("mbs");
  if (!matters || !mbs.has("junctions")) return findings;
  HeldMasses held;
  add_held(model.scenario.root, body, held);
  for (const scenario::Node& junction : mbs.list("junctions")) {
    const auto found = held.find(junction.text("name"));
    if (found == held.end()) continue;
    const HeldNear& here = found->second;
    const double ratio = junction.real("stand_in_mass_kg") / here.mass_kg;
    if (ratio < kUnlike && ratio > 1.0 / kUnlike) continue;
    findings.push_back(finding_at(
        junction, "stand_in_mass_kg", "unlike_stand_in",
        fmt::format("stands in with {:.3g} kg where the flexible body holds {:.3g} kg. With "
                    "mbs.integrator of second order or coupling.scheme: implicit set it to about "
                    "{:.1g}, and stand_in_inertia_kg_m2 to about {:.1g}.",
                    junction.real("stand_in_mass_kg"), here.mass_kg, here.mass_kg,
                    here.inertia_kg_m2)));
  }
  return findings;
}

}  // namespace tandem::orchestrator

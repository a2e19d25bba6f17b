#include "orchestrator/scenario/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "fem_process/mesh/mesh.h"
#include "fem_process/sides/make_model.h"
#include "mbs_process/make_side.h"
#include "orchestrator/scenario/chosen_settings.h"
#include "orchestrator/scenario/nodal_scenario.h"
#include "orchestrator/scenario/scenario_table.h"
#include "protocol/contract/error.h"
#include "protocol/driver/composite_side.h"
#include "protocol/schemes/transmission_line.h"

namespace tandem::orchestrator {

namespace {

/// A scenario without the multibody side is one for `tandem fem`, which its defects do not say.
scenario::Loaded load_coupled(const std::filesystem::path& file,
                              const std::vector<scenario::Override>& overrides) {
  try {
    return scenario::load(file, scenario_table(), overrides);
  } catch (const Error& error) {
    const auto is_flexible_alone = [&] {
      try {
        return !scenario::load(file, fem_scenario_table(), overrides).root.has("mbs");
      } catch (const Error&) {
        return false;
      }
    };
    if (!is_flexible_alone()) throw;
    throw Error(error.kind(), fmt::format("{}\nWithout a section mbs it is a scenario of the "
                                          "flexible side alone: tandem fem {}",
                                          error.what(), file.string()));
  }
}

/// Also with the mesh's fingerprint, so that a run folder tells which mesh it is about, and with
/// what the scenario leaves open.
scenario::Loaded load_complete(const std::filesystem::path& file,
                               std::vector<scenario::Override> overrides,
                               std::vector<scenario::Override>& chosen) {
  overrides = with_nodes(file, std::move(overrides));
  scenario::Loaded loaded = load_coupled(file, overrides);
  require_mesh_file(loaded.root);
  chosen = chosen_settings(loaded.root);
  std::vector<scenario::Override> more = chosen;
  for (const scenario::FlexibleBody& body : scenario::flexible_bodies(loaded.root)) {
    const scenario::Node fem = body.root.section("fem");
    if (!fem.has("mesh") || fem.section("mesh").has("checksum")) continue;
    const std::string checksum = fem::mesh_checksum(fem.section("mesh").path("file"));
    // In quotes: digits alone would be a number.
    if (!checksum.empty()) more.push_back({fem.path_name("mesh.checksum"), "'" + checksum + "'"});
  }
  if (more.empty()) return loaded;
  overrides.insert(overrides.end(), more.begin(), more.end());
  return scenario::load(file, scenario_table(), overrides);
}

/// Adaptive steps are whole multiples of the shortest, which has to be one of the micro steps.
void check_adaptive(const Model& model) {
  const AdaptiveParams& params = model.coupling.adaptive;
  if (!params.active()) return;
  const scenario::Node& root = model.scenario.root;
  const scenario::Node adaptive = root.section("coupling").section("adaptive");
  const SimTime first = model.run.macro_step;
  const SimTime shortest = params.min_step.value_or(std::max(first / 32, SimTime(1)));
  if (params.min_step && first % shortest != SimTime{}) {
    adaptive.fail("min_step_s", "run.macro_step_s, the first step, is no whole multiple of it.");
  }
  if (params.max_step && *params.max_step < first) {
    adaptive.fail("max_step_s", "is shorter than run.macro_step_s, the first step. Raise it.");
  }
  std::vector<scenario::Node> sides = mbs_sections(model);
  for (const scenario::FlexibleBody& body : model.bodies) {
    sides.push_back(body.root.section("fem"));
  }
  for (const scenario::Node& side : sides) {
    if (!side.has("micro_step_s")) continue;
    const SimTime h = sim_time_from_seconds(side.real("micro_step_s"));
    if (shortest % h == SimTime{}) continue;
    adaptive.fail("min_step_s",
                  fmt::format("the shortest macro step, {} s, is no whole multiple of {} = {}. "
                              "Write one here.",
                              to_seconds(shortest), side.path_name("micro_step_s"), to_seconds(h)));
  }
}

/// A junction has no mass that could follow a wrench which is predicted.
void check_junctions(const Model& model) {
  if (!has_junctions(model)) return;
  const SchemeKind scheme = model.coupling.scheme;
  if (scheme == SchemeKind::InterfaceNewton || scheme == SchemeKind::Implicit) return;
  model.scenario.root.section("coupling")
      .fail("scheme",
            fmt::format("{} steps with wrenches that are not in balance, and mbs.junctions "
                        "have no mass to take what is left. Use interface_jacobian or "
                        "implicit.",
                        to_string(scheme)));
}

}  // namespace

bool has_junctions(const Model& model) {
  const std::vector<scenario::Node> worlds = mbs_sections(model);
  return std::any_of(worlds.begin(), worlds.end(),
                     [](const scenario::Node& mbs) { return mbs.has("junctions"); });
}

std::vector<std::string> part_names(const Model& model) {
  std::vector<std::string> names;
  for (const auto* table : {&model.world_table, &model.table}) {
    if (table->size() < 2) continue;
    for (const scenario::BodyPorts& row : *table) names.push_back(row.name);
  }
  return names;
}

Model load_model(const std::filesystem::path& file,
                 const std::vector<scenario::Override>& overrides) {
  std::vector<scenario::Override> chosen;
  Model model{.scenario = load_complete(file, overrides, chosen)};
  model.chosen = std::move(chosen);
  const scenario::Node& root = model.scenario.root;
  model.name = root.text("name");
  model.run = scenario::read_run(root);
  model.coupling = read_coupling(root);
  model.table = scenario::body_table(root);
  model.bodies = scenario::flexible_bodies(root);
  model.world_table = scenario::world_table(root);
  model.worlds = scenario::multibody_worlds(root);
  check_adaptive(model);
  check_junctions(model);
  model.wire = read_wire(root);
  for (const scenario::PortParams& port : scenario::read_ports(root)) {
    model.port_names.push_back(port.name);
  }
  return model;
}

namespace {

/// Newton's method and the lines of tlm need the interface Jacobian, which a chain has over one
/// step of its own alone.
void require_derivative(const Model& model, const scenario::FlexibleBody& body) {
  const SchemeKind scheme = model.coupling.scheme;
  const scenario::Node fem = body.root.section("fem");
  const bool needed = scheme == SchemeKind::InterfaceNewton || scheme == SchemeKind::Tlm;
  if (!needed || fem.text("model") != "ancf" || !fem.has("micro_step_s")) return;
  if (sim_time_from_seconds(fem.real("micro_step_s")) == model.run.macro_step) return;
  fem.fail("micro_step_s",
           fmt::format("coupling.scheme: {} needs the body's interface Jacobian, which a chain has "
                       "not over several micro steps. Leave it out, lower run.macro_step_s, or use "
                       "coupling.scheme: implicit.",
                       to_string(scheme)));
}

}  // namespace

std::vector<scenario::Node> mbs_sections(const Model& model) {
  std::vector<scenario::Node> sections;
  for (const scenario::MultibodyWorld& world : model.worlds) {
    sections.push_back(world.root.section("mbs"));
  }
  return sections;
}

Model part_of(const Model& model, std::size_t body) {
  if (!model.scenario.root.holds_list("fem")) return model;
  Model part = model;
  part.scenario.root = model.bodies[body].root;
  part.port_names = of_ports(model.port_names, model.bodies[body].ports);
  scenario::BodyPorts row{.name = model.bodies[body].name, .ports = {}};
  for (std::size_t i = 0; i < part.port_names.size(); ++i) row.ports.push_back(i);
  part.table = {row};
  part.bodies = {{row.name, part.scenario.root, row.ports}};
  return part;
}

std::unique_ptr<MbsSide> make_mbs(const Model& model, const std::filesystem::path& directory) {
  std::vector<MbsPart> parts;
  for (const scenario::MultibodyWorld& world : model.worlds) {
    parts.push_back({world.name, make_mbs(model, world, directory), world.ports});
  }
  return composed(std::move(parts));
}

std::unique_ptr<MbsSide> make_mbs(const Model& model, const scenario::MultibodyWorld& world,
                                  const std::filesystem::path& directory) {
  return mbs::make_side(world.root, mbs::folder_of(directory, world.root, model.worlds.size()));
}

std::unique_ptr<FemSide> make_fem(const Model& model, const std::filesystem::path& directory) {
  std::vector<FemPart> parts;
  for (const scenario::FlexibleBody& body : model.bodies) {
    parts.push_back({body.name, make_fem(model, body, directory), body.ports});
  }
  return composed(std::move(parts));
}

std::unique_ptr<FemSide> make_fem(const Model& model, const scenario::FlexibleBody& body,
                                  const std::filesystem::path& directory) {
  require_derivative(model, body);
  const auto folder = fem::folder_of(directory, body.root, model.bodies.size());
  return prepared_for(model.coupling, fem::make_model(body.root, folder));
}

}  // namespace tandem::orchestrator

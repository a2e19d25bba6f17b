#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <vector>

#include "fem_process/ancf/ancf_keys.h"
#include "fem_process/ancf/beam_body.h"
#include "fem_process/body/flexible_side.h"
#include "fem_process/keys/fem_keys.h"
#include "fem_process/mesh/tet10.h"
#include "fem_process/reduced/highest_frequency.h"
#include "fem_process/sides/make_model.h"
#include "mbs_process/joint_drift.h"
#include "mbs_process/make_side.h"
#include "mbs_process/spring_stability.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/page/system_graph.h"
#include "orchestrator/scenario/chosen_settings.h"
#include "orchestrator/scenario/model.h"
#include "orchestrator/scenario/nodal_scenario.h"
#include "orchestrator/scenario/scenario_options.h"
#include "orchestrator/scenario/scenario_table.h"
#include "orchestrator/warnings/junction_warnings.h"
#include "orchestrator/warnings/material_warnings.h"
#include "orchestrator/warnings/warnings.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/driver/composite_side.h"

namespace tandem::orchestrator {
namespace {

const char* name_of(scenario::AttachmentKind kind) {
  switch (kind) {
    case scenario::AttachmentKind::Averaging:
      return "averaging";
    case scenario::AttachmentKind::Bushing:
      return "on a bushing";
    case scenario::AttachmentKind::Rigid:
      break;
  }
  return "rigid";
}

/// A port's nodes beside its origin, where that is known: a body or a mesh that is out of place
/// shows here. The length is what weighs rotations against translations in residuals.
std::string describe(const fem::Model& model, const fem::Model::Port& port, const Motion* motion) {
  std::string text = fmt::format("  port '{}': {} nodes, {}, length {:.3g} m", port.name,
                                 port.nodes.size(), name_of(port.attachment.kind), port.length_m);
  if (motion != nullptr) {
    const Eigen::Vector3d& p = motion->p_WP;
    double farthest_m = 0.0;
    for (int node : port.nodes) {
      farthest_m = std::max(farthest_m, (model.mesh.X[static_cast<std::size_t>(node)] - p).norm());
    }
    fmt::format_to(std::back_inserter(text),
                   ", up to {:.3g} m from its origin ({:.4g}, {:.4g}, "
                   "{:.4g}) m",
                   farthest_m, p.x(), p.y(), p.z());
  }
  return text + "\n";
}

/// Size and mass as the solver sees them: a wrong length scale or density shows here. `origins`:
/// the ports at t = 0, or none without a multibody side.
std::string describe(const fem::Model& model, const MotionSet& origins) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& X : model.mesh.X) box.extend(X);
  std::vector<double> volumes_m3(model.materials.list.size());
  std::vector<int> elements(volumes_m3.size());
  for (std::size_t e = 0; e < model.mesh.tets.size(); ++e) {
    volumes_m3[model.materials.index(e)] += fem::volume(model.mesh, e);
    ++elements[model.materials.index(e)];
  }
  const double volume_m3 = std::accumulate(volumes_m3.begin(), volumes_m3.end(), 0.0);
  const double mass_kg = std::accumulate(model.nodal_mass.begin(), model.nodal_mass.end(), 0.0);
  const Eigen::Vector3d size_m = box.sizes();
  std::string text = fmt::format(
      "  flexible body: {} nodes, {}{} elements, {:.4g} × {:.4g} × {:.4g} m, {:.4g} m³, {:.4g} "
      "kg\n",
      model.mesh.nodes(), model.mesh.tets.size(), model.mesh.second_order() ? " second-order" : "",
      size_m.x(), size_m.y(), size_m.z(), volume_m3, mass_kg);
  for (std::size_t s = 0; s < model.params.materials.size(); ++s) {
    fmt::format_to(std::back_inserter(text), "  material of '{}': {} elements, {:.4g} kg\n",
                   model.params.materials[s].set.name, elements[s],
                   volumes_m3[s] * model.materials.list[s].density_kg_per_m3);
  }
  for (std::size_t i = 0; i < model.ports.size(); ++i) {
    const bool placed = origins.size() == model.ports.size();
    text += describe(model, model.ports[i], placed ? &origins[i] : nullptr);
  }
  if (!model.fixed.empty()) {
    fmt::format_to(std::back_inserter(text), "  held: {} nodes\n", model.fixed.size());
  }
  if (model.params.nodal) {
    fmt::format_to(std::back_inserter(text),
                   "  nodal coupling: {} point masses in the multibody side, the highest at {:.4g} "
                   "Hz; explicit_serial is stable below {:.4g} s\n",
                   model.free.size(), fem::highest_angular_frequency(model) / (2.0 * EIGEN_PI),
                   fem::explicit_step_limit_s(model));
  }
  for (const std::string& note : model.mesh.notes) text += "  note: " + note + "\n";
  return text;
}

std::string describe(const fem::ancf::BeamParams& params, const fem::ancf::BeamSystem& system) {
  const auto warning = fem::ancf::bending_warning(params.model);
  return fmt::format(
             "  beams: {} elements of {:.4g} × {:.4g} × {:.4g} m, {} unknowns, {:.4g} kg, {} "
             "wheel(s), {} "
             "ground(s)\n",
             system.mesh().elements.size(), system.mesh().elements.front().length_m,
             params.model.section.width_m, params.model.section.height_m, system.mesh().unknowns(),
             system.mass_kg(), params.wheels.size(), params.grounds.size()) +
         (warning ? "  warning: " + *warning + "\n" : "");
}

std::string lines_of(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings) text += "  warning: " + finding.text + "\n";
  return text;
}

/// A scenario for `tandem fem` alone.
std::string check_flexible(const std::string& file, const scenario::Node& root) {
  require_one_body(root);
  if (root.section("fem").text("model") == "ancf") {
    const fem::ancf::BeamBody beams(fem::ancf::read_beam_params(root));
    return fmt::format("{}: good, for `tandem fem` (there is no section mbs)\n{}", file,
                       describe(beams.params(), beams.system())) +
           lines_of(implausible_chain_material(root));
  }
  const fem::Model model(fem::read_params(root));
  return fmt::format("{}: good, for `tandem fem` (there is no section mbs)\n{}", file,
                     describe(model, MotionSet{})) +
         lines_of(warnings_of(root, model));
}

bool has_fine_steps(const scenario::Node& mbs) {
  return mbs.has("micro_step_s") || mbs.text("integrator") != "euler";
}

/// What is said of the run as a whole may stand in `found` already.
void add_new(std::vector<Finding> findings, std::vector<Finding>& found) {
  for (Finding& finding : findings) {
    const bool known = std::any_of(found.begin(), found.end(), [&](const Finding& other) {
      return other.text == finding.text;
    });
    if (!known) found.push_back(std::move(finding));
  }
}

using WorldParams = std::map<std::string, mbs::Params>;

/// One of the flexible bodies, beside the worlds that carry it.
std::string describe_body(const Model& part, const MotionSet& origins, const WorldParams& worlds,
                          std::vector<Finding>& found, HeldMasses& held) {
  const auto fem = fem::make_model(part.scenario.root, {});
  std::string text;
  const auto* body = dynamic_cast<const fem::FlexibleSide*>(fem.get());
  if (body != nullptr) {
    text += describe(body->model(), origins);
    add_held(part.scenario.root, body->model(), held);
    if (body->model().params.nodal && has_fine_steps(part.scenario.root.section("mbs"))) {
      text +=
          "  note: with mbs.micro_step_s or mbs.integrator: verlet, explicit_serial is unstable at "
          "every step unless damping outweighs it; use interface_jacobian\n";
    }
  }
  for (const scenario::MultibodyWorld& world : scenario::worlds_at(part.scenario.root)) {
    Model seen = part;
    seen.scenario.root = world.root;
    add_new(warnings_of(seen, worlds.at(world.name), body == nullptr ? nullptr : &body->model(),
                        origins),
            found);
  }
  if (const auto* beams = dynamic_cast<const fem::ancf::BeamBody*>(fem.get())) {
    fem::ancf::check_overlap(beams->params(), origins);
    text += describe(beams->params(), beams->system());
  }
  return text;
}

/// Of several worlds: who is who, and which ports are whose.
std::string table_of_sides(const Model& model) {
  if (model.worlds.size() == 1) return {};
  std::string text;
  const auto add = [&](const char* program, const scenario::BodyPorts& side) {
    const std::string name = side.name.empty() ? "" : " '" + side.name + "'";
    text += fmt::format("  {}{}: {}\n", program, name,
                        fmt::join(of_ports(model.port_names, side.ports), ", "));
  };
  for (const scenario::BodyPorts& world : model.world_table) add("world", world);
  for (const scenario::BodyPorts& body : model.table) add("flexible body", body);
  return text;
}

std::string check_coupled(const ScenarioOptions& options) {
  const Model model = options.load();
  WorldParams worlds;
  for (const scenario::MultibodyWorld& world : model.worlds) {
    worlds.emplace(world.name, mbs::make_side(world.root, {})->params());
  }
  (void)make_fem(model, {});  // with what the scheme puts before it
  std::string text =
      fmt::format("{}: good. {} macro steps of {} s, {} port(s), scheme {}\n", options.file,
                  model.run.macro_steps(), to_seconds(model.run.macro_step),
                  model.port_names.size(), to_string(model.coupling.scheme));
  if (!model.chosen.empty()) text += "  chosen: " + text_of(model.chosen) + "\n";
  text += table_of_sides(model);
  const MotionSet origins = make_mbs(model, {})->initialize(WrenchSet(model.port_names.size()));
  std::vector<Finding> found;
  HeldMasses held;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (model.bodies.size() > 1) text += fmt::format("  '{}':\n", model.bodies[b].name);
    text += describe_body(part_of(model, b), of_ports(origins, model.bodies[b].ports), worlds,
                          found, held);
  }
  text += lines_of(found);
  for (const std::string& note : notes_of(model.coupling)) text += "  warning: " + note + "\n";
  for (const scenario::MultibodyWorld& world : model.worlds) {
    const mbs::Params& params = worlds.at(world.name);
    if (const auto warning = mbs::spring_warning(with_held(params, held)))
      text += "  warning: " + *warning + "\n";
    if (const auto warning = mbs::drift_warning(params, to_seconds(model.run.duration))) {
      text += "  warning: " + *warning + "\n";
    }
  }
  return text;
}

}  // namespace

void add_check(CLI::App& app) {
  auto options = std::make_shared<ScenarioOptions>();
  auto graph = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "check",
      "Validate a scenario with its mesh: file:line:column, what is wrong, what would be right");
  options->declare(*sub);
  sub->add_option("--graph", *graph,
                  "Also draw the system as an SVG file: bodies, joints, ports, processes");
  sub->callback([options, graph] {
    const scenario::Loaded loaded = scenario::load(options->file, fem_scenario_table(),
                                                   with_nodes(options->file, options->overrides()));
    require_mesh_file(loaded.root);
    const bool coupled = loaded.root.has("mbs");
    std::printf(
        "%s",
        (coupled ? check_coupled(*options) : check_flexible(options->file, loaded.root)).c_str());
    if (graph->empty()) return;
    require(coupled, "--graph: the scenario has no section mbs; one flexible body is no graph.");
    write_whole_file(*graph, svg_of(graph_of(options->load())));
  });
}

}  // namespace tandem::orchestrator

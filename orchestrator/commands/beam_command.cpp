#include "orchestrator/commands/beam_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <optional>
#include <vector>

#include "fem_process/ancf/ancf_keys.h"
#include "fem_process/ancf/beam_body.h"
#include "fem_process/ancf/beam_csv.h"
#include "fem_process/ancf/beam_modes.h"
#include "fem_process/ancf/beam_vtu.h"
#include "fem_process/output/vtk_xml.h"
#include "mbs_process/make_side.h"
#include "orchestrator/files/displacement_text.h"
#include "orchestrator/verdict/run_books.h"
#include "protocol/contract/error.h"
#include "protocol/driver/side_process.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::orchestrator {
namespace {

using fem::ancf::BeamBody;
using fem::ancf::BeamSystem;
using fem::ancf::WatchPoint;
using nlohmann::ordered_json;

ordered_json to_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Vector3d position(const BeamSystem& system, const WatchPoint& point,
                         const Eigen::VectorXd& q) {
  const double length = system.mesh().elements[static_cast<std::size_t>(point.element)].length_m;
  return system.mesh().gather(point.element, q) *
         fem::ancf::shape_values(length, point.xi, 0.0, 0.0);
}

/// Displacement (m) of every watched point.
ordered_json displacements(const BeamSystem& system, const std::vector<WatchPoint>& watch,
                           const Eigen::VectorXd& q) {
  ordered_json points = ordered_json::object();
  for (const WatchPoint& point : watch) {
    points[point.name] =
        to_json(position(system, point, q) - position(system, point, system.mesh().q0));
  }
  return points;
}

std::string in_words(const ordered_json& displacements_m) {
  return displacement_text("displacement", "fem.ancf.watch", displacements_m);
}

ordered_json heading(const scenario::Node& root, const BeamSystem& system,
                     const std::string& analysis) {
  return {{"tandem", kTandemVersion},
          {"scenario", root.text("name")},
          {"analysis", analysis},
          {"model", "ancf"},
          {"unknowns", system.mesh().unknowns()},
          {"elements", system.mesh().elements.size()},
          {"mass_kg", system.mass_kg()},
          {"status", "done"},
          {"message", ""}};
}

void book(const std::string& message, FemOutcome& outcome) {
  if (message.empty()) return;
  outcome.exit_code = 3;
  outcome.results["status"] = "not_converged";
  outcome.results["message"] = message;
}

FemOutcome run_static(const scenario::Node& root, const fem::StaticParams& params) {
  const fem::ancf::BeamParams beams = fem::ancf::read_beam_params(root);
  require(beams.wheels.empty() && beams.grounds.empty(),
          root.section("fem").place("ancf").text() +
              ": the static analysis of beams knows no contact. Use --analysis transient with "
              "fem.ancf.settle.");
  const BeamSystem system(beams.model);
  FemOutcome outcome{.results = heading(root, system, "static")};
  ordered_json& rows = outcome.results["load_steps"] = ordered_json::array();
  Eigen::VectorXd q = system.mesh().q0;
  for (double factor : params.load_factors) {
    const fem::ancf::Equilibrium found = fem::ancf::find_equilibrium(
        system, params.law_time_s, factor, beams.step.tolerance_m, params.max_iterations, q);
    if (!found.found) {
      book(fmt::format(
               "fem: no equilibrium at load factor {:g} after {} iterations, residual {:.3g} "
               "N. Raise fem.analysis.load_steps, or hold the chain where it may still move: free "
               "ends (fem.ancf.chain.left_support), or hinged ones that leave a straight chain "
               "free to spin about its line (clamp one of them).",
               factor, found.iterations, found.residual_N),
           outcome);
      break;
    }
    ordered_json row = {{"factor", factor},
                        {"iterations", found.iterations},
                        {"residual_N", found.residual_N},
                        {"displacement_m", displacements(system, beams.watch, q)}};
    std::printf("load factor %.5g: %d iterations, residual %.3g N, %s\n", factor, found.iterations,
                found.residual_N, in_words(row["displacement_m"]).c_str());
    rows.push_back(std::move(row));
  }
  return outcome;
}

FemOutcome run_modes(const scenario::Node& root, int count) {
  const BeamSystem system(fem::ancf::read_beam_params(root).model);
  FemOutcome outcome{.results = heading(root, system, "modes")};
  const Eigen::VectorXd frequencies =
      fem::ancf::eigenfrequencies_Hz(system, system.mesh().q0, count);
  outcome.results["frequencies_Hz"] = std::vector<double>(frequencies.begin(), frequencies.end());
  for (Eigen::Index i = 0; i < frequencies.size(); ++i) {
    std::printf("mode %3lld  %.8g Hz\n", static_cast<long long>(i + 1), frequencies(i));
  }
  return outcome;
}

/// Ports are held where their bodies are at t = 0, or where they say themselves.
MotionSet held_ports(const scenario::Node& root) {
  MotionSet motions;
  if (!root.has("ports")) return motions;
  const std::vector<scenario::PortParams> ports = scenario::read_ports(root);
  if (root.has("mbs")) {
    motions.resize(ports.size());
    for (const scenario::MultibodyWorld& world : scenario::multibody_worlds(root)) {
      const MotionSet own =
          mbs::make_side(world.root, {})->initialize(WrenchSet(world.ports.size()));
      for (std::size_t i = 0; i < own.size(); ++i) {
        motions[world.ports[i]] = {.p_WP = own[i].p_WP, .q_WP = own[i].q_WP};
      }
    }
    return motions;
  }
  for (const scenario::PortParams& port : ports) {
    require(!port.at_body_frame,
            port.place.text() + ": port '" + port.name +
                "' needs position_m: there is no section mbs whose body '" + port.body +
                "' would say where it stands. Add position_m: [x, y, z] to the port, or the "
                "section.");
    motions.push_back({.p_WP = port.p_WP, .q_WP = port.q_WP});
  }
  return motions;
}

FemOutcome run_transient(const scenario::Node& root, const std::filesystem::path& folder) {
  require(root.has("run"), root.place().text() +
                               ": a transient analysis needs the section 'run'. Add run: "
                               "{duration_s: …, macro_step_s: …}.");
  BeamBody body(fem::ancf::read_beam_params(root));
  FemOutcome outcome{.results = heading(root, body.system(), "transient")};
  std::optional<fem::VtuSeries> vtu;
  if (const std::int64_t every = scenario::read_output(root).vtu_every_steps; every > 0) {
    vtu.emplace(folder / "fem", "fem", every);
  }
  fem::ancf::BeamCsv csv(folder / "beam.csv", body.params().watch);
  ordered_json& history = outcome.results["history"];
  history["t_s"] = ordered_json::array();
  history["displacement_m"] = ordered_json::object();
  const auto record = [&] {
    history["t_s"].push_back(to_seconds(body.state().time));
    const ordered_json points = displacements(body.system(), body.params().watch, body.state().q);
    for (const auto& [name, u] : points.items()) history["displacement_m"][name].push_back(u);
    csv.write(body);
    if (vtu && vtu->wants_next()) vtu->write(body.state().time, fem::ancf::vtu_text(body));
  };
  const MotionSet held = held_ports(root);
  body.initialize(held);
  record();
  const scenario::RunParams run = scenario::read_run(root);
  BooksOfOneSide looked(body, run.macro_steps());
  for (std::int64_t step = 0; step < run.macro_steps(); ++step) {
    const StepResult<WrenchSet> result =
        body.advance({.step = run.macro_step, .input = {held, held}});
    book(result.message, outcome);
    if (result.outcome != Outcome::Done) break;
    record();
    looked.look(step + 1);
  }
  csv.finish();
  std::printf("%lld steps to t = %g s: %s\n", static_cast<long long>(history["t_s"].size()) - 1,
              to_seconds(body.state().time),
              in_words(displacements(body.system(), body.params().watch, body.state().q)).c_str());
  RunBooks books;
  books.fem_second_order = true;
  books.contact = !body.params().wheels.empty() || !body.params().grounds.empty();
  looked.add_to(books);
  add_verdict(books, outcome);
  return outcome;
}

}  // namespace

FemOutcome run_beams(const scenario::Node& root, const std::string& kind,
                     const fem::AnalysisParams& params, const std::filesystem::path& folder) {
  require(kind != "quasi_static", root.section("fem").place("model").text() +
                                      ": beams have no quasi_static analysis. Use static, or "
                                      "transient with fem.ancf.settle.");
  if (kind == "modes") return run_modes(root, params.modes);
  if (kind == "transient") return run_transient(root, folder);
  return run_static(root, params.statics);
}

}  // namespace tandem::orchestrator

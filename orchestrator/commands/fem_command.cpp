#include "orchestrator/commands/fem_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <vector>

#include "fem_process/keys/analysis_keys.h"
#include "fem_process/keys/fem_keys.h"
#include "fem_process/output/vtu_writer.h"
#include "fem_process/reduced/modal_analysis.h"
#include "fem_process/reduced/reduced_body.h"
#include "fem_process/sides/make_side.h"
#include "fem_process/transient/static_analysis.h"
#include "orchestrator/commands/beam_command.h"
#include "orchestrator/files/displacement_text.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/scenario/late_changes.h"
#include "orchestrator/scenario/nodal_scenario.h"
#include "orchestrator/scenario/scenario_table.h"
#include "orchestrator/verdict/run_books.h"
#include "orchestrator/verdict/verdict.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/driver/side_process.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

ordered_json to_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Mean displacement (m) of every watched set.
ordered_json displacements(const fem::Model& model, const Eigen::VectorXd& x) {
  ordered_json sets = ordered_json::object();
  for (const fem::SetName& name : model.params.watch) {
    sets[name.name] = to_json(fem::mean_displacement(model, name, x));
  }
  return sets;
}

std::string in_words(const ordered_json& displacements_m) {
  return displacement_text("mean displacement", "fem.watch", displacements_m);
}

ordered_json heading(const scenario::Node& root, const fem::Model& model,
                     const std::string& analysis) {
  return {{"tandem", kTandemVersion},
          {"scenario", root.text("name")},
          {"analysis", analysis},
          {"formulation", root.section("fem").text("formulation")},
          {"nodes", model.mesh.nodes()},
          {"elements", model.mesh.tets.size()},
          {"status", "done"},
          {"message", ""}};
}

/// The scenario's flexible body with its port nodes fixed.
fem::Params held_params(const scenario::Node& root) {
  fem::Params params = fem::read_params(root);
  for (fem::PortSet& port : params.ports) {
    require(!port.attachment.loose(),
            port.set.place.text() + ": port '" + port.name +
                "' is not rigid, and `tandem fem` holds and moves port nodes as rigid sets. Add "
                "--set ports." +
                port.name + ".attachment=rigid, or use `tandem run`.");
    params.fixed.push_back(std::move(port.set));
  }
  params.ports.clear();
  params.nodal = false;  // alone, the flexible side has its own masses
  return params;
}

/// The same with the moved sets as ports.
fem::Params moved_params(const scenario::Node& root, const std::vector<fem::SetMotion>& motions) {
  fem::Params params = held_params(root);
  for (const fem::SetMotion& motion : motions) {
    std::erase_if(params.fixed,
                  [&](const fem::SetName& set) { return set.name == motion.set.name; });
    params.ports.push_back({motion.set.name, motion.set, motion.about_m});
  }
  return params;
}

void book(const std::string& message, FemOutcome& outcome) {
  if (message.empty()) return;
  outcome.exit_code = 3;
  outcome.results["status"] = "not_converged";
  outcome.results["message"] = message;
}

/// Static load steps by the full model, or in the modes of the reduced one.
fem::StaticResult solve_static(const fem::Model& model, const fem::StaticParams& params,
                               const std::function<void(const fem::LoadStep&)>& observer) {
  if (model.params.formulation != fem::FormulationKind::CraigBampton) {
    return fem::StaticAnalysis(model, params).run(observer);
  }
  fem::check(params);
  const fem::BoundaryModes modes = fem::fixed_boundary_modes(model, model.params.craig_bampton);
  const fem::ReducedModel reduced(model, modes, {});
  fem::StaticResult result;
  for (double factor : params.load_factors) {
    result.steps.push_back(
        {.factor = factor, .iterations = 1, .x = reduced.equilibrium(factor, params.law_time_s)});
    observer(result.steps.back());
  }
  return result;
}

FemOutcome run_static(const scenario::Node& root, const fem::StaticParams& params,
                      const std::filesystem::path& folder) {
  const fem::Model model(held_params(root));
  FemOutcome outcome{.results = heading(root, model, "static")};
  fem::VtuWriter vtu(model, folder / "fem", "fem", 1);
  ordered_json& rows = outcome.results["load_steps"] = ordered_json::array();
  const fem::StaticResult result = solve_static(model, params, [&](const fem::LoadStep& step) {
    ordered_json row = {{"factor", step.factor},
                        {"iterations", step.iterations},
                        {"line_search", step.searched},
                        {"cuts", step.cuts},
                        {"residual", step.residual},
                        {"inverted_elements", step.inverted_elements},
                        {"displacement_m", displacements(model, step.x)}};
    std::printf("load factor %.5g: %d iterations, residual %.3g of the load, %s\n", step.factor,
                step.iterations, step.residual, in_words(row["displacement_m"]).c_str());
    rows.push_back(std::move(row));
    // The collection's time is the load factor.
    vtu.write({.time = sim_time_from_seconds(step.factor),
               .x = step.x,
               .v = Eigen::VectorXd::Zero(step.x.size())});
  });
  book(result.report.message, outcome);
  return outcome;
}

FemOutcome run_modes(const scenario::Node& root, int count, const std::filesystem::path& folder) {
  const fem::Model model(held_params(root));
  FemOutcome outcome{.results = heading(root, model, "modes")};
  const fem::Modes modes = fem::lowest_modes(model, count);
  outcome.results["frequencies_Hz"] =
      std::vector<double>(modes.frequencies_Hz.begin(), modes.frequencies_Hz.end());
  fem::VtuWriter vtu(model, folder / "fem", "mode", 1);
  const Eigen::VectorXd X = model.reference();
  for (Eigen::Index i = 0; i < modes.shapes.cols(); ++i) {
    std::printf("mode %3lld  %.8g Hz\n", static_cast<long long>(i + 1), modes.frequencies_Hz(i));
    // Drawn with a largest displacement of a tenth of the part; the collection's time is the
    // number of the mode.
    const double scale =
        0.1 * fem::diagonal_of(model.mesh) / modes.shapes.col(i).cwiseAbs().maxCoeff();
    vtu.write({.time = sim_time_from_seconds(static_cast<double>(i + 1)),
               .x = X + scale * modes.shapes.col(i),
               .v = Eigen::VectorXd::Zero(X.size())});
  }
  return outcome;
}

/// The motions of the moved sets over time.
class SetMotions {
 public:
  SetMotions(const std::vector<fem::SetMotion>& motions, const fem::TetMesh& mesh, double step_s)
      : motions_(motions), step_s_(step_s) {
    for (const fem::SetMotion& motion : motions) origins_.push_back(fem::origin_of(motion, mesh));
  }
  [[nodiscard]] MotionSet at(double t_s) const {
    MotionSet all;
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      all.push_back(fem::motion_at(motions_[i], origins_[i], t_s, step_s_));
    }
    return all;
  }
  /// Appends the wrenches to `history`, by set.
  void record(const WrenchSet& wrenches, ordered_json& history) const {
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      const std::string& set = motions_[i].set.name;
      history["force_N"][set].push_back(to_json(wrenches[i].f_P_W));
      history["torque_Nm"][set].push_back(to_json(wrenches[i].t_P_W));
    }
  }

 private:
  const std::vector<fem::SetMotion>& motions_;
  double step_s_;
  std::vector<Eigen::Vector3d> origins_;
};

/// Transient or quasi-static: states over time.
FemOutcome run_history(const scenario::Node& root, const std::string& kind,
                       const std::vector<fem::SetMotion>& motions,
                       const std::filesystem::path& folder) {
  require(root.has("run"), root.place().text() + ": a " + kind +
                               " analysis needs the section 'run'. Add run: "
                               "{duration_s: …, macro_step_s: …}.");
  fem::Params params = moved_params(root, motions);
  if (kind == "quasi_static") params.integrator.kind = fem::IntegratorKind::QuasiStatic;
  const std::unique_ptr<fem::FlexibleSide> body = fem::make_body(std::move(params));
  const fem::Model& model = body->model();
  FemOutcome outcome{.results = heading(root, model, kind)};
  std::optional<fem::VtuWriter> vtu;
  if (const std::int64_t every = scenario::read_output(root).vtu_every_steps; every > 0) {
    vtu.emplace(model, folder / "fem", "fem", every);
  }
  ordered_json& history = outcome.results["history"];
  history["t_s"] = ordered_json::array();
  history["displacement_m"] = ordered_json::object();
  const auto record = [&] {
    const fem::State state = body->nodal_state();
    history["t_s"].push_back(to_seconds(state.time));
    const ordered_json sets = displacements(model, state.x);
    for (const auto& [set, mean] : sets.items()) history["displacement_m"][set].push_back(mean);
    if (vtu) vtu->write(state);
  };
  const scenario::RunParams run = scenario::read_run(root);
  refuse_late_changes(root, run, false);
  const SetMotions moved(motions, model.mesh, to_seconds(model.params.micro_step));
  moved.record(body->initialize(moved.at(0.0)), history);
  record();
  BooksOfOneSide looked(*body, run.macro_steps());
  for (std::int64_t step = 0; step < run.macro_steps(); ++step) {
    body->checkpoint();
    const double t_s = to_seconds(body->nodal_state().time);
    const StepResult<WrenchSet> result =
        body->advance({.step = run.macro_step,
                       .input = {moved.at(t_s), moved.at(t_s + to_seconds(run.macro_step))}});
    book(result.message, outcome);
    if (result.outcome != Outcome::Done) break;
    moved.record(result.output, history);
    record();
    looked.look(step + 1);
  }
  std::printf("%lld steps to t = %g s: %s\n", static_cast<long long>(history["t_s"].size()) - 1,
              to_seconds(body->nodal_state().time),
              in_words(displacements(model, body->nodal_state().x)).c_str());
  if (kind == "transient") {
    RunBooks books;
    books.fem_second_order = model.params.integrator.kind != fem::IntegratorKind::BackwardEuler;
    books.reduced = model.params.formulation == fem::FormulationKind::CraigBampton;
    books.linearised = !books.reduced && model.params.integrator.newton_steps == 0;
    looked.add_to(books);
    add_verdict(books, outcome);
  }
  return outcome;
}

struct FemCommand {
  std::string file;
  std::string analysis;
  std::string out;
  std::vector<std::string> sets;

  [[nodiscard]] int run() const {
    std::vector<scenario::Override> overrides;
    for (const std::string& set : sets) overrides.push_back(scenario::parse_override(set));
    const scenario::Loaded loaded =
        scenario::load(file, fem_scenario_table(), with_nodes(file, overrides));
    require_one_body(loaded.root);
    require_mesh_file(loaded.root);
    const RunDirectory directory = RunDirectory::create_group(
        out.empty() ? std::nullopt : std::optional<std::filesystem::path>(out),
        loaded.root.text("name"), "fem");
    const std::filesystem::path& folder = directory.path();
    const FemOutcome outcome = run_fem(loaded.root, analysis, folder);
    write_whole_file(folder / "scenario.yaml", loaded.resolved_yaml);
    write_whole_file(folder / "fem.json", outcome.results.dump(2) + "\n");
    std::printf("%s\n", (folder / "fem.json").string().c_str());
    if (outcome.exit_code != 0) {
      std::fprintf(stderr, "%s\n", outcome.results["message"].get<std::string>().c_str());
    }
    return outcome.exit_code;
  }
};

}  // namespace

void add_verdict(const RunBooks& books, FemOutcome& outcome) {
  if (outcome.exit_code != 0) return;
  const Verdict verdict = judge(books);
  outcome.results["verdict"] = to_json(verdict);
  std::printf("verdict: %s\n  %s\n", verdict.text().c_str(), verdict.numbers().c_str());
}

FemOutcome run_fem(const scenario::Node& root, const std::string& analysis,
                   const std::filesystem::path& folder) {
  const fem::AnalysisParams params = fem::read_analysis(root);
  const std::string& kind = analysis.empty() ? params.kind : analysis;
  if (root.section("fem").text("model") == "ancf") return run_beams(root, kind, params, folder);
  if (kind == "modes") return run_modes(root, params.modes, folder);
  if (kind == "transient" || kind == "quasi_static") {
    return run_history(root, kind, params.motions, folder);
  }
  return run_static(root, params.statics, folder);
}

void add_fem(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<FemCommand>();
  CLI::App* sub =
      app.add_subcommand("fem",
                         "Analyse the flexible side alone: static load steps, statics over time, "
                         "eigenfrequencies, transient");
  sub->add_option("SCENARIO", command->file, "Scenario file (YAML); run, ports, mbs may be absent")
      ->required();
  sub->add_option("--analysis", command->analysis,
                  "static, quasi_static, modes or transient [fem.analysis.kind]")
      ->check(CLI::IsMember({"static", "quasi_static", "modes", "transient"}));
  sub->add_option("--out", command->out,
                  "Folder for fem.json and .vtu [runs/<scenario>/fem-<UTC time>]");
  sub->add_option("--set", command->sets, "Override one key: --set fem.formulation=linear")
      ->type_name("KEY=VALUE")
      ->take_all();
  sub->footer(
      "Port nodes and fixed sets are held, fem.analysis.motions moves sets. Exit code 3 when no "
      "equilibrium was found.");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace tandem::orchestrator

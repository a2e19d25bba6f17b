#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "fem_process/ancf/ancf_keys.h"
#include "fem_process/ancf/beam_params.h"
#include "mbs_process/make_side.h"
#include "mbs_process/spring_stability.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/files/summary_number.h"
#include "orchestrator/run/run.h"
#include "orchestrator/scenario/scenario_options.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

std::string outcome_line(const nlohmann::ordered_json& s) {
  const bool clean = s.at("verdict").at("causes").empty();
  const std::string state = s.value("state_hash", "");
  return fmt::format(
      "{} ({}, {}): {}{}, {} macro steps, {:.2f} iterations per step, {:.3f} s wall for {:.6g} s "
      "simulated{}",
      s.at("scenario").get<std::string>(), s.at("mode").get<std::string>(),
      s.at("scheme").get<std::string>(), s.at("verdict").at("status").get<std::string>(),
      clean ? "" : " (see the verdict)", s.at("macro_steps").get<std::int64_t>(),
      s.at("iterations").at("mean").get<double>(), s.at("wall_s").get<double>(),
      s.at("simulated_s").get<double>(), state.empty() ? "" : ", state " + state);
}

/// The balance of both sides together, all terms booked.
std::string balance_line(const nlohmann::ordered_json& energy) {
  const auto value = [&](const char* key) { return number_at(energy, key); };
  return fmt::format(
      "energy: {:.6g} J {:+.4g} external {:+.4g} interface {:+.4g} damping {:+.4g} numerical = "
      "{:.6g} J, balance error {:.2g} J",
      value("total_start"), value("external_work"), value("interface_work"), -value("damping"),
      -value("numerical"), value("total_end"), value("balance_error"));
}

/// Of a run that was held to the wall clock.
std::string pace_line(const nlohmann::ordered_json& pace) {
  std::string by;
  for (const auto& [part, steps] : pace.at("missed_by").items()) {
    if (steps.get<std::int64_t>() == 0) continue;
    by += fmt::format("{}{} {}", by.empty() ? ": " : ", ", part, steps.get<std::int64_t>());
  }
  const auto& step_us = pace.at("step_us");
  return fmt::format(
      "pace {:g}: {} of {} macro steps late{}; a step took {:.3g} ms (median), {:.3g} ms (99.9 %), "
      "{:.3g} ms (most)",
      number_at(pace, "factor"), pace.at("misses").get<std::int64_t>(),
      pace.at("steps").get<std::int64_t>(), by, 1e-3 * number_at(step_us, "median"),
      1e-3 * number_at(step_us, "p99.9"), 1e-3 * number_at(step_us, "max"));
}

struct RunCommand {
  ScenarioOptions scenario;
  std::string transport = "lcm";
  bool monolithic = false;
  bool attach = false;
  bool quiet = false;

  [[nodiscard]] Mode mode() const {
    if (monolithic) return Mode::Monolithic;
    return transport == "lcm" ? Mode::Lcm : Mode::Inproc;
  }

  /// A monolithic run has no scheme, no transport and no processes to choose.
  void check_monolithic(const CLI::App& given) const {
    if (!monolithic) return;
    for (const char* option : {"--scheme", "--transport", "--driver", "--attach"}) {
      require(given.count(option) == 0,
              std::string(option) +
                  ": a monolithic run is one process that solves one system per step; there are no "
                  "side processes to couple. Leave out " +
                  option + " or --monolithic.");
    }
  }

  /// The monolithic step couples the sides themselves. The scenario of its folder says so where a
  /// scheme would put a line between them: a replay then has the sides that were recorded.
  [[nodiscard]] Model load() const {
    Model model = scenario.load();
    if (!monolithic || model.coupling.scheme != SchemeKind::Tlm) return model;
    ScenarioOptions plain = scenario;
    plain.changes.push_back({"coupling.scheme", "interface_jacobian", "--monolithic"});
    return plain.load();
  }

  int run() const {
    const Model model = load();
    if (!monolithic) {
      for (const std::string& note : notes_of(model.coupling)) {
        std::fprintf(stderr, "warning: %s\n", note.c_str());
      }
    }
    warn_of_bending(model);
    const RunDirectory directory = RunDirectory::create(scenario.folder(), model.name);
    const RunOutcome outcome =
        run_model(model, directory, {.mode = mode(), .silent = quiet, .attach = attach});
    report(outcome, directory);
    if (outcome.exit_code == 3) note_springs(model, outcome);
    return outcome.exit_code;
  }

  /// A chain that locks runs all the same, and its result looks good.
  static void warn_of_bending(const Model& model) {
    for (const scenario::FlexibleBody& body : model.bodies) {
      if (body.root.section("fem").text("model") != "ancf") continue;
      const fem::ancf::BeamParams params = fem::ancf::read_beam_params(body.root);
      if (const auto warning = fem::ancf::bending_warning(params.model)) {
        std::fprintf(stderr, "warning: %s\n", warning->c_str());
      }
    }
  }

  /// What springs make unstable, the coupling's own monitors may notice first and blame on
  /// themselves.
  static void note_springs(const Model& model, const RunOutcome& outcome) {
    const auto message = outcome.summary.at("message").get<std::string>();
    for (const scenario::MultibodyWorld& world : model.worlds) {
      const auto warning = mbs::spring_warning(mbs::make_side(world.root, {})->params());
      if (!warning || message.find(*warning) != std::string::npos) continue;
      std::fprintf(stderr, "note: the multibody side is unstable by itself: %s\n",
                   warning->c_str());
    }
  }

  static void report(const RunOutcome& outcome, const RunDirectory& directory) {
    const auto& s = outcome.summary;
    if (outcome.exit_code != 0) {
      std::fprintf(stderr, "%s\n", s.at("message").get<std::string>().c_str());
    }
    std::printf("%s\n", outcome_line(s).c_str());
    if (s.contains("pace")) std::printf("%s\n", pace_line(s.at("pace")).c_str());
    // Final state and energies are not known of a run that was broken off.
    if (s.at("energy_J").contains("balance_error")) {
      std::printf("%s\n", balance_line(s.at("energy_J")).c_str());
    }
    const auto& verdict = s.at("verdict");
    if (verdict.contains("text")) {
      std::printf("verdict: %s\n", verdict.at("text").get<std::string>().c_str());
      std::printf("  %s\n", verdict.at("numbers").get<std::string>().c_str());
    }
    std::printf("run folder: %s\n", directory.path().c_str());
  }
};

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* sub = app.add_subcommand("run", "Run a coupled pair and write a run folder");
  command->scenario.declare(*sub);
  sub->add_option("--scheme", command->scenario.scheme,
                  "explicit_serial, explicit_parallel, implicit, interface_jacobian or tlm");
  sub->add_option("--out", command->scenario.out, "Run folder [runs/<scenario>/<UTC time>]");
  sub->add_option("--transport", command->transport, "lcm: two processes; inproc: one")
      ->check(CLI::IsMember({"lcm", "inproc"}))
      ->capture_default_str();
  sub->add_flag("--monolithic", command->monolithic,
                "One process, one coupled system per step: the reference for cost and error");
  sub->add_flag("--attach", command->attach,
                "Do not start the sides: print how to start them by hand (debugger)");
  sub->add_flag("--quiet", command->quiet, "No progress and no forwarded logs");
  sub->callback([command, sub, &exit_code] {
    command->check_monolithic(*sub);
    exit_code = command->run();
  });
}

}  // namespace tandem::orchestrator

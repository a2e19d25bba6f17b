#include "orchestrator/run/run.h"

#include <fmt/format.h>

#include "orchestrator/process/interruption.h"
#include "orchestrator/run/lcm_run.h"
#include "orchestrator/run/local_run.h"
#include "orchestrator/scenario/chosen_settings.h"
#include "orchestrator/verdict/run_books.h"
#include "orchestrator/verdict/verdict.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/driver/side_process.h"
#include "protocol/wire/bus.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

wire::Finished run_in_mode(const Model& model, const RunDirectory& directory,
                           const RunOptions& options, std::uint64_t run_id, Recorder& recorder) {
  if (options.mode == Mode::Lcm) {
    return run_over_lcm(model, directory, options, run_id, recorder);
  }
  const RunReport report = run_here(model, directory, options.mode, recorder);
  return {.exit_code = report.exit_code(),
          .message = report.message,
          .summary_json = to_json(report).dump()};
}

ordered_json heading(const Model& model, Mode mode) {
  return {{"tandem", kTandemVersion}, {"scenario", model.name}, {"mode", to_string(mode)}};
}

/// A side that refuses its model names the place in the resolved scenario of the run folder. Making
/// the model here from the user's file names the place there, where it is to be mended.
std::string place_in_users_file(const Model& model, const Error& error) {
  if (error.kind() != ErrorKind::Usage) return error.what();
  try {
    (void)make_mbs(model, {});
    (void)make_fem(model, {});
  } catch (const Error& here) {
    return here.what();
  }
  return error.what();  // the model is good: the fault lies elsewhere, e.g. in the network
}

/// What the run says of itself: also of one that was stopped, which is its status alone.
ordered_json verdict_of(const Model& model, const RunDirectory& directory, Mode mode,
                        const ordered_json& summary) {
  if (summary.at("status") != "done") {
    return {{"status", summary.at("status")}, {"causes", ordered_json::array()}};
  }
  return to_json(judge(books_of_run(model, mode == Mode::Monolithic, summary, directory.path())));
}

/// Names of files may hold bytes that are no UTF-8: replaced, since JSON has no place for them.
std::string text_of(const ordered_json& json, int indent = -1) {
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

/// The summary holds what the recorded macro steps tell.
RunOutcome outcome_of_failure(const Model& model, Mode mode, int exit_code,
                              const std::string& message, const Recorder& recorder) {
  // Whatever failed after a signal came, failed because of it: Ctrl-C reaches the sides as well.
  const int signal = stop_signal();
  RunOutcome outcome{.exit_code = signal != 0 ? 128 + signal : exit_code,
                     .summary = heading(model, mode)};
  outcome.summary.update(to_json(recorder.so_far()));
  outcome.summary["scheme"] =
      mode == Mode::Monolithic ? to_string(mode) : to_string(model.coupling.scheme);
  outcome.summary["status"] = signal != 0 ? "interrupted" : "failed";
  outcome.summary["message"] = message;
  outcome.summary["verdict"] = {{"status", outcome.summary["status"]},
                                {"causes", ordered_json::array()}};
  return outcome;
}

/// Closes the log and the tables of a run that was broken off, as far as they can be written.
void close(const RunOutcome& outcome, Recorder& recorder) {
  recorder.end_progress();
  try {
    recorder.finish({.exit_code = outcome.exit_code,
                     .message = outcome.summary.at("message").get<std::string>(),
                     .summary_json = text_of(outcome.summary)});
    recorder.flush();
  } catch (const Error&) {
    return;  // a full disk must not hide why the run itself ended
  }
}

}  // namespace

std::string to_string(Mode mode) {
  switch (mode) {
    case Mode::Lcm:
      return "lcm";
    case Mode::Inproc:
      return "inproc";
    case Mode::Monolithic:
      return "monolithic";
  }
  return "unknown";
}

RunOutcome run_model(const Model& model, const RunDirectory& directory, const RunOptions& options) {
  const InterruptionGuard guard;
  if (!options.silent && !model.chosen.empty()) {
    std::fprintf(stderr, "run.accuracy %g: %s\n",
                 model.scenario.root.section("run").real("accuracy"),
                 text_of(model.chosen).c_str());
  }
  const std::uint64_t run_id = wire::random_run_id();
  Recorder recorder(model, directory, run_id, options.silent);
  recorder.watch(options.watch);
  RunOutcome outcome;
  try {
    const wire::Finished finished = run_in_mode(model, directory, options, run_id, recorder);
    recorder.finish(finished);
    recorder.flush();
    outcome = {.exit_code = finished.exit_code, .summary = heading(model, options.mode)};
    outcome.summary.update(ordered_json::parse(finished.summary_json));
    outcome.summary["verdict"] = verdict_of(model, directory, options.mode, outcome.summary);
  } catch (const Error& error) {
    const std::string text =
        options.mode == Mode::Lcm ? place_in_users_file(model, error) : error.what();
    outcome = outcome_of_failure(model, options.mode, error.exit_code(), text, recorder);
    close(outcome, recorder);
  } catch (const std::exception& error) {
    outcome = outcome_of_failure(model, options.mode, 4, error.what(), recorder);
    close(outcome, recorder);
  }
  try {
    write_whole_file(directory.summary(), text_of(outcome.summary, 2) + "\n");
  } catch (const Error& error) {
    // A full disk must not hide why the run itself ended.
    if (outcome.exit_code == 0) {
      return outcome_of_failure(model, options.mode, error.exit_code(), error.what(), recorder);
    }
  }
  return outcome;
}

}  // namespace tandem::orchestrator

#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "orchestrator/files/run_directory.h"
#include "orchestrator/run/recorder.h"
#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {

/// Who computes where. The first two run the same scheme code and must give the same bits.
enum class Mode {
  Lcm,        ///< two processes behind LCM
  Inproc,     ///< the same scheme, both sides in this process
  Monolithic  ///< one coupled system per step, both sides in this process
};
[[nodiscard]] std::string to_string(Mode mode);

struct RunOptions {
  Mode mode = Mode::Lcm;
  bool silent = false;  ///< no progress and no forwarded logs
  bool attach = false;  ///< Lcm: do not start the sides, print how to start them by hand
  Recorder::Watch watch;
};

/// How a run ended: the exit code of the command and the whole summary.json.
struct RunOutcome {
  int exit_code = 0;
  nlohmann::ordered_json summary;
};

/// Runs the model and writes the run folder, summary.json last. A run that fails still leaves its
/// folder with a summary that says why; its error is in the outcome and not thrown.
[[nodiscard]] RunOutcome run_model(const Model& model, const RunDirectory& directory,
                                   const RunOptions& options);

}  // namespace tandem::orchestrator

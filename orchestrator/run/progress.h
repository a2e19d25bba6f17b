#pragma once

#include <cstdint>
#include <string>

#include "protocol/contract/sim_time.h"

namespace tandem::orchestrator {

/// Progress of a run on standard error: one line redrawn on a terminal, a plain line every tenth of
/// the run otherwise.
class Progress {
 public:
  /// `silent` suppresses all output (repeats of compare).
  Progress(std::string label, std::int64_t macro_steps, SimTime macro_step, bool silent);
  void step(std::int64_t macro_step, std::int32_t iterations);
  /// Ends the redrawn line so that what follows starts on its own line.
  void finish();

 private:
  void draw(std::int64_t macro_step);

  std::string label_;
  std::int64_t macro_steps_;
  SimTime macro_step_;
  bool silent_;
  bool terminal_;
  bool drawn_ = false;
  std::int64_t iterations_ = 0;
  std::int64_t next_plain_ = 0;
  double start_s_;
  double next_draw_s_ = 0.0;
};

}  // namespace tandem::orchestrator

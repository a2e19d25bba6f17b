#include "orchestrator/run/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "protocol/contract/cost.h"

namespace tandem::orchestrator {

Progress::Progress(std::string label, std::int64_t macro_steps, SimTime macro_step, bool silent)
    : label_(std::move(label)),
      macro_steps_(std::max<std::int64_t>(1, macro_steps)),
      macro_step_(macro_step),
      silent_(silent),
      terminal_(isatty(STDERR_FILENO) == 1),
      next_plain_(macro_steps_ / 10),
      start_s_(now_s()) {}

void Progress::step(std::int64_t macro_step, std::int32_t iterations) {
  iterations_ += iterations;
  if (silent_ || macro_step == 0) return;
  const bool last = macro_step >= macro_steps_;
  if (terminal_) {
    // Ten redraws a second are enough for the eye and cost nothing.
    if (!last && now_s() < next_draw_s_) return;
    next_draw_s_ = now_s() + 0.1;
    draw(macro_step);
  } else if (last || macro_step >= next_plain_) {
    next_plain_ = macro_step + std::max<std::int64_t>(1, macro_steps_ / 10);
    draw(macro_step);
  }
}

void Progress::draw(std::int64_t macro_step) {
  const double elapsed_s = now_s() - start_s_;
  const auto done = static_cast<double>(macro_step);
  const double left_s = elapsed_s / done * static_cast<double>(macro_steps_ - macro_step);
  const std::string line = fmt::format(
      "{}: {:3.0f} %  t = {:.4f} s of {:.4f} s  {:.2f} iterations/step  {:.2f} ms/step  {:.0f} s "
      "left",
      label_, 100.0 * done / static_cast<double>(macro_steps_), done * to_seconds(macro_step_),
      static_cast<double>(macro_steps_) * to_seconds(macro_step_),
      static_cast<double>(iterations_) / done, 1e3 * elapsed_s / done, left_s);
  if (terminal_) {
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    std::fflush(stderr);
    drawn_ = true;
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
}

void Progress::finish() {
  if (drawn_) std::fprintf(stderr, "\n");
  drawn_ = false;
}

}  // namespace tandem::orchestrator

#include "fem_process/transient/micro_step.h"

#include <fmt/format.h>

#include "protocol/scenario/common_keys.h"

namespace tandem::fem {

MicroStep read_micro_step(const scenario::Node& root) {
  const scenario::Node fem = root.section("fem");
  MicroStep step{.follows_macro_step = !fem.has("micro_step_s")};
  // Without `run` (static analysis, modes) no step is made: any length is good.
  const SimTime macro_step =
      root.has("run") ? scenario::read_run(root).macro_step : SimTime(1'000'000'000);
  step.length = root.has("run") && fem.has("micro_step_s")
                    ? sim_time_from_seconds(fem.real("micro_step_s"))
                    : macro_step;
  if (step.length <= SimTime{} || macro_step % step.length != SimTime{}) {
    fem.fail("micro_step_s", fmt::format("the macro step of {} s is not a whole multiple of it.",
                                         to_seconds(macro_step)));
  }
  return step;
}

}  // namespace tandem::fem

#include "orchestrator/scenario/late_changes.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scenario/flexible_bodies.h"

namespace tandem::orchestrator {

namespace {

void refuse_late(const scenario::Node& fem, const scenario::RunParams& run, bool adaptive) {
  if (!fem.has("changes")) return;
  // A change is made before the first macro step that begins at or after it.
  const SimTime last_begin = (run.macro_steps() - 1) * run.macro_step;
  const SimTime end = run.macro_steps() * run.macro_step;
  for (const scenario::Node& change : fem.list("changes")) {
    const double at_s = change.real("at_s");
    if (adaptive ? at_s < to_seconds(end) : at_s <= to_seconds(last_begin)) continue;
    change.fail(
        "at_s",
        fmt::format("{:g} s is {}: the run ends at {:g} s and its last macro step begins "
                    "{}, so the change would never be made. Raise run.duration_s, or take "
                    "the change out.",
                    at_s, at_s >= to_seconds(end) ? "not before the run's end" : "too late",
                    to_seconds(end),
                    adaptive ? "before" : fmt::format("at {:g} s", to_seconds(last_begin))));
  }
}

}  // namespace

void refuse_late_changes(const scenario::Node& root, const scenario::RunParams& run,
                         bool adaptive) {
  for (const scenario::FlexibleBody& body : scenario::flexible_bodies(root)) {
    refuse_late(body.root.section("fem"), run, adaptive);
  }
}

}  // namespace tandem::orchestrator

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {

/// Changes of a scenario as `--set` takes them, "KEY=VALUE"; of two on one key the later one holds.
using Settings = std::vector<std::string>;

/// The scenario with settings, a macro step and a duration (s, 0 = its own). Macro steps are equal
/// unless the settings say otherwise. Throws a Usage error where they do not fit the scenario.
using LoadTrial = std::function<Model(const Settings& settings, double step_s, double duration_s)>;

/// `a`, and `b` after it.
[[nodiscard]] inline Settings joined(Settings a, const Settings& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace tandem::orchestrator

#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace tandem::orchestrator {

/// A number of summary.json. JSON has none for what is not finite and writes null, as in the
/// energies of a run that diverged; those, and keys that are not there, are NaN here.
[[nodiscard]] inline double number_at(const nlohmann::ordered_json& object,
                                      const std::string& key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return found->get<double>();
}

}  // namespace tandem::orchestrator

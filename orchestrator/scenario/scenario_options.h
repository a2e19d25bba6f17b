#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "orchestrator/scenario/model.h"

namespace CLI {
class App;
}

namespace tandem::orchestrator {

/// Options that every command on a scenario has.
struct ScenarioOptions {
  std::string file;
  std::vector<std::string> sets;
  std::string scheme;
  std::string scheme_option = "--scheme";   ///< the one that `scheme` was given by
  std::vector<scenario::Override> changes;  ///< that the command makes of itself
  std::string driver;
  std::string out;
  bool ends_early = false;  ///< for trials: what the scenario changes after their end is not made

  void declare(CLI::App& command);
  /// What the options change of the file.
  [[nodiscard]] std::vector<scenario::Override> overrides() const;
  /// The scenario with the overrides; throws a Usage error.
  [[nodiscard]] Model load() const;
  [[nodiscard]] std::optional<std::filesystem::path> folder() const {
    return out.empty() ? std::nullopt : std::optional<std::filesystem::path>(out);
  }
};

}  // namespace tandem::orchestrator

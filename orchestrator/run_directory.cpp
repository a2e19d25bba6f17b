#include "orchestrator/run_directory.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <initializer_list>
#include <system_error>

#include "orchestrator/text_file.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const std::error_code& error) {
  throw Error(kind_of_output_fault(error),
              fmt::format("cannot create the run folder '{}': {}. Choose another with --out.",
                          path.string(), error.message()));
}

/// True when the folder holds one of the files; a name that the system refuses is told.
bool holds(const fs::path& folder, std::initializer_list<std::string> files) {
  for (const std::string& file : files) {
    std::error_code error;
    const bool found = fs::exists(folder / file, error);
    if (error && error != std::errc::not_a_directory) refuse(folder, error);
    if (found) return true;
  }
  return false;
}

void create_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error && !fs::is_directory(path, error) && !error) {
    error = std::make_error_code(std::errc::not_a_directory);
  }
  if (error) refuse(path, error);
}

fs::path default_folder(const std::string& scenario_name, const std::string& prefix) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const fs::path parent = fs::path("runs") / scenario_name;
  const std::string stamp = prefix + fmt::format("{:%Y-%m-%dT%H-%M-%SZ}", fmt::gmtime(now));
  fs::path folder = parent / stamp;
  for (int suffix = 2; fs::exists(folder); ++suffix) {
    folder = parent / fmt::format("{}-{}", stamp, suffix);
  }
  return folder;
}

}  // namespace

RunDirectory RunDirectory::create(const std::optional<fs::path>& chosen,
                                  const std::string& scenario_name) {
  const fs::path path = fs::absolute(chosen ? *chosen : default_folder(scenario_name, ""));
  if (holds(path, {"scenario.yaml", "exchange.lcm"})) {
    throw Error(ErrorKind::Usage, fmt::format("--out: '{}' already holds a run. Name a new folder, "
                                              "or remove this one.",
                                              path.string()));
  }
  create_folder(path);
  return RunDirectory(path);
}

fs::path RunDirectory::create_group(const std::optional<fs::path>& chosen,
                                    const std::string& scenario_name, const std::string& purpose) {
  const fs::path path =
      fs::absolute(chosen ? *chosen : default_folder(scenario_name, purpose + "-"));
  // A run's own files must stay what its log was recorded with.
  if (holds(path, {purpose + ".json", "scenario.yaml", "exchange.lcm"})) {
    throw Error(ErrorKind::Usage, fmt::format("--out: '{}' already holds results. Name a new "
                                              "folder, or remove this one.",
                                              path.string()));
  }
  create_folder(path);
  return path;
}

RunDirectory RunDirectory::open(const fs::path& path) {
  require(fs::is_directory(path),
          fmt::format("'{}' is not a run folder. Give the folder that `tandem run` named.",
                      path.string()));
  for (const char* file : {"scenario.yaml", "exchange.lcm"}) {
    require(fs::exists(path / file),
            fmt::format("'{}' is not a complete run folder: {} is missing.", path.string(), file));
  }
  return RunDirectory(fs::absolute(path));
}

}  // namespace tandem::orchestrator

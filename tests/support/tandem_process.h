#pragma once

#include <sys/prctl.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/child_process.h"

namespace tandem::test {

/// Empty where nothing can be read: a file of /proc may lose its process while it is read.
inline std::string read_file(const std::filesystem::path& file) {
  std::ostringstream content;
  content << std::ifstream(file, std::ios::binary).rdbuf();
  return content.str();
}

inline void write_file(const std::filesystem::path& file, const std::string& content) {
  std::ofstream(file, std::ios::binary) << content;
}

/// A folder of its own, removed at the end with everything in it. Processes of a run carry its name
/// in their command lines, so nothing of another test is ever counted.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& name = "tandem") {
    std::string text = (std::filesystem::temp_directory_path() / (name + "_XXXXXX")).string();
    if (mkdtemp(text.data()) != nullptr) path_ = text;
  }
  ~TemporaryFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Pids of the processes whose command line holds `text`; those that have ended and are only not
/// reaped yet are no processes any more (their command line is empty).
inline std::vector<pid_t> processes_with(const std::string& text) {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (std::stoi(name) == getpid()) continue;
    if (read_file(entry.path() / "cmdline").find(text) != std::string::npos) {
      found.push_back(std::stoi(name));
    }
  }
  return found;
}

/// The path itself, or a link to it: LD_PRELOAD and unquoted words of a shell know no spaces.
inline std::string without_spaces(const std::string& path) {
  if (path.find(' ') == std::string::npos) return path;
  const std::string link = "/tmp/tandem_link_" + std::to_string(getuid()) + "_" +
                           std::to_string(std::hash<std::string>{}(path));
  std::error_code exists_already;
  std::filesystem::create_symlink(path, link, exists_already);
  return link;
}

inline const std::string kTandem = without_spaces(TANDEM_BIN_DIR) + "/tandem";
inline const std::string kExamples = without_spaces(TANDEM_SOURCE_DIR) + "/examples/";

/// What a command said and how it ended; −1: it still ran after the time given and was killed.
struct Ended {
  int code = -1;
  std::string output;
};

/// A preloaded library comes before a sanitizer's runtime; it does not use it.
inline Environment with_preload(Environment extra, const std::string& library) {
  extra["LD_PRELOAD"] = without_spaces(library);
  extra["ASAN_OPTIONS"] = "verify_asan_link_order=0";
  return extra;
}

inline Ended run_command(const std::vector<std::string>& command, const Environment& extra = {},
                         double seconds = 60.0) {
  ChildProcess process(command, extra);
  Ended ended;
  ended.code = process.wait(seconds);
  ended.output = process.output();
  return ended;
}

/// `tandem` with these arguments.
inline Ended tandem_command(std::vector<std::string> arguments, const Environment& extra = {}) {
  arguments.insert(arguments.begin(), kTandem);
  return run_command(arguments, extra);
}

/// The command of a run of an example, without progress and forwarded logs.
inline std::vector<std::string> run_of(const std::string& example,
                                       const std::filesystem::path& folder,
                                       const std::vector<std::string>& more = {}) {
  std::vector<std::string> command{kTandem,   "run",   kExamples + example + "/scenario.yaml",
                                   "--quiet", "--out", folder.string()};
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

/// summary.json of a run folder; an empty object when there is none.
inline nlohmann::json summary_of(const std::filesystem::path& folder) {
  const auto summary = nlohmann::json::parse(read_file(folder / "summary.json"), nullptr, false);
  return summary.is_discarded() ? nlohmann::json::object() : summary;
}

}  // namespace tandem::test

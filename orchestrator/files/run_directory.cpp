#include "orchestrator/files/run_directory.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <ctime>
#include <initializer_list>
#include <system_error>

#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"

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

/// A new folder with the time in its name. Only making it tells that no other run has just chosen
/// the same name.
fs::path create_default(const std::string& scenario_name, const std::string& prefix) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const fs::path parent = fs::absolute(fs::path("runs") / scenario_name);
  const std::string stamp = prefix + fmt::format("{:%Y-%m-%dT%H-%M-%SZ}", fmt::gmtime(now));
  create_folder(parent);
  for (int suffix = 1;; ++suffix) {
    const fs::path folder = parent / (suffix == 1 ? stamp : fmt::format("{}-{}", stamp, suffix));
    if (mkdir(folder.c_str(), 0777) == 0) return folder;
    if (errno != EEXIST) refuse(folder, {errno, std::generic_category()});
  }
}

}  // namespace

/// A lock on the folder, for as long as its process lives: the kernel ends it with the process, and
/// nothing of it is left in the folder.
class RunDirectory::Claim {
 public:
  explicit Claim(const fs::path& path)
      : fd_(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    // A file system without locks keeps nobody out.
    if (fd_ < 0 || flock(fd_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
    ::close(fd_);
    throw Error(ErrorKind::Usage, fmt::format("'{}': another command writes into this folder now. "
                                              "Wait for its end, or choose another one.",
                                              path.string()));
  }
  ~Claim() {
    if (fd_ >= 0) ::close(fd_);
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

 private:
  int fd_;
};

RunDirectory RunDirectory::claimed(const std::optional<fs::path>& chosen,
                                   const std::string& scenario_name, const std::string& prefix) {
  if (chosen) create_folder(fs::absolute(*chosen));
  RunDirectory directory(chosen ? fs::absolute(*chosen) : create_default(scenario_name, prefix));
  directory.claim_ = std::make_shared<const Claim>(directory.path_);
  return directory;
}

RunDirectory RunDirectory::create(const std::optional<fs::path>& chosen,
                                  const std::string& scenario_name) {
  RunDirectory directory = claimed(chosen, scenario_name, "");
  if (holds(directory.path_, {"scenario.yaml", "exchange.lcm"})) {
    throw Error(ErrorKind::Usage, fmt::format("--out: '{}' already holds a run. Name a new folder, "
                                              "or remove this one.",
                                              directory.path_.string()));
  }
  return directory;
}

RunDirectory RunDirectory::create_group(const std::optional<fs::path>& chosen,
                                        const std::string& scenario_name,
                                        const std::string& purpose) {
  RunDirectory directory = claimed(chosen, scenario_name, purpose + "-");
  // A run's own files must stay what its log was recorded with.
  if (holds(directory.path_, {purpose + ".json", "scenario.yaml", "exchange.lcm"})) {
    throw Error(ErrorKind::Usage, fmt::format("--out: '{}' already holds results. Name a new "
                                              "folder, or remove this one.",
                                              directory.path_.string()));
  }
  return directory;
}

RunDirectory RunDirectory::create_anew(const fs::path& path) {
  RunDirectory directory = claimed(path, "", "");
  for (const auto& entry : fs::directory_iterator(directory.path_)) fs::remove_all(entry.path());
  return directory;
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

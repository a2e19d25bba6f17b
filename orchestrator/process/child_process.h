#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tandem::orchestrator {

/// How a process ended.
struct ExitStatus {
  int code = 0;                            ///< exit code, or 128 + signal
  int signal = 0;                          ///< 0 = it ended by itself
  [[nodiscard]] std::string text() const;  ///< "exit code 4", "killed by signal 9 (Killed)"
};

/// A process that this one started. Its output goes to a log file and not to a pipe, so that its
/// last words survive the death of the orchestrator. The destructor leaves no process behind.
class ChildProcess {
 public:
  /// Starts `program` with `arguments`; throws a System error that names the program when it
  /// cannot.
  ChildProcess(std::string name, const std::filesystem::path& program,
               const std::vector<std::string>& arguments, const std::filesystem::path& log);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::filesystem::path& log() const { return log_; }
  [[nodiscard]] pid_t pid() const { return pid_; }

  /// The status once the process has ended; does not block.
  std::optional<ExitStatus> poll();

  /// Waits up to `patience_s` for the process to end by itself, then kills it (also when frozen).
  ExitStatus end(double patience_s);

 private:
  std::string name_;
  std::filesystem::path log_;
  pid_t pid_ = -1;
  std::optional<ExitStatus> status_;
};

/// Executable of this project: beside the running one, else on PATH. Throws a System error
/// otherwise.
[[nodiscard]] std::filesystem::path find_program(const std::string& name);

}  // namespace tandem::orchestrator

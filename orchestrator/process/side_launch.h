#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orchestrator/files/run_directory.h"
#include "orchestrator/process/child_process.h"
#include "orchestrator/process/log_tail.h"
#include "protocol/wire/process_names.h"

namespace tandem::orchestrator {

/// The side processes of a run that this process started, and what became of them.
class SideLaunch {
 public:
  /// Starts the given sides; with `attach`, prints the commands to start them by hand instead.
  SideLaunch(const std::vector<wire::Process>& sides, const wire::ProcessNames& names,
             const RunDirectory& directory, std::uint64_t run_id, int port, bool attach,
             bool silent);
  ~SideLaunch();

  /// Forwards new log lines; throws a tandem::Error when a process has ended with a failure, when
  /// one that is still `needed` has ended at all, and when a signal has asked this process to stop.
  void supervise(const std::vector<wire::Process>& needed);

  /// Whether this object started the side (with attach it did not).
  [[nodiscard]] bool started(wire::Process side) const;

  /// Exit status of a side that was started here and has ended.
  [[nodiscard]] std::optional<ExitStatus> ended(wire::Process side);

  /// One phrase per process that has ended with 0 by now, e.g. "tandem-fem: exit code 0; see …".
  [[nodiscard]] std::vector<std::string> left_in_peace();

  /// Waits for all to end, at most `patience_s`, then kills. Returns one phrase per process that
  /// did not end with 0, e.g. "tandem-fem: killed by signal 9 (Killed); see …/fem.log".
  std::vector<std::string> end_all(double patience_s);

 private:
  struct Child {
    wire::Process side;
    ChildProcess process;
    LogTail tail;
  };
  [[nodiscard]] std::string fate(const Child& child, const ExitStatus& status) const;

  std::vector<std::unique_ptr<Child>> children_;
  bool silent_;
};

}  // namespace tandem::orchestrator

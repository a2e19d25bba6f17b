#include "orchestrator/process/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

extern char** environ;

namespace tandem::orchestrator {
namespace {

ExitStatus status_of(int raw) {
  if (WIFSIGNALED(raw)) return {.code = 128 + WTERMSIG(raw), .signal = WTERMSIG(raw)};
  return {.code = WEXITSTATUS(raw), .signal = 0};
}

/// File actions that send a child's output to its log and give it no standard input.
class OutputToLog {
 public:
  explicit OutputToLog(const std::filesystem::path& log) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, log.c_str(),
                                     O_WRONLY | O_CREAT | O_APPEND, 0644);
    posix_spawn_file_actions_adddup2(&actions_, STDOUT_FILENO, STDERR_FILENO);
    // The log and the sockets of this process, which liblcm opens without O_CLOEXEC.
    posix_spawn_file_actions_addclosefrom_np(&actions_, STDERR_FILENO + 1);
  }
  ~OutputToLog() { posix_spawn_file_actions_destroy(&actions_); }
  OutputToLog(const OutputToLog&) = delete;
  OutputToLog& operator=(const OutputToLog&) = delete;
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

}  // namespace

std::string ExitStatus::text() const {
  if (signal != 0) return fmt::format("killed by signal {} ({})", signal, strsignal(signal));
  return fmt::format("exit code {}", code);
}

ChildProcess::ChildProcess(std::string name, const std::filesystem::path& program,
                           const std::vector<std::string>& arguments,
                           const std::filesystem::path& log)
    : name_(std::move(name)), log_(log) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const OutputToLog output(log);
  const int error =
      posix_spawn(&pid_, program.c_str(), output.get(), nullptr, argv.data(), environ);
  if (error != 0) {
    pid_ = -1;
    throw Error(ErrorKind::System, fmt::format("cannot start '{}': {}. Build all targets, or "
                                               "install the programs into one folder.",
                                               program.string(), std::strerror(error)));
  }
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0 && !status_) end(0.0);
}

std::optional<ExitStatus> ChildProcess::poll() {
  if (status_) return status_;
  int raw = 0;
  pid_t ended = 0;
  do {
    ended = waitpid(pid_, &raw, WNOHANG);
  } while (ended < 0 && errno == EINTR);
  if (ended == pid_) status_ = status_of(raw);
  if (ended < 0) status_ = ExitStatus{.code = 4, .signal = 0};
  return status_;
}

ExitStatus ChildProcess::end(double patience_s) {
  const double deadline_s = now_s() + patience_s;
  while (!poll() && now_s() < deadline_s) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  if (!status_) {
    kill(pid_, SIGKILL);  // also ends a frozen process, which SIGTERM would not
    while (!poll()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return *status_;
}

std::filesystem::path find_program(const std::string& name) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    const auto beside = self.parent_path() / name;
    if (std::filesystem::exists(beside, error)) return beside;
  }
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const auto candidate = std::filesystem::path(folder) / name;
    if (!folder.empty() && access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  throw Error(ErrorKind::System,
              fmt::format("program '{}' was found neither beside '{}' nor on PATH. Build it, or "
                          "install all of Tandem's programs into one folder.",
                          name, self.string()));
}

}  // namespace tandem::orchestrator

#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace tandem::test {

using Environment = std::map<std::string, std::string>;

/// A child process whose standard output and error are collected. Killed when it goes out of scope.
class ChildProcess {
 public:
  explicit ChildProcess(const std::vector<std::string>& command, const Environment& extra = {}) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return;
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      for (const auto& [name, value] : extra) setenv(name.c_str(), value.c_str(), 1);
      dup2(ends[1], STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      execv(arguments[0], arguments.data());
      _exit(127);
    }
    close(ends[1]);
    output_fd_ = ends[0];
    fcntl(output_fd_, F_SETFL, O_NONBLOCK);
  }
  ~ChildProcess() {
    if (!ended_) {
      signal(SIGKILL);
      int status = 0;
      waitpid(pid_, &status, 0);
    }
    close(output_fd_);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  void signal(int number) const { kill(pid_, number); }

  /// Exit code; 128 + signal when killed; -1 when it still runs after `seconds`.
  int wait(double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!ended_) {
      drain();  // a full pipe would hold the child
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        ended_ = true;
        code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      } else if (std::chrono::steady_clock::now() > end) {
        return -1;
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
    }
    return code_;
  }

  /// The output up to now; all of it after wait() has seen the child end.
  const std::string& output() {
    drain();
    return output_;
  }

  /// Value of the line "name=value" of the output; empty when there is none.
  std::string value(const std::string& name) {
    std::istringstream lines(output());
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind(name + "=", 0) == 0) return line.substr(name.size() + 1);
    }
    return {};
  }

 private:
  void drain() {
    char buffer[4096];
    for (ssize_t n = 0; (n = read(output_fd_, buffer, sizeof(buffer))) > 0;) {
      output_.append(buffer, static_cast<std::size_t>(n));
    }
  }

  pid_t pid_ = -1;
  int output_fd_ = -1;
  bool ended_ = false;
  int code_ = -1;
  std::string output_;
};

}  // namespace tandem::test

#include "orchestrator/process/child_function.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

[[noreturn]] void fail(const char* what) {
  throw Error(ErrorKind::System, fmt::format("{}: {}", what, std::strerror(errno)));
}

void write_all(int fd, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t size = write(fd, text.data() + done, text.size() - done);
    if (size <= 0) return;
    done += static_cast<std::size_t>(size);
  }
}

char letter_of(ErrorKind kind) { return static_cast<char>('A' + static_cast<int>(kind)); }

/// In the child: '=' and the result, or the kind of the error as a letter and its text.
[[noreturn]] void run_in_child(int pipe, const std::function<std::string()>& body) {
  std::string answer;
  try {
    answer = fmt::format("={}", body());
  } catch (const Error& error) {
    answer = fmt::format("{}{}", letter_of(error.kind()), error.what());
  } catch (const std::exception& error) {
    answer = fmt::format("{}{}", letter_of(ErrorKind::System), error.what());
  }
  write_all(pipe, answer);
  _exit(0);  // what the parent has open is the parent's to close
}

}  // namespace

ChildFunction::ChildFunction(const std::function<std::string()>& body) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) fail("cannot open a pipe");
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) {
    const int error = errno;
    for (const int end : ends) close(end);
    errno = error;
    fail("cannot start a process");
  }
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(0);  // the parent has ended meanwhile
    close(ends[0]);
    run_in_child(ends[1], body);
  }
  close(ends[1]);
  pipe_ = ends[0];
}

ChildFunction::~ChildFunction() {
  kill(pid_, SIGKILL);
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
  close(pipe_);
}

std::string ChildFunction::result() const {
  std::string answer;
  std::array<char, 65536> part{};
  ssize_t size = 0;
  while ((size = read(pipe_, part.data(), part.size())) != 0) {
    if (size > 0) answer.append(part.data(), static_cast<std::size_t>(size));
    if (size < 0 && errno != EINTR) fail("cannot read from a process");
  }
  if (answer.empty()) throw Error(ErrorKind::Partner, "a process of the benchmark was killed");
  if (answer.front() != '=') {
    throw Error(static_cast<ErrorKind>(answer.front() - 'A'), answer.substr(1));
  }
  return answer.substr(1);
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "tandem-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) fail("cannot make a temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

}  // namespace tandem::orchestrator

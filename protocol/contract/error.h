#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace tandem {

/// Whose fault it is, and therefore how a process ends: the exit codes of the command line.
enum class ErrorKind {
  Usage,      ///< bad command line, scenario or mesh (exit code 2)
  NotSolved,  ///< not converged or diverged (exit code 3)
  System,     ///< the machine refused: disk full, no network route, no such program (exit code 4)
  Partner,    ///< a process failed or stopped answering (exit code 4)
  ReplayDiffers  ///< a replayed side left the log (exit code 5)
};

/// A broken promise. The text has the form
///   who: what at t (macro step, iteration): values with limits. Remedy.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& text) : std::runtime_error(text), kind_(kind) {}
  [[nodiscard]] ErrorKind kind() const { return kind_; }
  [[nodiscard]] int exit_code() const;

 private:
  ErrorKind kind_;
};

inline int Error::exit_code() const {
  switch (kind_) {
    case ErrorKind::Usage:
      return 2;
    case ErrorKind::NotSolved:
      return 3;
    case ErrorKind::System:
    case ErrorKind::Partner:
      return 4;
    case ErrorKind::ReplayDiffers:
      return 5;
  }
  return 1;
}

/// Throws a Usage error with `text` unless `claim` holds.
inline void require(bool claim, const std::string& text) {
  if (!claim) throw Error(ErrorKind::Usage, text);
}

}  // namespace tandem

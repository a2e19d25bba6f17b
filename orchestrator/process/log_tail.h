#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace tandem::orchestrator {

/// Forwards the lines that a process adds to its log file to standard error, each behind a label.
class LogTail {
 public:
  LogTail(std::string label, std::filesystem::path file)
      : label_(std::move(label)), path_(std::move(file)) {}

  /// Prints what has been added since the last call; whole lines only.
  void forward();

  /// The last line that the process has written by now; empty when there is none.
  [[nodiscard]] std::string last_line() const;

 private:
  std::string label_;
  std::filesystem::path path_;
  std::ifstream file_;
  std::string partial_;
};

}  // namespace tandem::orchestrator

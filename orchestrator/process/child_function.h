#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>

namespace tandem::orchestrator {

/// A function that runs in a process of its own, a copy of this one; it ends with this process or
/// with the object. This process must have no other threads that matter to the function.
class ChildFunction {
 public:
  explicit ChildFunction(const std::function<std::string()>& body);
  ~ChildFunction();
  ChildFunction(const ChildFunction&) = delete;
  ChildFunction& operator=(const ChildFunction&) = delete;

  /// What the function returned; waits for it. Throws again, with kind and text, the tandem::Error
  /// that it threw.
  [[nodiscard]] std::string result() const;

 private:
  pid_t pid_ = -1;
  int pipe_ = -1;
};

/// A new folder for temporary files, removed with all its content by the process that made it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace tandem::orchestrator

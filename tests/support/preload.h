#pragma once

#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace tandem::test {

/// A path for LD_PRELOAD, which splits its value at blanks and colons and knows no escape: a link
/// to the library in a folder whose name has neither. The link lasts as long as the object.
class PreloadPath {
 public:
  explicit PreloadPath(const std::filesystem::path& library) {
    char name[] = "/tmp/tandem_preload_XXXXXX";
    if (mkdtemp(name) == nullptr) throw std::runtime_error("cannot make a folder in /tmp");
    folder_ = name;
    std::filesystem::create_symlink(library, link());
  }
  ~PreloadPath() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  PreloadPath(const PreloadPath&) = delete;
  PreloadPath& operator=(const PreloadPath&) = delete;

  [[nodiscard]] std::string text() const { return link().string(); }

 private:
  [[nodiscard]] std::filesystem::path link() const { return folder_ / "library.so"; }

  std::filesystem::path folder_;
};

/// The library that disturbs what a process sends (tests/support/fault_shim.cpp), for LD_PRELOAD.
[[nodiscard]] inline std::string fault_shim(const std::filesystem::path& library) {
  static const PreloadPath kPath(library);
  return kPath.text();
}

}  // namespace tandem::test

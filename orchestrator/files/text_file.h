#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace tandem::orchestrator {

/// An output text file that grows row by row. A write that fails (disk full) throws an error that
/// names the file, at the latest in flush(): nothing is lost in silence.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& file);

  void write(const std::string& text);
  void flush();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

}  // namespace tandem::orchestrator

#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace tandem::orchestrator {

/// An output text file. A write that fails (disk full) throws a System error that
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

/// Writes a whole small file; throws a System error when it cannot.
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace tandem::orchestrator

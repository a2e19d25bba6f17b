#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {

/// Whose fault it is that something cannot be made there: a place where nothing can be is the
/// user's (2), a disk that refuses is the machine's (4).
[[nodiscard]] ErrorKind kind_of_output_fault(const std::error_code& error);

/// An output text file. A write that fails (disk full) throws an error that names the file, at the
/// latest in flush(): nothing is lost in silence.
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

/// Writes a whole small file; throws an error that names it when it cannot.
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace tandem::orchestrator

#include "orchestrator/text_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {

TextFile::TextFile(const std::filesystem::path& file)
    : path_(file), file_(std::fopen(file.c_str(), "w")) {
  if (!file_) fail();
}

void TextFile::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) fail();
}

void TextFile::flush() {
  if (std::fflush(file_.get()) != 0) fail();
}

void TextFile::fail() const {
  throw Error(ErrorKind::System,
              fmt::format("cannot write '{}': {}. Free some space or choose another --out.",
                          path_.string(), std::strerror(errno)));
}

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  TextFile out(file);
  out.write(text);
  out.flush();
}

}  // namespace tandem::orchestrator

#include "orchestrator/files/text_file.h"

#include <cerrno>

#include "protocol/contract/whole_file.h"

namespace tandem::orchestrator {

TextFile::TextFile(const std::filesystem::path& file)
    : path_(file), file_(std::fopen(file.c_str(), "we")) {
  if (!file_) fail();
}

void TextFile::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) fail();
}

void TextFile::flush() {
  if (std::fflush(file_.get()) != 0) fail();
}

void TextFile::fail() const { throw cannot_write(path_, {errno, std::generic_category()}); }

}  // namespace tandem::orchestrator

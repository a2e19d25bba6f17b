#include "orchestrator/text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace tandem::orchestrator {

ErrorKind kind_of_output_fault(const std::error_code& error) {
  constexpr std::array kUsersFaults = {
      std::errc::not_a_directory,   std::errc::is_a_directory,
      std::errc::file_exists,       std::errc::filename_too_long,
      std::errc::invalid_argument,  std::errc::no_such_file_or_directory,
      std::errc::permission_denied, std::errc::operation_not_permitted};
  const bool users = std::any_of(kUsersFaults.begin(), kUsersFaults.end(),
                                 [&](std::errc fault) { return error == fault; });
  return users ? ErrorKind::Usage : ErrorKind::System;
}

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
  const std::error_code error(errno, std::generic_category());
  const ErrorKind kind = kind_of_output_fault(error);
  throw Error(kind,
              fmt::format("cannot write '{}': {}. {}.", path_.string(), error.message(),
                          kind == ErrorKind::Usage ? "Choose another place"
                                                   : "Free some space or choose another --out"));
}

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  TextFile out(file);
  out.write(text);
  out.flush();
}

}  // namespace tandem::orchestrator

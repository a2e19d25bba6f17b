#include "fem_process/mesh/text_scanner.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

template <class T>
bool parse_whole(std::string_view word, T& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size();
}

}  // namespace

bool parse(std::string_view word, std::int64_t& value) { return parse_whole(word, value); }
bool parse(std::string_view word, double& value) {
  return parse_whole(word, value) && std::isfinite(value);
}

std::string in_quotes(std::string_view text) {
  std::string quoted = "'";
  quoted += text;
  quoted += "'";
  return quoted;
}

std::string read_whole(const std::filesystem::path& file, const std::string& remedy) {
  std::error_code ignored;
  std::ifstream in;
  // Opening a pipe would wait for its writer.
  if (std::filesystem::is_regular_file(file, ignored)) in.open(file, std::ios::binary);
  require(in.is_open() && in.good(), file.string() + ": cannot be read. " + remedy);
  return {std::istreambuf_iterator<char>(in), {}};
}

TextScanner::TextScanner(const std::filesystem::path& file)
    : file_(file), text_(read_whole(file, "Check the path in fem.mesh.file.")) {}

void TextScanner::fail(const std::string& text) const {
  throw Error(ErrorKind::Usage, file_.string() + ":" + std::to_string(line_) + ": " + text);
}

void TextScanner::skip_space() {
  for (; at_ < text_.size() && is_space(text_[at_]); ++at_) {
    if (text_[at_] == '\n') ++line_;
  }
}

bool TextScanner::at_end() {
  skip_space();
  return at_ == text_.size();
}

std::string_view TextScanner::word(std::string_view what) {
  if (at_end()) {
    fail("the file ends where " + std::string(what) +
         " should be. It is truncated: write it again.");
  }
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
  return std::string_view(text_).substr(begin, at_ - begin);
}

std::int64_t TextScanner::integer(std::string_view what) {
  const std::string_view found = word(what);
  std::int64_t value = 0;
  if (!parse(found, value)) {
    fail(in_quotes(found) + " where " + std::string(what) + " should be. Write a whole number.");
  }
  return value;
}

double TextScanner::real(std::string_view what) {
  const std::string_view found = word(what);
  double value = 0.0;
  if (!parse(found, value)) {
    fail(in_quotes(found) + " where " + std::string(what) + " should be. Write a finite number.");
  }
  return value;
}

std::size_t TextScanner::count(std::string_view what, std::size_t bytes_each) {
  const std::int64_t value = integer(what);
  if (value < 0 || static_cast<std::uint64_t>(value) > bytes_left() / bytes_each) {
    fail(std::string(what) + " is " + std::to_string(value) + ", but only " +
         std::to_string(bytes_left()) +
         " bytes follow. The file is truncated or damaged: " + "write it again.");
  }
  return static_cast<std::size_t>(value);
}

std::string_view TextScanner::rest_of_line() {
  const std::size_t begin = at_;
  while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  std::string_view found = std::string_view(text_).substr(begin, at_ - begin);
  if (at_ < text_.size()) {
    ++at_;
    ++line_;
  }
  while (!found.empty() && is_space(found.back())) found.remove_suffix(1);
  return found;
}

std::string_view TextScanner::bytes(std::string_view what, std::size_t size) {
  if (size > bytes_left()) {
    fail("the file ends within " + std::string(what) + ". It is truncated: write it again.");
  }
  at_ += size;
  return std::string_view(text_).substr(at_ - size, size);
}

void TextScanner::skip_to(std::string_view word) {
  const std::size_t found = text_.find(word, at_);
  if (found == std::string::npos) {
    fail("the file ends where " + std::string(word) +
         " should be. It is truncated: write it again.");
  }
  line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                       text_.begin() + static_cast<std::ptrdiff_t>(found), '\n'));
  at_ = found;
}

std::string TextScanner::quoted(std::string_view what) {
  skip_space();
  const std::size_t close =
      at_ < text_.size() && text_[at_] == '"' ? text_.find('"', at_ + 1) : std::string::npos;
  const std::size_t line_end = text_.find('\n', at_);
  if (close == std::string::npos || close > line_end) {
    fail(std::string(what) + " should stand in double quotes here.");
  }
  std::string found = text_.substr(at_ + 1, close - at_ - 1);
  at_ = close + 1;
  return found;
}

}  // namespace tandem::fem

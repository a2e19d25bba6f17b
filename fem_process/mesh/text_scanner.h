#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::fem {

/// Words and lines of a text file, with the line number for errors. All errors are Usage errors of
/// the form "file:line: what. Remedy.".
class TextScanner {
 public:
  /// Reads the whole file.
  explicit TextScanner(const std::filesystem::path& file);

  [[nodiscard]] bool at_end();  ///< nothing but white space is left
  [[nodiscard]] int line() const { return line_; }
  [[nodiscard]] std::size_t bytes_left() const { return text_.size() - at_; }

  /// Next word between white space; `what` names it in the error when the file ends here.
  std::string_view word(std::string_view what);
  std::int64_t integer(std::string_view what);
  double real(std::string_view what);
  /// A count of items that take at least `bytes_each` bytes: one that the rest of the file cannot
  /// hold is refused before memory is taken for it.
  std::size_t count(std::string_view what, std::size_t bytes_each);
  /// The rest of the line, without its end.
  std::string_view rest_of_line();
  /// The next `size` bytes as they are, the present place being the first. Lines are not counted
  /// in them.
  std::string_view bytes(std::string_view what, std::size_t size);
  /// Passes over everything before the next `word`.
  void skip_to(std::string_view word);
  /// A word in double quotes; may contain spaces.
  std::string quoted(std::string_view what);

  [[noreturn]] void fail(const std::string& text) const;

 private:
  void skip_space();

  std::filesystem::path file_;
  std::string text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// The bytes of a regular file. Throws a Usage error with the remedy when it cannot be read.
[[nodiscard]] std::string read_whole(const std::filesystem::path& file, const std::string& remedy);

/// 'text' in single quotes, for errors.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// Whole-word conversions; false when `word` is not entirely a number.
[[nodiscard]] bool parse(std::string_view word, std::int64_t& value);
[[nodiscard]] bool parse(std::string_view word, double& value);

}  // namespace tandem::fem

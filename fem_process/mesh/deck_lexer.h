#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fem_process/mesh/source_lines.h"

namespace tandem::fem {

/// A keyword line of an Abaqus or CalculiX deck with its continuation lines, or a row of data.
struct DeckLine {
  struct Parameter {
    std::string key;    ///< upper case, without blanks
    std::string value;  ///< as written, without blanks and quotes around it
  };
  bool is_keyword = false;
  std::string keyword;                   ///< upper case, one blank between words: "SOLID SECTION"
  std::vector<Parameter> parameters;     ///< of a keyword, in their order
  std::vector<std::string_view> fields;  ///< of a row, without blanks and quotes around them;
                                         ///< empty ones at its end are left out
  bool goes_on = false;                  ///< a row that ends with a comma
  int line = 0;                          ///< see SourceLines
};

/// Lines of a deck in their order: comments and blank lines are left out, files of *INCLUDE stand
/// in its place, and the text ends before the first *STEP. Errors are Usage errors "file:line:
/// what. Remedy.".
class DeckLexer {
 public:
  explicit DeckLexer(const std::filesystem::path& file);

  /// The next line; its fields are valid until the call after. False at the end.
  bool next(DeckLine& line);

  /// Goes on with the rows of this file (INPUT=), then with the present one. A relative name is
  /// looked for beside the present file, then beside the main one.
  void include(const std::string& name, int line);

  /// Where the first *STEP stands; zero without one.
  [[nodiscard]] int step_line() const { return step_line_; }
  /// Included files in their order, each as often as it is included.
  [[nodiscard]] const std::vector<std::filesystem::path>& included() const { return included_; }
  [[nodiscard]] const SourceLines& lines() const { return lines_; }
  [[noreturn]] void fail(int line, const std::string& text) const;

 private:
  struct Open {
    std::filesystem::path file;
    std::string text;
    std::size_t at = 0;
    int line = 1;  ///< number in the file of the line at `at`
  };

  /// Next line of the present file that is neither blank nor a comment.
  bool take(std::string_view& line);
  /// The line that take() would give, from the present file alone; empty at its end.
  [[nodiscard]] std::string_view ahead() const;
  void keyword(std::string_view text, DeckLine& line);
  void include_of(const DeckLine& line);

  std::vector<std::unique_ptr<Open>> open_;
  std::vector<std::filesystem::path> included_;
  SourceLines lines_;
  int number_ = 0;  ///< of the line taken last
  int step_line_ = 0;
};

/// Upper case without blanks: what Abaqus compares names by.
[[nodiscard]] std::string deck_key(std::string_view text);

/// Fields between commas, without blanks and quotes around them; a comma in double quotes is part
/// of a name. Empty fields at the end are left out.
[[nodiscard]] std::vector<std::string_view> deck_fields(std::string_view text);

/// Finite numbers, also with Fortran's exponent (1.5D+3); false for anything else.
[[nodiscard]] bool deck_real(std::string_view text, double& value);

}  // namespace tandem::fem

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem::fem {

/// Which file and line a line number stands for. Lines are counted through the whole text, included
/// files in their places; without them the number is that of the file.
class SourceLines {
 public:
  /// From `number` on, lines are those of `file`, beginning with its line `line`.
  void begin(int number, const std::filesystem::path& file, int line = 1);

  /// "file:line".
  [[nodiscard]] std::string where(int number) const;
  /// "line 12" of the main file, "file:12" of an included one: for notes.
  [[nodiscard]] std::string named(int number) const;

 private:
  struct Stretch {
    int number = 1;
    std::filesystem::path file;
    int line = 1;
  };
  [[nodiscard]] const Stretch& stretch_of(int number) const;

  std::vector<Stretch> stretches_;
};

}  // namespace tandem::fem

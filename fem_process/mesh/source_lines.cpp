#include "fem_process/mesh/source_lines.h"

#include <algorithm>
#include <iterator>

namespace tandem::fem {

void SourceLines::begin(int number, const std::filesystem::path& file, int line) {
  stretches_.push_back({number, file, line});
}

const SourceLines::Stretch& SourceLines::stretch_of(int number) const {
  const auto after =
      std::upper_bound(stretches_.begin(), stretches_.end(), number,
                       [](int wanted, const Stretch& stretch) { return wanted < stretch.number; });
  return after == stretches_.begin() ? stretches_.front() : *std::prev(after);
}

std::string SourceLines::where(int number) const {
  const Stretch& stretch = stretch_of(number);
  return stretch.file.string() + ":" + std::to_string(stretch.line + number - stretch.number);
}

std::string SourceLines::named(int number) const {
  const Stretch& stretch = stretch_of(number);
  const std::string line = std::to_string(stretch.line + number - stretch.number);
  return stretch.file == stretches_.front().file ? "line " + line
                                                 : stretch.file.filename().string() + ":" + line;
}

}  // namespace tandem::fem

#include "tests/architecture/source_tree.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace tandem::architecture {
namespace {

namespace fs = std::filesystem;

constexpr std::array kTopLevel{
    "CMakeLists.txt", "CMakePresets.json", "CHANGELOG.md", "README.md",   "demo.sh",
    "test.sh",        "protocol",          "mbs_process",  "fem_process", "orchestrator",
    "tests",          "examples",          "docs",         ".ci"};
constexpr std::array kDataExtensions{".msh", ".inp", ".csv", ".svg", ".png"};

bool is_data(const fs::path& path) {
  return std::any_of(kDataExtensions.begin(), kDataExtensions.end(),
                     [&](const char* extension) { return path.extension() == extension; });
}

SourceFile read_file(const fs::path& root, const fs::path& path) {
  std::ifstream stream(path);
  if (!stream) throw std::runtime_error("cannot read " + path.string());
  SourceFile file{.path = fs::relative(path, root).generic_string(), .lines = {}};
  for (std::string line; std::getline(stream, line);) file.lines.push_back(std::move(line));
  return file;
}

}  // namespace

std::vector<SourceFile> read_tree(const fs::path& root) {
  std::vector<SourceFile> tree;
  for (const char* name : kTopLevel) {
    const fs::path top = root / name;
    if (fs::is_regular_file(top)) tree.push_back(read_file(root, top));
    if (!fs::is_directory(top)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top)) {
      if (entry.is_regular_file() && !is_data(entry.path())) {
        tree.push_back(read_file(root, entry.path()));
      }
    }
  }
  std::sort(tree.begin(), tree.end(),
            [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
  return tree;
}

}  // namespace tandem::architecture

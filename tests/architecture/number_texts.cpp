// std::to_string writes a double with six decimals: "limit 0.000000 N" for a limit of 1e-9 N. Its
// argument's type is not in the text of the source; what a source was compiled to names it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/architecture/source_tree.h"

namespace tandem::architecture {
namespace {

/// What std::to_string calls for float, double and long double alone, in GCC's library. It takes
/// its arguments by "...", so no compiler puts it inline.
const std::string kOfReals = "__to_xstring";

/// Names of the symbols of an object or library, one a line, each with its object file.
std::vector<std::string> symbols(const std::string& file) {
  const std::string command = fmt::format("'{}' -A '{}' 2>&1", TANDEM_NM, file);
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  char part[4096];
  while (const std::size_t n = std::fread(part, 1, sizeof part, pipe)) text.append(part, n);
  EXPECT_EQ(pclose(pipe), 0) << command << "\n" << text.substr(0, 1000);
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// "library:object" of a line of nm -A.
std::string object_of(const std::string& line) {
  const std::size_t library = line.find(':');
  return line.substr(0, line.find(':', library + 1));
}

/// CLI11's header writes the bounds of ranges so: an object with it tells nothing, and its source
/// is looked at instead.
std::vector<std::string> texts_of_reals(const std::string& file) {
  const std::vector<std::string> lines = symbols(file);
  std::set<std::string> with_cli;
  for (const std::string& line : lines) {
    if (line.find("N3CLI5Range") != std::string::npos) with_cli.insert(object_of(line));
  }
  std::vector<std::string> found;
  for (const std::string& line : lines) {
    if (line.find(kOfReals) != std::string::npos && !with_cli.contains(object_of(line))) {
      found.push_back(line);
    }
  }
  return found;
}

TEST(ArchitectureNumbers, NoRealIsWrittenByToString) {
  std::istringstream files(TANDEM_LIBRARIES);
  std::size_t libraries = 0;
  for (std::string file; std::getline(files, file, '|'); ++libraries) {
    // A library without a symbol would let the rule hold for nothing.
    EXPECT_GT(symbols(file).size(), 20U) << file;
    for (const std::string& where : texts_of_reals(file)) {
      ADD_FAILURE() << where
                    << "\nstd::to_string of a real number. Write fmt::format(\"{:.3g}\", x).";
    }
  }
  EXPECT_EQ(libraries, 9U);
}

/// Sources with CLI11's header that call std::to_string at all.
Findings texts_beside_cli(const std::vector<SourceFile>& tree) {
  Findings findings;
  for (const SourceFile& file : tree) {
    if (!file.path.ends_with(".cpp") || file.path.starts_with("tests/")) continue;
    bool with_cli = false;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      with_cli |= file.lines[i].starts_with("#include <CLI/");
      if (!with_cli || file.lines[i].find("std::to_string(") == std::string::npos) continue;
      findings.push_back(
          fmt::format("{}:{}: std::to_string beside <CLI/…>, where no test tells "
                      "whole numbers from reals. Write fmt::format(\"{{}}\", n).",
                      file.path, i + 1));
    }
  }
  return findings;
}

TEST(ArchitectureNumbers, NoneBesideTheCommandLinesHeader) {
  for (const std::string& finding : texts_beside_cli(read_tree(TANDEM_SOURCE_DIR))) {
    ADD_FAILURE() << finding;
  }
  EXPECT_EQ(
      texts_beside_cli({{"orchestrator/a.cpp", {"#include <CLI/CLI.hpp>", "std::to_string(x)"}}})
          .size(),
      1U);
  EXPECT_TRUE(texts_beside_cli({{"orchestrator/a.cpp", {"std::to_string(x)"}}}).empty());
}

TEST(ArchitectureNumbers, PlantedOnesAreFound) {
  EXPECT_FALSE(texts_of_reals(TANDEM_PLANTED_REAL).empty());
  EXPECT_TRUE(texts_of_reals(TANDEM_PLANTED_WHOLE).empty());
}

}  // namespace
}  // namespace tandem::architecture

// The committed reference of scenario files is what the key table says today.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

namespace {

std::string output_of(const std::string& arguments) {
  const std::string command = "'" TANDEM_BIN_DIR "/tandem' " + arguments;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  std::array<char, 4096> block{};
  for (std::size_t n = 0; (n = fread(block.data(), 1, block.size(), pipe)) > 0;) {
    text.append(block.data(), n);
  }
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

void expect_current(const std::string& file, const std::string& arguments) {
  std::ifstream stream(std::string(TANDEM_SOURCE_DIR) + "/" + file, std::ios::binary);
  const std::string committed((std::istreambuf_iterator<char>(stream)), {});
  const std::string current = output_of(arguments);
  EXPECT_FALSE(current.empty());
  // Not EXPECT_EQ: the difference of two long pages helps less than the remedy.
  EXPECT_TRUE(committed == current)
      << file << " is not what the keys say today. Write it anew: tandem " << arguments << " > "
      << file;
}

TEST(ScenarioDocs, PageIsCurrent) { expect_current("docs/scenario.md", "keys"); }
TEST(ScenarioDocs, SchemaIsCurrent) {
  expect_current("docs/scenario.schema.json", "keys --schema");
}

}  // namespace

#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/tandem_process.h"

namespace tandem::test {

/// The scenario of examples/chain_of_links with so many links, in a folder of the test; `ends`:
/// blocks or junctions.
inline std::filesystem::path chain_of(int links, const TemporaryFolder& folder,
                                      const std::string& ends = "blocks") {
  const Ended made =
      run_command({"/bin/sh", kExamples + "chain_of_links/make.sh", std::to_string(links), ends});
  EXPECT_EQ(made.code, 0) << made.output;
  std::string text = made.output;
  const std::string relative = "../slider_crank/";
  for (auto at = text.find(relative); at != std::string::npos; at = text.find(relative, at + 1)) {
    text.replace(at, relative.size(), kExamples + "slider_crank/");
  }
  write_file(folder / "chain.yaml", text);
  return folder / "chain.yaml";
}

}  // namespace tandem::test

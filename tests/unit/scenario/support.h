#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "protocol/contract/error.h"
#include "protocol/scenario/scenario_file.h"

namespace tandem::scenario {

/// A scenario file in a folder of its own, removed at the end.
class ScenarioFile {
 public:
  explicit ScenarioFile(const std::string& text) {
    static int number = 0;
    folder_ = std::filesystem::temp_directory_path() /
              ("tandem_scenario_" + std::to_string(getpid()) + "_" + std::to_string(number++));
    std::filesystem::create_directories(folder_);
    std::ofstream(path()) << text;
  }
  ~ScenarioFile() { std::filesystem::remove_all(folder_); }
  ScenarioFile(const ScenarioFile&) = delete;
  ScenarioFile& operator=(const ScenarioFile&) = delete;

  [[nodiscard]] std::filesystem::path folder() const { return folder_; }
  [[nodiscard]] std::filesystem::path path() const { return folder_ / "scenario.yaml"; }

 private:
  std::filesystem::path folder_;
};

inline Loaded load_text(const std::string& text, const Section& table,
                        const std::vector<Override>& overrides = {},
                        UnknownKeys unknown = UnknownKeys::Refuse) {
  return load(ScenarioFile(text).path(), table, overrides, unknown);
}

/// The lines of the error that loading `text` gives, each without the file's folder; none if good.
inline std::vector<std::string> defects_of(const std::string& text, const Section& table,
                                           const std::vector<Override>& overrides = {}) {
  const ScenarioFile file(text);
  std::vector<std::string> lines;
  try {
    (void)load(file.path(), table, overrides);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    std::string all = error.what();
    const std::string folder = file.folder().string() + "/";
    for (auto at = all.find(folder); at != std::string::npos; at = all.find(folder)) {
      all.erase(at, folder.size());
    }
    std::size_t begin = 0;
    for (auto end = all.find('\n'); end != std::string::npos; end = all.find('\n', begin)) {
      lines.push_back(all.substr(begin, end - begin));
      begin = end + 1;
    }
    lines.push_back(all.substr(begin));
  }
  return lines;
}

/// Claims that the file has exactly one defect, which reads like this.
inline void expect_defect(const std::string& text, const Section& table, const std::string& line) {
  EXPECT_EQ(defects_of(text, table), std::vector<std::string>{line}) << text;
}

}  // namespace tandem::scenario

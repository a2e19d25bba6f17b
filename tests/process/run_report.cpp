// tandem report: one page about runs.

#include <gtest/gtest.h>

#include "tests/support/tandem_process.h"

namespace tandem::test {
namespace {

bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

class RunReport : public testing::Test {
 protected:
  void run(const std::string& name, const std::string& scheme) const {
    const Ended ended = tandem_command({"run", kExamples + "two_masses/scenario.yaml", "--scheme",
                                        scheme, "--transport", "inproc", "--set",
                                        "run.duration_s=0.02", "--out", path(name)});
    ASSERT_EQ(ended.code, 0) << ended.output;
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_ / name).string();
  }

  TemporaryFolder folder_{"tandem_report"};
};

TEST_F(RunReport, ShowsAllRunsInOnePageThatNeedsNothingElse) {
  run("a", "explicit_serial");
  run("b", "interface_jacobian");
  const Ended ended = tandem_command({"report", path("a"), path("b"), "--out", path("page.html")});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const std::string page = read_file(path("page.html"));
  for (const char* words : {"1: explicit_serial", "2: interface_jacobian", "Port left",
                            "Port right", "fem_compute", "<svg", "</html>"}) {
    EXPECT_TRUE(has(page, words)) << words;
  }
  for (const char* link : {"<script", "<link", "<img", "href=", "src="}) {
    EXPECT_FALSE(has(page, link)) << link;
  }
}

TEST_F(RunReport, DamagedTableIsNamedWithItsLine) {
  run("a", "explicit_serial");
  write_file(path("a") + "/ports.csv", "t_s,left.p_x_m\n0,1\n0,1,2\n");
  const Ended ended = tandem_command({"report", path("a")});
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_TRUE(has(ended.output, "ports.csv:3: 3 values under 2 names")) << ended.output;
}

// What a kill leaves: no summary, and tables that end in mid-row.
TEST_F(RunReport, OfAKilledRunShowsWhatThereIsAndSaysWhatIsNot) {
  run("a", "explicit_serial");
  std::filesystem::remove(path("a") + "/summary.json");
  for (const std::string table : {"/ports.csv", "/steps.csv"}) {
    const auto size = std::filesystem::file_size(path("a") + table);
    std::filesystem::resize_file(path("a") + table, size - 5);
  }
  const Ended ended = tandem_command({"report", path("a")});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const std::string page = read_file(path("a") + "/report.html");
  // Rows: a header; of ports 21 times, of steps 20 macro steps.
  for (const char* words : {"the recording process was killed",
                            "ports.csv:22: the last row has no "
                            "end",
                            "steps.csv:21: the last row has no end"}) {
    EXPECT_TRUE(has(page, words)) << words;
    EXPECT_TRUE(has(ended.output, words)) << ended.output;
  }
  EXPECT_TRUE(has(page, "<td class=\"bad\">killed</td><td>19</td><td>0.019</td>")) << page;
}

TEST_F(RunReport, OfARunThatWasKilledBeforeItsFirstStepIsAPage) {
  run("a", "explicit_serial");
  std::filesystem::remove(path("a") + "/summary.json");
  for (const std::string table : {"/ports.csv", "/steps.csv"}) {
    const std::string text = read_file(path("a") + table);
    write_file(path("a") + table, text.substr(0, text.find('\n') + 1));
  }
  const Ended ended = tandem_command({"report", path("a")});
  ASSERT_EQ(ended.code, 0) << ended.output;
  EXPECT_TRUE(has(read_file(path("a") + "/report.html"), "</html>"));
}

TEST_F(RunReport, FolderWithoutARunIsRefused) {
  const Ended ended = tandem_command({"report", folder_.path().string()});
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_TRUE(has(ended.output, "is not a complete run folder")) << ended.output;
}

}  // namespace
}  // namespace tandem::test

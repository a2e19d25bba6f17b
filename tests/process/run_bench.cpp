#include <gtest/gtest.h>

#include "tests/support/tandem_process.h"

// `tandem bench exchange` as its users start it. What it measures depends on the machine; that it
// measures all it names, and cleans up, does not.
namespace tandem::test {
namespace {

TEST(BenchExchange, MeasuresEveryPathBesideTcpAndUdp) {
  const TemporaryFolder folder;
  const auto file = (folder / "rows.json").string();
  const Ended ended =
      tandem_command({"bench", "exchange", "--nodes", "1", "--repeat", "1", "--json", file});
  ASSERT_EQ(ended.code, 0) << ended.output;
  const auto rows = nlohmann::json::parse(read_file(file)).at("rows");
  ASSERT_EQ(rows.size(), 5U);
  std::vector<std::string> paths;
  for (const auto& row : rows) {
    paths.push_back(row.at("path").get<std::string>());
    EXPECT_EQ(row.at("placement"), "same");
    for (const char* column : {"raw_tcp_us", "raw_udp_us", "exchange_us", "record_us", "step_us"}) {
      const auto& times = row.at(column);
      EXPECT_GT(times.at("median").get<double>(), 0.0) << column;
      EXPECT_LE(times.at("median").get<double>(), times.at("p90").get<double>()) << column;
      EXPECT_LE(times.at("p90").get<double>(), times.at("p99").get<double>()) << column;
    }
    EXPECT_DOUBLE_EQ(row.at("ratio_tcp").get<double>(),
                     row.at("exchange_us").at("median").get<double>() /
                         row.at("raw_tcp_us").at("median").get<double>());
    // A step holds the exchange and its journal.
    EXPECT_GT(row.at("step_us").at("mean").get<double>(),
              row.at("exchange_us").at("mean").get<double>());
  }
  const std::vector<std::string> each{"direct", "direct+block", "direct+liblcm", "hub",
                                      "hub+liblcm"};
  EXPECT_EQ(paths, each);
}

TEST(BenchExchange, CountsWhatWasSentAgain) {
  const TemporaryFolder folder;
  const auto file = (folder / "rows.json").string();
  const Ended ended = tandem_command(
      {"bench", "exchange", "--nodes", "1", "--repeat", "1", "--path", "direct", "--json", file},
      with_preload({{"TANDEM_FAULT_DROP_PERCENT", "0.3"}, {"TANDEM_FAULT_SEED", "3"}},
                   TANDEM_FAULT_SHIM));
  ASSERT_EQ(ended.code, 0) << ended.output;
  const auto rows = nlohmann::json::parse(read_file(file)).at("rows");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_GT(rows.front().at("resent").get<int>(), 0);
}

TEST(BenchExchange, RefusesWhatItCannotMeasure) {
  for (const auto& [option, value] : std::vector<std::pair<std::string, std::string>>{
           {"--placement", "near"}, {"--nodes", "0"}, {"--path", "carrier"}, {"--repeat", "0"}}) {
    const Ended ended = tandem_command({"bench", "exchange", option, value});
    EXPECT_EQ(ended.code, 2) << option;
    EXPECT_NE(ended.output.find(option), std::string::npos) << ended.output;
  }
}

}  // namespace
}  // namespace tandem::test

#include "orchestrator/commands/bench_exchange_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "orchestrator/bench/exchange_benchmark.h"
#include "orchestrator/scenario/option_checks.h"
#include "protocol/contract/whole_file.h"

namespace tandem::orchestrator {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kPaths{"direct", "direct+block", "direct+liblcm", "hub",
                                      "hub+liblcm"};

void append(std::vector<double>& to, const std::vector<double>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// Nearest-rank quantiles and the mean.
Json statistics(std::vector<double> times_us) {
  std::sort(times_us.begin(), times_us.end());
  const auto at = [&](std::size_t percent) {
    return times_us.at(std::max<std::size_t>(1, (times_us.size() * percent + 99) / 100) - 1);
  };
  const double sum = std::accumulate(times_us.begin(), times_us.end(), 0.0);
  return {{"median", at(50)},
          {"p90", at(90)},
          {"p99", at(99)},
          {"mean", sum / static_cast<double>(times_us.size())}};
}

double median(const Json& row, const char* column) { return row.at(column).at("median"); }

struct BenchExchange {
  std::vector<int> nodes{1, 16, 256, 4096};
  std::vector<std::string> placements{"same"};
  std::vector<std::string> paths = kPaths;
  int repeat = 3;
  std::string json;

  void run() const {
    fmt::print("{:>5} {:<6} {:<14} {:>10} {:>10} {:>11} {:>11} {:>11} {:>7} {:>10} {:>10} {:>6}\n",
               "nodes", "cores", "path", "tcp_us", "udp_us", "exchange_us", "p90_us", "p99_us",
               "x tcp", "record_us", "step_us", "resent");
    Json rows = Json::array();
    for (const std::string& placement : placements) {
      for (const int count : nodes) {
        for (Json& row : measure(count, placement)) rows.push_back(std::move(row));
      }
    }
    if (!json.empty()) write_whole_file(json, Json{{"rows", rows}}.dump(2) + "\n");
  }

 private:
  /// The paths take turns, so that all of them see the same state of the machine.
  [[nodiscard]] std::vector<Json> measure(int count, const std::string& placement) const {
    std::vector<ExchangeSamples> samples(paths.size());
    for (int repetition = 0; repetition < repeat; ++repetition) {
      for (std::size_t i = 0; i < paths.size(); ++i) {
        const ExchangeSamples more = measure_exchange(make_case(count, placement, paths[i]));
        append(samples[i].raw_tcp_us, more.raw_tcp_us);
        append(samples[i].raw_udp_us, more.raw_udp_us);
        append(samples[i].exchange_us, more.exchange_us);
        append(samples[i].record_us, more.record_us);
        append(samples[i].step_us, more.step_us);
        samples[i].resent += more.resent;
      }
    }
    std::vector<Json> rows;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      rows.push_back(describe(count, placement, paths[i], samples[i]));
      print(rows.back());
    }
    return rows;
  }

  static ExchangeCase make_case(int count, const std::string& placement, const std::string& path) {
    ExchangeCase which{.nodes = count};
    which.placement = placement == "same"    ? Placement::Same
                      : placement == "cross" ? Placement::Cross
                                             : Placement::Free;
    which.driver = path.starts_with("hub") ? DriverPlace::Orchestrator : DriverPlace::Mbs;
    which.wait = path.ends_with("block") ? wire::Wait::Block : wire::Wait::Adaptive;
    which.receive = path.ends_with("liblcm") ? wire::Receive::Lcm : wire::Receive::Own;
    // A log of 1,000 steps takes half a kilobyte a step and node: fewer of them for many nodes.
    which.blocks = count > 1000 ? 8 : 20;
    which.per_block = count > 1000 ? 20 : 50;
    return which;
  }

  static Json describe(int count, const std::string& placement, const std::string& path,
                       const ExchangeSamples& samples) {
    Json row{{"nodes", count}, {"placement", placement}, {"path", path}};
    row["raw_tcp_us"] = statistics(samples.raw_tcp_us);
    row["raw_udp_us"] = statistics(samples.raw_udp_us);
    row["exchange_us"] = statistics(samples.exchange_us);
    row["record_us"] = statistics(samples.record_us);
    row["step_us"] = statistics(samples.step_us);
    row["ratio_tcp"] = median(row, "exchange_us") / median(row, "raw_tcp_us");
    row["ratio_udp"] = median(row, "exchange_us") / median(row, "raw_udp_us");
    row["resent"] = samples.resent;
    row["round_trips"] = samples.exchange_us.size();
    return row;
  }

  static void print(const Json& row) {
    const Json& exchange = row.at("exchange_us");
    fmt::print(
        "{:>5} {:<6} {:<14} {:>10.2f} {:>10.2f} {:>11.2f} {:>11.2f} {:>11.2f} {:>7.2f} "
        "{:>10.2f} {:>10.2f} {:>6}\n",
        row.at("nodes").get<int>(), row.at("placement").get<std::string>(),
        row.at("path").get<std::string>(), median(row, "raw_tcp_us"), median(row, "raw_udp_us"),
        median(row, "exchange_us"), exchange.at("p90").get<double>(),
        exchange.at("p99").get<double>(), row.at("ratio_tcp").get<double>(),
        row.at("record_us").at("mean").get<double>(), row.at("step_us").at("mean").get<double>(),
        row.at("resent").get<std::int64_t>());
    std::fflush(stdout);
  }
};

}  // namespace

void add_bench_exchange(CLI::App& bench) {
  auto command = std::make_shared<BenchExchange>();
  CLI::App* sub = bench.add_subcommand(
      "exchange", "One exchange of both sides beside raw TCP and UDP in the same run");
  sub->add_option("--nodes", command->nodes, "Motions there and wrenches back, comma-separated")
      ->delimiter(',')
      ->check(whole_number_between(1, 100000))
      ->capture_default_str();
  sub->add_option("--repeat", command->repeat, "Runs of each row; the paths take turns")
      ->check(whole_number_between(1, 10000))
      ->capture_default_str();
  sub->add_option("--placement", command->placements,
                  "Cores of the two processes: same, cross, free (as the kernel decides)")
      ->delimiter(',')
      ->check(CLI::IsMember({"same", "cross", "free"}))
      ->capture_default_str();
  sub->add_option(
         "--path", command->paths,
         "direct, or hub (all through the orchestrator); +block: no receiver polls; +liblcm: "
         "liblcm receives")
      ->delimiter(',')
      ->check(CLI::IsMember(kPaths))
      ->capture_default_str();
  sub->add_option("--json", command->json, "Also write the rows to this file");
  sub->footer(
      "Scheme explicit_serial on mock sides that compute nothing, with exchange.lcm, checksums,\n"
      "ledger and heartbeats as in every run. exchange_us: from N motions in memory to N wrenches\n"
      "in memory (median); tcp_us, udp_us: ping-pongs of as many bytes between the same two\n"
      "processes over 127.0.0.1, in turn with it. record_us, step_us: the driver's time for the\n"
      "journal of a step, and the whole step (means).");
  sub->callback([command] { command->run(); });
}

}  // namespace tandem::orchestrator

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "orchestrator/files/summary_number.h"
#include "orchestrator/study/compare.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

double per_step_us(const ComparedRuns& runs) {
  const auto steps = std::max<std::int64_t>(1, runs.summary.at("macro_steps").get<std::int64_t>());
  return 1e6 * median(runs.wall_s) / static_cast<double>(steps);
}

double steps_of(const ComparedRuns& runs) {
  return std::max(1.0, runs.summary.at("macro_steps").get<double>());
}

ordered_json run_json(const ComparedRuns& runs) {
  ordered_json json = runs.summary;
  json["wall_s"] = median(runs.wall_s);
  json["wall_s_of_repetitions"] = runs.wall_s;
  return json;
}

ordered_json spread_json(const Spread& spread) {
  return {{"median", spread.median}, {"min", spread.min}, {"max", spread.max}};
}

/// "7.3 % (6.1 … 13.5 %)" of a ratio, or that it is not resolved.
std::string percent_text(const Spread& ratio) {
  const auto percent = [](double value) { return 100.0 * (value - 1.0); };
  const std::string interval =
      fmt::format("{:+.1f} … {:+.1f} %", percent(ratio.min), percent(ratio.max));
  if (ratio.repetitions < 2) return fmt::format("{:+.1f} %, once", percent(ratio.median));
  if (!ratio.differs_from(1.0)) return "not resolved, " + interval;
  return fmt::format("{:+.1f} %, {}", percent(ratio.median), interval);
}

ordered_json scheme_json(const Comparison& comparison, const std::string& scheme) {
  const ComparedRuns& mono = comparison.find(Mode::Monolithic, scheme);
  const ComparedRuns& inproc = comparison.find(Mode::Inproc, scheme);
  const ComparedRuns& lcm = comparison.find(Mode::Lcm, scheme);
  const Spread over_inproc = ratio(lcm, inproc);
  const Spread over_mono = ratio(lcm, mono);
  const Spread transfer = transfer_us_per_step(lcm, inproc);
  ordered_json json;
  json["runs"] = {
      {"monolithic", run_json(mono)}, {"inproc", run_json(inproc)}, {"lcm", run_json(lcm)}};
  json["overhead"] = {{"lcm_over_inproc", over_inproc.median},
                      {"lcm_over_monolithic", over_mono.median},
                      {"transfer_us_per_step", transfer.median},
                      {"transfer_us_per_step_spread", spread_json(transfer)},
                      {"transfer_resolved", transfer.differs_from(0.0)},
                      {"booked_transfer_us_per_step", booked_transfer_us(lcm)},
                      {"lcm_over_inproc_spread", spread_json(over_inproc)},
                      {"lcm_over_monolithic_spread", spread_json(over_mono)}};
  json["difference"] = {{"lcm_vs_inproc_max", largest_difference(lcm, inproc)},
                        {"lcm_vs_monolithic_max_m", largest_distance_m(lcm, mono)}};
  return json;
}

std::vector<std::string> schemes_of(const Comparison& comparison) {
  std::vector<std::string> schemes;
  for (const ComparedRuns& runs : comparison.runs) {
    if (runs.mode == Mode::Lcm) schemes.push_back(runs.scheme);
  }
  return schemes;
}

void append_run_row(std::string& table, const Comparison& comparison, const ComparedRuns& runs) {
  const ComparedRuns& mono = comparison.runs.front();
  const std::string name = runs.mode == Mode::Monolithic
                               ? "monolithic"
                               : fmt::format("{}, {}", runs.scheme, to_string(runs.mode));
  if (runs.exit_code != 0) {
    fmt::format_to(std::back_inserter(table), "{:<28} {} at t = {} s: see below\n", name,
                   runs.summary.at("status").get<std::string>(),
                   runs.summary.value("simulated_s", 0.0));
    return;
  }
  const auto [least, greatest] = std::minmax_element(runs.wall_s.begin(), runs.wall_s.end());
  fmt::format_to(std::back_inserter(table),
                 "{:<28} {:>8.3f} {:>8.3f} … {:<8.3f} {:>9.1f} {:>9.3f} {:>10.2f} {:>10.3f}  {}\n",
                 name, median(runs.wall_s), *least, *greatest, per_step_us(runs),
                 runs.summary.at("realtime_ratio").get<double>(),
                 runs.summary.at("iterations").at("mean").get<double>(), ratio(runs, mono).median,
                 runs.mode == Mode::Monolithic
                     ? std::string("reference")
                     : fmt::format("{:.2e}", largest_distance_m(runs, mono)));
}

/// Why a run was not solved, once for both modes when they say the same.
void append_messages(std::string& table, const Comparison& comparison) {
  std::string last;
  for (const ComparedRuns& runs : comparison.runs) {
    if (runs.exit_code == 0) continue;
    const auto message = runs.summary.at("message").get<std::string>();
    if (message != last) {
      fmt::format_to(std::back_inserter(table), "\n{}: {}\n", runs.scheme, message);
    }
    last = message;
  }
}

/// Of one scheme that was solved.
void append_ledger(std::string& table, const Comparison& comparison, const std::string& scheme) {
  const std::array<const ComparedRuns*, 3> columns{&comparison.find(Mode::Monolithic, scheme),
                                                   &comparison.find(Mode::Inproc, scheme),
                                                   &comparison.find(Mode::Lcm, scheme)};
  for (const ComparedRuns* runs : columns) {
    if (runs->exit_code != 0) return;
  }
  fmt::format_to(std::back_inserter(table),
                 "\nwhere the time goes, µs per macro step (median repetition, {})\n"
                 "{:<28} {:>12} {:>12} {:>12}\n",
                 scheme, "", "monolithic", "inproc", "lcm");
  for (const auto& [key, unused] : columns[0]->summary.at("ledger_s").items()) {
    if (key == "discarded") continue;
    fmt::format_to(std::back_inserter(table), "{:<28}", key);
    for (const ComparedRuns* runs : columns) {
      const double steps = runs->summary.at("macro_steps").get<double>();
      const double seconds = runs->summary.at("ledger_s").at(key).get<double>();
      fmt::format_to(std::back_inserter(table), " {:>12.2f}", 1e6 * seconds / std::max(1.0, steps));
    }
    table += "\n";
  }
}

void append_price(std::string& table, const Comparison& comparison, const std::string& scheme) {
  const ComparedRuns& mono = comparison.find(Mode::Monolithic, scheme);
  const ComparedRuns& inproc = comparison.find(Mode::Inproc, scheme);
  const ComparedRuns& lcm = comparison.find(Mode::Lcm, scheme);
  if (lcm.exit_code != 0 || inproc.exit_code != 0) return;
  const Spread over_inproc = ratio(lcm, inproc);
  const Spread over_mono = ratio(lcm, mono);
  const double difference = largest_difference(lcm, inproc);
  fmt::format_to(
      std::back_inserter(table),
      "\n{}"
      "  lcm / in-process  {:.3f}  ({:.3f} … {:.3f})   the same scheme: {}\n"
      "  lcm / monolithic  {:.3f}  ({:.3f} … {:.3f})   port positions differ by at most {:.2e} m\n"
      "  one exchange: median {:.1f} µs, p99 {:.1f} µs; {} messages, {} bytes, {} sent again\n",
      price_text(scheme, mono, inproc, lcm), over_inproc.median, over_inproc.min, over_inproc.max,
      difference == 0.0 ? "every port value has the same bits"
                        : fmt::format("VALUES DIFFER by up to {:.3e}", difference),
      over_mono.median, over_mono.min, over_mono.max, largest_distance_m(lcm, mono),
      lcm.summary.at("exchange_us").at("median").get<double>(),
      lcm.summary.at("exchange_us").at("p99").get<double>(),
      lcm.summary.at("wire").at("messages").get<std::int64_t>(),
      lcm.summary.at("wire").at("bytes").get<std::int64_t>(),
      lcm.summary.at("wire").at("resent").get<std::int64_t>());
}

}  // namespace

Spread transfer_us_per_step(const ComparedRuns& lcm, const ComparedRuns& inproc) {
  std::vector<double> extra_us;
  for (std::size_t i = 0; i < std::min(lcm.wall_s.size(), inproc.wall_s.size()); ++i) {
    extra_us.push_back(1e6 * (lcm.wall_s[i] - inproc.wall_s[i]) / steps_of(lcm));
  }
  return spread_of(std::move(extra_us));
}

double booked_transfer_us(const ComparedRuns& lcm) {
  double sum_s = 0.0;
  for (const char* key : {"encode", "decode", "publish", "transit", "wait"}) {
    sum_s += number_at(lcm.summary.at("ledger_s"), key);
  }
  return 1e6 * sum_s / steps_of(lcm);
}

std::string price_text(const std::string& scheme, const ComparedRuns& mono,
                       const ComparedRuns& inproc, const ComparedRuns& lcm) {
  const Spread transfer = transfer_us_per_step(lcm, inproc);
  const std::string interval = fmt::format("{:.1f} … {:.1f} µs in {} repetition(s)", transfer.min,
                                           transfer.max, transfer.repetitions);
  const std::string difference =
      transfer.differs_from(0.0)
          ? fmt::format("{:.1f} µs per macro step ({})", transfer.median, interval)
          : fmt::format(
                "not resolved by the difference of wall times per macro step ({}): raise "
                "--repeat or quiet the machine",
                interval);
  const bool compared = mono.exit_code == 0;
  return fmt::format(
      "{}: cost of transfer and synchronisation: {}\n"
      "  the ledger's own sum of it (encode, decode, publish, transit, wait): {:.1f} µs per macro "
      "step\n"
      "  conclusion: the run over LCM takes {} against the same scheme in process{}\n",
      scheme, difference, booked_transfer_us(lcm), percent_text(ratio(lcm, inproc)),
      compared ? ", and " + percent_text(ratio(lcm, mono)) + " against the monolithic run" : "");
}

ordered_json compare_json(const Comparison& comparison) {
  const std::vector<std::string> schemes = schemes_of(comparison);
  ordered_json json;
  json["scenario"] = comparison.scenario;
  json["repeat"] = comparison.repeat;
  json["scheme"] = schemes.front();
  json.update(scheme_json(comparison, schemes.front()));
  for (const std::string& scheme : schemes) {
    json["schemes"][scheme] = scheme_json(comparison, scheme);
  }
  return json;
}

std::string compare_table(const Comparison& comparison) {
  std::string table = fmt::format(
      "{}: {} macro steps, {} interleaved repetition(s), medians and spread\n\n"
      "{:<28} {:>8} {:>19} {:>9} {:>9} {:>10} {:>10}  {}\n",
      comparison.scenario, comparison.runs.front().summary.at("macro_steps").get<std::int64_t>(),
      comparison.repeat, "", "wall s", "least … greatest", "µs/step", "real time", "iterations",
      "/ mono", "max |Δp| m");
  for (const ComparedRuns& runs : comparison.runs) append_run_row(table, comparison, runs);
  for (const std::string& scheme : schemes_of(comparison)) {
    append_price(table, comparison, scheme);
  }
  for (const std::string& scheme : schemes_of(comparison)) {
    append_ledger(table, comparison, scheme);
  }
  append_messages(table, comparison);
  return table;
}

}  // namespace tandem::orchestrator

// The coupled step beside its parts, in one run: the same macro steps over LCM and in process, the
// flexible and the multibody side alone along the recorded interface, the exchange without solvers
// and a TCP ping-pong of as many bytes.
//   step_parts [--steps N] [--rounds N] [--check FILE]
// With a file of stored ratios ({"name": ratio}) the exit code is 1 where the median of the rounds
// is more than twice the stored one: ratios of times of one run hold on any machine, times do not.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "fem_process/sides/make_model.h"
#include "mbs_process/make_side.h"
#include "mbs_process/rigid_world.h"
#include "orchestrator/bench/exchange_benchmark.h"
#include "orchestrator/run/observed_run.h"
#include "orchestrator/study/compare.h"
#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

/// One evaluation a macro step along a recorded interface (µs a step): `values` of the entries of
/// the history are the inputs.
template <class Side, class Values>
double alone_us(Side& side, const History& history, const Values& values) {
  using In = std::decay_t<decltype(values(history.front()))>;
  (void)side.initialize(values(history.front()));
  const double start_s = now_s();
  for (std::size_t n = 1; n < history.size(); ++n) {
    side.checkpoint();
    StepRequest<In> request;
    request.step = history[n].time - history[n - 1].time;
    request.input = {.begin = values(history[n - 1]), .end = values(history[n])};
    const auto result = side.advance(request);
    require(result.outcome == Outcome::Done, "a side alone failed: " + result.message);
  }
  return 1e6 * (now_s() - start_s) / static_cast<double>(history.size() - 1);
}

/// Medians over the macro steps or round trips of a round (µs).
struct Round {
  double lcm = 0.0, inproc = 0.0, fem = 0.0, mbs = 0.0, exchange = 0.0, ping_pong = 0.0;
};

struct Part {
  const char* name;
  const char* text;
  double Round::*us;
};
constexpr Part kParts[] = {
    {"lcm", "coupled macro step over LCM", &Round::lcm},
    {"inproc", "the same in process", &Round::inproc},
    {"fem", "flexible side alone, one evaluation a step", &Round::fem},
    {"mbs", "multibody side alone, one evaluation a step", &Round::mbs},
    {"exchange", "exchange of 2 ports without solvers", &Round::exchange},
    {"ping_pong", "TCP ping-pong of as many bytes, blocking", &Round::ping_pong},
};

struct Ratio {
  const char* name;
  const char* text;
  double (*of)(const Round&);
};
constexpr Ratio kRatios[] = {
    {"inproc_over_parts", "in process over one evaluation of both sides",
     [](const Round& r) { return r.inproc / (r.fem + r.mbs); }},
    {"lcm_over_inproc", "over LCM over in process",
     [](const Round& r) { return r.lcm / r.inproc; }},
    {"exchange_over_ping_pong", "exchange over ping-pong",
     [](const Round& r) { return r.exchange / r.ping_pong; }},
};

/// The stored ratios are those of two cores: on one the sides take turns.
bool has_two_cores() { return std::thread::hardware_concurrency() >= 2; }

double step_us(const ObservedRun& run) {
  return 1e6 * run.summary.at("wall_s").get<double>() / run.summary.at("macro_steps").get<double>();
}

Round measure(const Model& model, const std::filesystem::path& folder) {
  Round round;
  const ObservedRun lcm = observe_run(model, Mode::Lcm, folder / "lcm", "over LCM");
  const ObservedRun here = observe_run(model, Mode::Inproc, folder / "inproc", "in process");
  require(lcm.exit_code == 0 && here.exit_code == 0, "a coupled run failed");
  round.lcm = step_us(lcm);
  round.inproc = step_us(here);
  const auto fem = fem::make_model(model.scenario.root, {});
  const auto mbs = mbs::make_side(model.scenario.root, {});
  round.fem = alone_us(*fem, here.history, [](const AcceptedInterface& i) { return i.motions; });
  round.mbs = alone_us(*mbs, here.history, [](const AcceptedInterface& i) { return i.wrenches; });
  const ExchangeSamples samples =
      measure_exchange({.nodes = static_cast<int>(model.port_names.size()),
                        .placement = has_two_cores() ? Placement::Cross : Placement::Free,
                        .blocks = 10});
  round.exchange = median(samples.exchange_us);
  round.ping_pong = median(samples.raw_tcp_us);
  return round;
}

template <class Value>
double median_of(const std::vector<Round>& rounds, const Value& value) {
  std::vector<double> values;
  for (const Round& round : rounds) values.push_back(value(round));
  return median(std::move(values));
}

/// Prints the tables; false where a ratio is more than twice the stored one.
bool report(const std::vector<Round>& rounds, const nlohmann::json& stored) {
  fmt::print("| part | µs |\n|---|---|\n");
  for (const Part& part : kParts) {
    fmt::print("| {} | {:.1f} |\n", part.text,
               median_of(rounds, [&](const Round& round) { return round.*part.us; }));
  }
  fmt::print("\n| ratio | median of {} | stored |\n|---|---|---|\n", rounds.size());
  bool good = true;
  for (const Ratio& ratio : kRatios) {
    const double now = median_of(rounds, ratio.of);
    const double before = stored.value(ratio.name, 0.0);
    const bool doubled = has_two_cores() && before > 0.0 && now > 2.0 * before;
    fmt::print(
        "| {} (`{}`) | {:.2f} | {} |\n", ratio.text, ratio.name, now,
        before > 0.0 ? fmt::format("{:.2f}{}", before, doubled ? ": MORE THAN TWICE" : "") : "–");
    good = good && !doubled;
  }
  return good;
}

int run(int count, char** arguments) {
  int steps = 100, rounds = 5;
  std::string check;
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string option = arguments[i];
    if (option == "--steps") steps = std::stoi(arguments[i + 1]);
    if (option == "--rounds") rounds = std::stoi(arguments[i + 1]);
    if (option == "--check") check = arguments[i + 1];
  }
  const Model model =
      load_model(std::filesystem::path(TANDEM_SOURCE_DIR) / "examples/lug/scenario.yaml",
                 {{"run.duration_s", fmt::format("{}", 1e-3 * steps)}});
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("step_parts_{}", getpid());
  std::vector<Round> measured;
  for (int i = 0; i < rounds; ++i) measured.push_back(measure(model, folder / std::to_string(i)));
  std::filesystem::remove_all(folder);
  nlohmann::json stored = nlohmann::json::object();
  if (!check.empty()) std::ifstream(check) >> stored;
  return report(measured, stored) ? 0 : 1;
}

}  // namespace
}  // namespace tandem::orchestrator

int main(int count, char** arguments) {
  try {
    return tandem::orchestrator::run(count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "step_parts: %s\n", error.what());
    return 2;
  }
}

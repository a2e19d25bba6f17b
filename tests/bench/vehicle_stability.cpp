// The largest macro step of the tracked vehicle with each coupling scheme: the table of
// docs/tracked_vehicle.md.
//   vehicle_stability [--from STEP] [SCHEME…]
// runs the 2 s of the example with longer and longer macro steps, from 1e-4 s or STEP on, until a
// run ends early or leaves the reference displacement by more than 5 %; with shorter ones when the
// first one does. All takes ten minutes.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/ancf_support.h"
#include "tests/support/beam_pair.h"

namespace tandem::coupled_test {
namespace {

constexpr double kMostDifference = 0.05;
const std::vector<std::string> kSteps{"1.25e-5", "2.5e-5", "5e-5", "1e-4", "2e-4",
                                      "2.5e-4",  "4e-4",   "5e-4", "1e-3", "2e-3",
                                      "4e-3",    "5e-3",   "8e-3", "1e-2"};

struct Scheme {
  std::string name;
  std::vector<std::string> overrides;
};

std::vector<Scheme> all_schemes() {
  std::vector<Scheme> schemes;
  for (const char* plain : {"explicit_serial", "explicit_parallel", "interface_jacobian", "tlm"}) {
    schemes.push_back({plain, {std::string("coupling.scheme=") + plain}});
  }
  for (const char* relaxation : {"constant", "aitken", "anderson", "iqn_ils", "iqn_imvj"}) {
    schemes.push_back(
        {std::string("implicit, ") + relaxation,
         {"coupling.scheme=implicit", std::string("coupling.relaxation=") + relaxation}});
  }
  return schemes;
}

struct Outcome {
  RunReport report;
  double difference = 0.0;   ///< largest of the displacement, 0.4 … 2 s
  double processor_s = 0.0;  ///< of the whole process
  [[nodiscard]] bool good() const {
    return report.status == RunStatus::Done && difference <= kMostDifference;
  }
};

/// Displacement of the reference's chassis at multiples of 0.2 s from 0.4 s on, by step of 0.1 s.
std::map<long, double> reference() {
  std::map<long, double> displacement;
  for (const auto& row : fem::ancf::testing::read_rows("vehicle_base_full.csv")) {
    const double t = fem::ancf::testing::number(row, "t");
    const long tenths = std::lround(10.0 * t);
    if (std::abs(10.0 * t - static_cast<double>(tenths)) > 1e-6 || tenths < 4 || tenths % 2 != 0) {
      continue;
    }
    displacement[tenths] = fem::ancf::testing::number(row, "x") - 0.41866002;
  }
  return displacement;
}

Outcome run(const Scheme& scheme, const std::string& step_s) {
  static const std::map<long, double> expected = reference();
  std::vector<std::string> overrides = scheme.overrides;
  overrides.push_back("run.macro_step_s=" + step_s);
  BeamPair pair("tracked_vehicle/scenario.yaml", overrides);
  Outcome outcome;
  const double start = pair.body("chassis").p_WB.x();
  const std::clock_t begin = std::clock();
  outcome.report = pair.run([&](const BeamPair& now) {
    const double t = now.t_s();
    const auto at = expected.find(std::lround(10.0 * t));
    if (at == expected.end() || std::abs(10.0 * t - static_cast<double>(at->first)) > 1e-6) return;
    const double moved = now.body("chassis").p_WB.x() - start;
    outcome.difference = std::max(outcome.difference, std::abs(moved / at->second - 1.0));
  });
  outcome.processor_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return outcome;
}

std::string end_of(const std::string& step_s, const Outcome& outcome) {
  if (outcome.report.status == RunStatus::Done) {
    return fmt::format("{} s is off by {:.1f} %", step_s, 100.0 * outcome.difference);
  }
  return fmt::format("{} s ends at {:.3g} s", step_s, to_seconds(outcome.report.simulated));
}

void print_row(const Scheme& scheme, std::size_t step) {
  std::optional<Outcome> last;
  std::string last_step = "none";
  std::string beyond = "not reached";
  bool longer = true;
  while (step < kSteps.size()) {
    const std::string& step_s = kSteps[step];
    Outcome outcome = run(scheme, step_s);
    fmt::print(stderr, "{} {} s: {}, {:.2f} evaluations, {:.2f} %, {:.1f} s {}\n", scheme.name,
               step_s, to_string(outcome.report.status),
               static_cast<double>(outcome.report.iterations_total) /
                   static_cast<double>(std::max<std::int64_t>(1, outcome.report.macro_steps)),
               100.0 * outcome.difference, outcome.processor_s, outcome.report.message);
    if (outcome.good()) {
      last_step = step_s;
      last = std::move(outcome);
      if (!longer) break;
      ++step;
      continue;
    }
    beyond = end_of(step_s, outcome);
    if (last || step == 0) break;
    // The first step was too long already.
    longer = false;
    --step;
  }
  if (!last) {
    fmt::print("| {} | none | | | | {} |\n", scheme.name, beyond);
    return;
  }
  fmt::print("| {} | {} s | {:.2f} | {:.1f} s | {:.2f} % | {} |\n", scheme.name, last_step,
             static_cast<double>(last->report.iterations_total) /
                 static_cast<double>(last->report.macro_steps),
             last->processor_s, 100.0 * last->difference, beyond);
}

void print_table(std::vector<std::string> names) {
  std::size_t first_step = 3;  // 1e-4 s
  if (names.size() >= 2 && names[0] == "--from") {
    const auto at = std::find(kSteps.begin(), kSteps.end(), names[1]);
    require(at != kSteps.end(), "--from takes one of 1e-4, 2e-4, 2.5e-4, 4e-4, 5e-4, 1e-3, …");
    first_step = static_cast<std::size_t>(at - kSteps.begin());
    names.erase(names.begin(), names.begin() + 2);
  }
  fmt::print(
      "| scheme | largest H | evaluations per step | processor time of 2 s | displacement off "
      "by at most | beyond |\n|---|---|---|---|---|---|\n");
  for (const Scheme& scheme : all_schemes()) {
    if (names.empty() || std::find(names.begin(), names.end(), scheme.name) != names.end()) {
      print_row(scheme, first_step);
    }
  }
}

}  // namespace
}  // namespace tandem::coupled_test

int main(int argc, char** argv) {
  try {
    tandem::coupled_test::print_table({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}

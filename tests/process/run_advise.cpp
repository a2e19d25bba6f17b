// What tandem advise recommends holds: it is run, on every example and on variants ten times
// lighter and heavier. The shortest of them always, the others with TANDEM_LONG (./test.sh --long).

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>

#include "tests/support/long_tests.h"
#include "tests/support/tandem_process.h"

namespace tandem::test {
namespace {

struct Variant {
  std::string example;  ///< below examples/, without .yaml
  std::string density;  ///< the key that it has for its density; empty: several materials
  double density_kg_per_m3 = 0.0;
  bool brief = false;  ///< within some seconds
};

std::vector<Variant> variants() {
  const std::string solid = "fem.material.density_kg_per_m3";
  const std::string chain = "fem.ancf.material.density_kg_per_m3";
  return {{"rotor/scenario", solid, 7850, true},
          {"rope_crane/scenario", chain, 1100, true},
          {"pendulum_beam/scenario", solid, 1100},
          {"two_masses/scenario", solid, 1000},
          {"slider_crank/scenario", solid, 1100},
          {"lug/scenario", solid, 1100},
          {"lug/steel", solid, 7850},
          {"lug/mounted", solid, 1100},
          {"bar15/scenario", solid, 1000},
          {"sandwich/scenario", "", 0},
          {"belt_drive/scenario", chain, 3600},
          {"tracked_vehicle/scenario", chain, 2000}};
}

/// Wall time for an advice.
double most_s() { return !long_tests() ? 40.0 : 120.0; }

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class AdviseHolds : public ::testing::TestWithParam<std::tuple<Variant, double>> {};

INSTANTIATE_TEST_SUITE_P(
    Examples, AdviseHolds,
    ::testing::Combine(::testing::ValuesIn(variants()), ::testing::Values(1.0, 0.1, 10.0)),
    [](const auto& tested) {
      std::string name = std::get<0>(tested.param).example;
      std::replace(name.begin(), name.end(), '/', '_');
      const double factor = std::get<1>(tested.param);
      return name + (factor == 1.0 ? "" : factor < 1.0 ? "_tenth" : "_tenfold");
    });

// The recommended settings run to the end as they are printed, as far as the advice says that they
// were tried: over the whole run, or over the time that it reached, which it then says. Their
// verdict is the one that the advice gives. It keeps to its wall time but for the macro step and
// the model that it is at, and for a machine that is busy.
TEST_P(AdviseHolds, RunsToTheEndWithWhatIsRecommended) {
  const auto& [variant, factor] = GetParam();
  if (!variant.brief && !long_tests()) {
    GTEST_SKIP() << "takes minutes: ./test.sh --long runs it";
  }
  if (variant.density.empty() && factor != 1.0) GTEST_SKIP() << "has several densities";
  const TemporaryFolder folder("tandem_advise");
  const std::string scenario = kExamples + variant.example + ".yaml";
  std::vector<std::string> command = {kTandem,
                                      "advise",
                                      scenario,
                                      "--most-s",
                                      std::to_string(most_s()),
                                      "--out",
                                      (folder / "a").string()};
  std::vector<std::string> changes;
  if (factor != 1.0) {
    changes = {"--set", variant.density + "=" + std::to_string(factor * variant.density_kg_per_m3)};
  }
  command.insert(command.end(), changes.begin(), changes.end());
  const auto start = std::chrono::steady_clock::now();
  const Ended advised = run_command(command, {}, 5.0 * most_s());
  ASSERT_EQ(advised.code, 0) << advised.output;
  EXPECT_LT(seconds_since(start), 2.0 * most_s()) << advised.output;

  const auto json = nlohmann::json::parse(read_file(folder / "a/advise.json"));
  const auto& recommended = json.at("recommended");
  const auto& check = json.at("check");
  EXPECT_TRUE(check.at("whole_run").get<bool>() || !recommended.at("undecided").empty())
      << advised.output;
  const auto& measured = recommended.at("measured");
  if (measured.is_null()) {  // nothing came to its end within the time, which was said
    EXPECT_FALSE(recommended.at("undecided").empty()) << advised.output;
    return;
  }

  command = {kTandem,       "run",    scenario, "--quiet",
             "--transport", "inproc", "--out",  (folder / "run").string()};
  command.insert(command.end(), changes.begin(), changes.end());
  for (const auto& setting : recommended.at("settings")) {
    command.insert(command.end(), {"--set", setting.get<std::string>()});
  }
  if (!check.at("whole_run").get<bool>()) {
    // As far as the run with the step went: a whole number of its steps.
    const double step_s = recommended.at("macro_step_s");
    const double steps = std::floor(measured.at("simulated_s").get<double>() / step_s + 1e-6);
    command.insert(command.end(), {"--set", "run.duration_s=" + std::to_string(steps * step_s)});
  }
  const Ended run = run_command(command, {}, 600.0);
  ASSERT_EQ(run.code, 0) << advised.output << run.output;
  if (!check.at("whole_run").get<bool>()) return;
  EXPECT_EQ(summary_of(folder / "run").at("verdict").at("status"),
            measured.at("verdict").at("status"))
      << advised.output << run.output;
}

}  // namespace
}  // namespace tandem::test

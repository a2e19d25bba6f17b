#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/tandem_process.h"

// The energy audit as users see it: summary.json and energy.csv.
namespace tandem::test {
namespace {

double value(const nlohmann::json& energy, const char* key) { return energy.at(key).get<double>(); }

/// Size of the terms that a balance is made of.
double scale_of(const nlohmann::json& side) {
  double scale = 0.0;
  for (const char* key :
       {"kinetic", "elastic", "external_work", "interface_work", "damping", "numerical"}) {
    scale += std::abs(value(side, key));
  }
  return scale;
}

struct Example {
  std::string name;
  double duration_s;
  double tolerance;  ///< of the flexible side's balance, relative to its terms
};

void PrintTo(const Example& e, std::ostream* out) { *out << e.name; }

class RunEnergy : public ::testing::TestWithParam<Example> {};

// Rigid bodies balance to round-off: 1e-11 of the terms over some hundred steps. What a
// co-rotational body's balance lacks is the linearisation of its internal forces, of second order
// in the step; a chain's that of contacts which begin or end within a step.
TEST_P(RunEnergy, BalanceOfTheExampleCloses) {
  const Example& example = GetParam();
  const TemporaryFolder folder;
  const Ended ended = run_command(run_of(
      example.name, folder / "run",
      {"--transport", "inproc", "--set", "run.duration_s=" + std::to_string(example.duration_s)}));
  ASSERT_EQ(ended.code, 0) << ended.output;
  const auto energy = summary_of(folder / "run").at("energy_J");
  const auto& mbs = energy.at("mbs");
  const auto& fem = energy.at("fem");
  EXPECT_LT(std::abs(value(mbs, "balance_error")), 1e-11 * (scale_of(mbs) + 1e-3));
  EXPECT_LT(std::abs(value(fem, "balance_error")), example.tolerance * scale_of(fem));
  EXPECT_NEAR(value(energy, "balance_error"),
              value(mbs, "balance_error") + value(fem, "balance_error"), 1e-9 * scale_of(mbs));
  EXPECT_NEAR(value(energy, "dissipated"), value(energy, "damping") + value(energy, "numerical"),
              1e-12 * (scale_of(mbs) + scale_of(fem)));
  EXPECT_GT(scale_of(fem), 1e-9);
  EXPECT_NE(ended.output.find("balance error"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Examples, RunEnergy,
    ::testing::Values(Example{"lug", 0.05, 1e-3}, Example{"two_masses", 0.1, 1e-4},
                      Example{"pendulum_beam", 0.1, 1e-4}, Example{"slider_crank", 0.05, 1e-4},
                      Example{"sandwich", 0.02, 1e-3}, Example{"belt_drive", 0.02, 1e-2},
                      Example{"tracked_vehicle", 0.005, 1e-2}),
    [](const auto& tested) { return tested.param.name; });

// Slow growth that the interface's monitor does not see: the bar's nodes by verlet under an
// explicit scheme, unstable at every step.
TEST(RunEnergyBalance, RunThatMakesItsOwnEnergyHasDiverged) {
  const TemporaryFolder folder;
  const Ended ended =
      run_command(run_of("bar15", folder / "run",
                         {"--transport", "inproc", "--scheme", "explicit_serial", "--set",
                          "mbs.integrator=verlet", "--set", "run.macro_step_s=0.0002"}));
  EXPECT_EQ(ended.code, 3) << ended.output;
  EXPECT_NE(ended.output.find("The steps make energy"), std::string::npos) << ended.output;
  EXPECT_EQ(summary_of(folder / "run").at("status"), "diverged");
}

// What the lug's balance lacks, a few parts in 1e4 of the terms at the example's step, is of second
// order.
TEST(RunEnergyBalance, ErrorOfTheLugIsOfSecondOrder) {
  const auto error_at = [](const std::string& step_s) {
    const TemporaryFolder folder;
    const Ended ended = run_command(run_of("lug", folder / "run",
                                           {"--transport", "inproc", "--set", "run.duration_s=0.03",
                                            "--set", "run.macro_step_s=" + step_s}));
    EXPECT_EQ(ended.code, 0) << ended.output;
    return value(summary_of(folder / "run").at("energy_J"), "balance_error");
  };
  EXPECT_NEAR(error_at("0.001") / error_at("0.0005"), 4.0, 0.5);
}

// Converged to a part in 1e12 of the wrench the two sides book the same work at the interface: what
// it creates is below 1e-9 of what passes through it.
TEST(RunEnergyDefect, OfConvergedSchemesIsNegligible) {
  for (const std::string example : {"two_masses", "lug"}) {
    const std::vector<std::vector<std::string>> schemes = {
        {"--scheme", "interface_jacobian"},
        {"--scheme", "implicit", "--set", "coupling.relaxation=aitken"},
        {"--scheme", "implicit", "--set", "coupling.relaxation=iqn_ils"}};
    for (const auto& scheme : schemes) {
      const TemporaryFolder folder;
      std::vector<std::string> arguments = {"--transport", "inproc",
                                            "--set",       "run.duration_s=0.05",
                                            "--set",       "coupling.relative_tolerance=1e-12",
                                            "--set",       "coupling.tolerance_N=1e-10",
                                            "--set",       "coupling.max_iterations=100"};
      arguments.insert(arguments.end(), scheme.begin(), scheme.end());
      const Ended ended = run_command(run_of(example, folder / "run", arguments));
      ASSERT_EQ(ended.code, 0) << example << " " << scheme.back() << ended.output;
      const auto energy = summary_of(folder / "run").at("energy_J");
      const double exchanged = value(energy, "exchanged_work");
      EXPECT_GT(exchanged, 1e-6);
      EXPECT_LT(std::abs(value(energy, "interface_defect_sum")), 1e-9 * exchanged)
          << example << " " << scheme.back();
      // Both sides' own books say the same: they take the work of the same wrench and motion.
      EXPECT_LT(std::abs(value(energy, "interface_work")), 1e-9 * exchanged)
          << example << " " << scheme.back();
    }
  }
}

// Energies are observed in the same places whatever the transport; observing leaves no trace in the
// states.
TEST(RunEnergyTable, IsTheSameOverLcmAndLeavesTheRunAsItIs) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.end(), {"--set", "run.duration_s=0.02"});
    const Ended ended = run_command(run_of("two_masses", folder / name, more));
    EXPECT_EQ(ended.code, 0) << ended.output;
    return summary_of(folder / name);
  };
  const std::string every = "output.energy_every_steps=2";
  const auto plain = run("plain", {"--transport", "inproc"});
  const auto here = run("here", {"--transport", "inproc", "--set", every});
  const auto lcm = run("lcm", {"--set", every});
  const auto hub = run("hub", {"--set", every, "--set", "wire.driver=orchestrator"});
  EXPECT_FALSE(std::filesystem::exists(folder / "plain/energy.csv"));
  const std::string table = read_file(folder / "here/energy.csv");
  // A header, t = 0 and every second of 20 steps.
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 12);
  EXPECT_EQ(table.substr(0, 35), "macro_step,t_s,mbs.kinetic_J,mbs.po");
  EXPECT_EQ(read_file(folder / "lcm/energy.csv"), table);
  EXPECT_EQ(read_file(folder / "hub/energy.csv"), table);
  EXPECT_EQ(here.at("state_hash"), plain.at("state_hash"));
  EXPECT_EQ(lcm.at("energy_J"), here.at("energy_J"));
}

}  // namespace
}  // namespace tandem::test

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/long_tests.h"
#include "tests/support/tandem_process.h"

// The co-simulation over LCM gives the bits of the same scheme in one process: every scheme and
// solver, with either driver, on a wire that loses, doubles and reorders datagrams, with one
// process slowed down, and again and again. A run that diverges diverges with the same bits.
namespace tandem::test {
namespace {

struct Case {
  std::string example;
  std::string scheme;
  std::string solver;  ///< cholmod, pcg; craig_bampton: the reduced body, which has none
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.example << ", " << c.scheme << ", " << c.solver;
}

// The iterative solver needs a tenth of a second for one linearised step of the lug.
int macro_steps_of(const Case& c) {
  if (c.solver == "cholmod") return 20;
  return c.example == "lug" ? 4 : 10;
}

std::vector<std::string> settings(const Case& c) {
  std::vector<std::string> arguments{"--set",
                                     "run.macro_step_s=0.001",
                                     "--set",
                                     "run.duration_s=" + std::to_string(1e-3 * macro_steps_of(c)),
                                     "--set",
                                     c.solver == "craig_bampton" ? "fem.formulation=craig_bampton"
                                                                 : "fem.solver.kind=" + c.solver};
  // What does not converge within the cap is accepted as such: here only the bits matter.
  const auto end_of_name = c.scheme.find('_');
  const std::string kind = c.scheme.substr(0, end_of_name);
  if (kind == "implicit" || kind == "parallel") {
    arguments.insert(
        arguments.end(),
        {"--scheme", "implicit", "--set", "coupling.max_iterations=8", "--set",
         "coupling.on_not_converged=accept", "--set",
         "coupling.relaxation=" + c.scheme.substr(end_of_name + 1), "--set",
         std::string("coupling.iteration=") + (kind == "parallel" ? "parallel" : "serial")});
  } else if (kind == "adaptive") {
    arguments.insert(arguments.end(), {"--scheme", "interface_jacobian", "--set",
                                       "coupling.adaptive.tolerance=0.01"});
  } else if (kind == "retained") {
    arguments.insert(arguments.end(), {"--scheme", "explicit_parallel", "--set",
                                       "coupling.retained_inertia.factor=1"});
  } else if (kind == "loose") {
    arguments.insert(
        arguments.end(),
        {"--scheme", "interface_jacobian", "--set", "ports.left.attachment=averaging", "--set",
         "ports.right.attachment=bushing", "--set",
         "ports.right.bushing={stiffness_N_per_m: [3e4, 3e4, 3e4], stiffness_Nm_per_rad: [40, 40, "
         "40], damping_Ns_per_m: [5, 5, 5]}"});
  } else if (kind == "micro") {
    arguments.insert(arguments.end(),
                     {"--scheme", "interface_jacobian", "--set", "fem.micro_step_s=0.00025"});
  } else if (kind == "second") {
    arguments.insert(arguments.end(),
                     {"--set", "mbs.integrator=verlet", "--set", "fem.integrator.kind=hht", "--set",
                      "coupling.jacobian.mbs_refresh=broyden"});
  } else {
    arguments.insert(arguments.end(), {"--scheme", c.scheme});
  }
  return arguments;
}

struct Result {
  int code = -1;
  std::string hash;
  std::string status;
  std::int64_t macro_steps = 0;
  std::int64_t iterations = 0;
  std::int64_t resent = 0;
  std::int64_t duplicates = 0;
  std::string output;
};

Result run(const TemporaryFolder& folder, const std::string& name, const Case& c,
           const std::vector<std::string>& more, const Environment& environment = {}) {
  std::vector<std::string> arguments = settings(c);
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Ended ended = run_command(run_of(c.example, folder / name, arguments), environment);
  const auto summary = summary_of(folder / name);
  Result result{.code = ended.code, .output = ended.output};
  if (!summary.contains("state_hash")) return result;
  result.hash = summary.at("state_hash").get<std::string>();
  result.status = summary.at("status").get<std::string>();
  result.macro_steps = summary.at("macro_steps").get<std::int64_t>();
  result.iterations = summary.at("iterations").at("total").get<std::int64_t>();
  result.resent = summary.at("wire").at("resent").get<std::int64_t>();
  result.duplicates = summary.at("wire").at("duplicates").get<std::int64_t>();
  std::filesystem::remove_all(folder / name);
  return result;
}

Environment faults(int percent) {
  const std::string text = std::to_string(percent);
  return with_preload({{"TANDEM_FAULT_SEED", "11"},
                       {"TANDEM_FAULT_DROP_PERCENT", text},
                       {"TANDEM_FAULT_DUPLICATE_PERCENT", text},
                       {"TANDEM_FAULT_REORDER_PERCENT", text}},
                      TANDEM_FAULT_SHIM);
}

Environment slowed(const std::string& program) {
  return with_preload({{"TANDEM_FAULT_PROGRAM", program}, {"TANDEM_FAULT_SLEEP_US", "2000"}},
                      TANDEM_FAULT_SHIM);
}

class SameBits : public testing::TestWithParam<Case> {
 protected:
  /// The run in one process that the others are held against, made by the first that needs it.
  void make_expected() {
    if (!expected_.hash.empty()) return;
    expected_ = run(folder_, "inproc", GetParam(), {"--transport", "inproc"});
    ASSERT_TRUE(expected_.code == 0 || expected_.code == 3) << expected_.output;
    ASSERT_EQ(expected_.hash.size(), 16U) << expected_.output;
    ASSERT_GT(expected_.iterations, 0);
  }
  Result expect_same(const std::string& name, const std::vector<std::string>& more,
                     const Environment& environment = {}) {
    make_expected();
    const Result result = run(folder_, name, GetParam(), more, environment);
    EXPECT_EQ(result.code, expected_.code) << name << ": " << result.output;
    EXPECT_EQ(result.hash, expected_.hash) << name << ": " << result.output;
    EXPECT_EQ(result.status, expected_.status) << name;
    EXPECT_EQ(result.macro_steps, expected_.macro_steps) << name;
    EXPECT_EQ(result.iterations, expected_.iterations) << name;
    return result;
  }

  /// What disturbs the exchange sees schemes and numbers of ports: one example of one port and one
  /// of two stand for the others, which ./test.sh --long disturbs, too.
  static bool stands_for_others() {
    const std::string& example = GetParam().example;
    return long_tests() || (example != "pendulum_beam" && example != "slider_crank");
  }

  TemporaryFolder folder_{"tandem_same_bits"};
  Result expected_;
};

TEST_P(SameBits, OverLcmAsInOneProcess) {
  expect_same("lcm", {"--transport", "lcm"});
  expect_same("hub", {"--transport", "lcm", "--driver", "orchestrator"});
}

// A lost datagram costs a time-out of 20 ms or more: one percentage with each driver.
TEST_P(SameBits, WhateverTheWireDoes) {
  if (!stands_for_others()) GTEST_SKIP() << "disturbed with ./test.sh --long";
  expect_same("one", {}, faults(1));
  const Result five = expect_same("five", {"--driver", "orchestrator"}, faults(5));
  EXPECT_GT(five.resent + five.duplicates, 0) << "the shim disturbed nothing";
}

TEST_P(SameBits, WithAnyProcessSlowed) {
  if (!stands_for_others()) GTEST_SKIP() << "disturbed with ./test.sh --long";
  expect_same("fem", {}, slowed("tandem-fem"));
  expect_same("mbs", {}, slowed("tandem-mbs"));
  expect_same("orchestrator", {"--driver", "orchestrator"}, slowed("tandem"));
}

// Second-order tetrahedra of two materials, one of them orthotropic.
class SameBitsOfTheSandwich : public SameBits {};

TEST_P(SameBitsOfTheSandwich, OverLcmAsInOneProcess) {
  make_expected();
  EXPECT_EQ(expected_.code, 0) << expected_.output;
  expect_same("lcm", {"--transport", "lcm"});
}

INSTANTIATE_TEST_SUITE_P(Solvers, SameBitsOfTheSandwich,
                         testing::Values(Case{"sandwich", "interface_jacobian", "pcg"},
                                         Case{"sandwich", "interface_jacobian", "cholmod"}));

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const char* example : {TANDEM_EXAMPLES}) {
    for (const char* scheme :
         {"explicit_serial", "implicit_constant", "implicit_aitken", "interface_jacobian"}) {
      for (const char* solver : {"cholmod", "pcg"}) cases.push_back({example, scheme, solver});
    }
    for (const char* scheme : {"explicit_parallel", "implicit_iqn_ils", "parallel_iqn_imvj", "tlm",
                               "adaptive_steps", "retained_inertia", "second_order"})
      cases.push_back({example, scheme, "cholmod"});
  }
  return cases;
}

std::string name_of(const testing::TestParamInfo<Case>& info) {
  return info.param.example + "_" + info.param.scheme + "_" + info.param.solver;
}

INSTANTIATE_TEST_SUITE_P(All, SameBits, testing::ValuesIn(all_cases()), name_of);

INSTANTIATE_TEST_SUITE_P(Reduced, SameBits,
                         testing::Values(Case{"lug", "interface_jacobian", "craig_bampton"},
                                         Case{"two_masses", "implicit_aitken", "craig_bampton"}),
                         name_of);

// Every node a body of the multibody side.
INSTANTIATE_TEST_SUITE_P(Nodal, SameBits,
                         testing::Values(Case{"bar15", "explicit_serial", "cholmod"},
                                         Case{"bar15", "interface_jacobian", "cholmod"}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(LoosePorts, SameBits,
                         testing::Values(Case{"two_masses", "loose_ports", "cholmod"},
                                         Case{"two_masses", "loose_ports", "pcg"}),
                         name_of);

// The learned interface Jacobian, and one factor for all micro steps.
INSTANTIATE_TEST_SUITE_P(MicroSteps, SameBits,
                         testing::Values(Case{"lug", "micro_steps", "cholmod"},
                                         Case{"two_masses", "micro_steps", "pcg"}),
                         name_of);

class Repeated : public SameBits {};

TEST_P(Repeated, FiveTimesTheSame) {
  for (int i = 1; i <= 5; ++i) {
    const std::string name = std::to_string(i);
    expect_same("lcm" + name, {"--driver", i % 2 == 0 ? "mbs" : "orchestrator"});
    expect_same("five_percent" + name, {"--driver", i % 2 == 0 ? "orchestrator" : "mbs"},
                faults(5));
  }
}

INSTANTIATE_TEST_SUITE_P(All, Repeated,
                         testing::Values(Case{"two_masses", "interface_jacobian", "cholmod"},
                                         Case{"two_masses", "explicit_serial", "pcg"},
                                         Case{"pendulum_beam", "implicit_aitken", "cholmod"}),
                         name_of);

}  // namespace
}  // namespace tandem::test

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/coupled_pair.h"
#include "tests/support/long_tests.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

struct SchemeRun {
  RunReport report;
  std::vector<Sample> samples;
  std::vector<PortInfo> ports;
};

SchemeRun run(const std::string& scenario, Mode mode, const CoupledPair::Overrides& overrides) {
  CoupledPair pair(scenario, overrides);
  SchemeRun result;
  result.report = pair.run(mode, [&](const Sample& s) { result.samples.push_back(s); });
  result.ports = pair.fem().info().ports;
  return result;
}

// The schemes stop at ‖r‖ ≤ 1e-12 ‖λ‖ (interface_jacobian: 1e-11 ‖λ‖) or at round-off, so one step
// differs by about 1e-12 relative and a second of 1000 steps of a damped system by less than their
// sum: 1e-9 is the project's bound.
constexpr double kAgreement = 1e-9;

/// Over a second, or a third of it.
void expect_same(const std::string& scenario) {
  const scenario::Override duration{"run.duration_s", test::long_tests() ? "1.0" : "0.3"};
  const SchemeRun monolithic = run(scenario, Mode::Monolithic, {duration});
  ASSERT_EQ(monolithic.report.status, RunStatus::Done) << monolithic.report.message;
  const std::vector<CoupledPair::Overrides> schemes = {
      {{"coupling.scheme", "interface_jacobian"}},
      {{"coupling.scheme", "implicit"}, {"coupling.relaxation", "aitken"}},
      {{"coupling.scheme", "implicit"}, {"coupling.relaxation", "constant"}},
      {{"coupling.scheme", "implicit"}, {"coupling.relaxation", "iqn_ils"}},
      {{"coupling.scheme", "implicit"},
       {"coupling.relaxation", "iqn_imvj"},
       {"coupling.iteration", "parallel"}}};
  for (CoupledPair::Overrides scheme : schemes) {
    scheme.insert(scheme.begin(), duration);
    const SchemeRun other = run(scenario, Mode::Inproc, scheme);
    ASSERT_EQ(other.report.status, RunStatus::Done) << other.report.message;
    const RelativeDifference difference =
        largest_relative_difference(monolithic.samples, other.samples);
    EXPECT_LT(difference.motions, kAgreement) << scheme.back().value;
    EXPECT_LT(difference.wrenches, kAgreement) << scheme.back().value;
  }
}

TEST(SchemesEqualMonolithic, TwoMasses) { expect_same("two_masses/scenario.yaml"); }

TEST(SchemesEqualMonolithic, Lug) { expect_same("lug/scenario.yaml"); }

// With what follows from run.accuracy a: each step leaves up to a/10 of the wrench, so the motions,
// to which the wrenches add up, stay within a, and the wrenches, which take part in every wave that
// an error sets off, within ten times a.
TEST(SchemesEqualMonolithic, ToTheAccuracyThatIsAskedFor) {
  for (const std::string scenario :
       {"two_masses/scenario.yaml", "slider_crank/scenario.yaml", "lug/scenario.yaml"}) {
    const scenario::Override duration = {"run.duration_s", "0.3"};
    const SchemeRun monolithic = run(scenario, Mode::Monolithic, {duration});
    ASSERT_EQ(monolithic.report.status, RunStatus::Done) << monolithic.report.message;
    for (const char* scheme : {"interface_jacobian", "implicit"}) {
      for (const char* accuracy : {"1e-4", "1e-6"}) {
        const SchemeRun other =
            run(scenario, Mode::Inproc,
                {duration, {"coupling.scheme", scheme}, {"run.accuracy", accuracy}});
        ASSERT_EQ(other.report.status, RunStatus::Done) << other.report.message;
        const RelativeDifference difference =
            largest_relative_difference(monolithic.samples, other.samples);
        EXPECT_LT(difference.motions, std::stod(accuracy)) << scenario << ", " << scheme;
        EXPECT_LT(difference.wrenches, 10.0 * std::stod(accuracy)) << scenario << ", " << scheme;
      }
    }
  }
}

// A coupling tolerance below what the flexible side's solver leaves in the wrench: what cannot fall
// further is recognised, in every scheme and in the monolithic step.
TEST(SchemesEqualMonolithic, WhatTheInnerSolverLeavesIsNoFailure) {
  const scenario::Override implicit = {"coupling.scheme", "implicit"};
  const std::vector<CoupledPair::Overrides> schemes = {
      {},
      {implicit},
      {implicit, {"coupling.relaxation", "iqn_ils"}},
      {implicit, {"coupling.relaxation", "iqn_imvj"}, {"coupling.iteration", "parallel"}}};
  for (const std::string scenario : {"two_masses/scenario.yaml", "lug/scenario.yaml"}) {
    for (const char* tolerance : {"1e-6", "1e-8"}) {
      const CoupledPair::Overrides fighting = {{"fem.solver.kind", "pcg"},
                                               {"fem.solver.tolerance", tolerance},
                                               {"coupling.relative_tolerance", "1e-10"},
                                               {"run.duration_s", "0.1"}};
      const SchemeRun monolithic = run(scenario, Mode::Monolithic, fighting);
      EXPECT_EQ(monolithic.report.status, RunStatus::Done) << monolithic.report.message;
      for (const CoupledPair::Overrides& scheme : schemes) {
        CoupledPair::Overrides overrides = fighting;
        overrides.insert(overrides.end(), scheme.begin(), scheme.end());
        const SchemeRun other = run(scenario, Mode::Inproc, overrides);
        EXPECT_EQ(other.report.status, RunStatus::Done) << scenario << other.report.message;
      }
    }
  }
}

// No wrench of this model is above 2e-13 N: what a scheme takes for nothing has its scale.
TEST(SchemesEqualMonolithic, ABarOfTenMicrometres) {
  const std::string scenario = "../tests/data/coupled/systems/ten_micrometres.yaml";
  const SchemeRun monolithic = run(scenario, Mode::Monolithic, {});
  ASSERT_EQ(monolithic.report.status, RunStatus::Done) << monolithic.report.message;
  const scenario::Override implicit = {"coupling.scheme", "implicit"};
  const scenario::Override secants = {"coupling.relaxation", "iqn_ils"};
  const std::vector<CoupledPair::Overrides> schemes = {
      {{"coupling.scheme", "interface_jacobian"}},
      {implicit, secants},
      {implicit, secants, {"coupling.iteration", "parallel"}},
      {implicit, {"coupling.max_iterations", "200"}}};  // Aitken takes up to 81
  for (const CoupledPair::Overrides& scheme : schemes) {
    const SchemeRun other = run(scenario, Mode::Inproc, scheme);
    ASSERT_EQ(other.report.status, RunStatus::Done) << other.report.message;
    const RelativeDifference difference =
        largest_relative_difference(monolithic.samples, other.samples);
    // Where a residual hardly falls for eight evaluations, the step ends below 100 roundings of the
    // positions: ε |p|/H times ‖ΔΛ‖/‖ΔV‖ = 1e-8 kg/s, 2e-21 N of 1e-13 N, in each of 200 steps.
    const bool to_floor = other.report.iterations_max > 8;
    const double agreement = to_floor ? 200 * 2e-8 : kAgreement;
    EXPECT_LT(difference.motions, agreement) << scheme.back().value;
    EXPECT_LT(difference.wrenches, agreement) << scheme.back().value;
  }
}

// Every direction of three ports moves, 54 unknowns of the parallel form, and the steps are so
// short that the rounding of the motions over H makes more of the wrenches than the tolerance: each
// kind of implicit iteration still ends, the quasi-Newton ones with a past on average within 7
// evaluations (the first step, which learns, needs up to 35), where the run in one system is.
TEST(SchemesEqualMonolithic, ThreePortsAtShortStepsInFewIterations) {
  const std::string scenario = "../tests/data/coupled/systems/three_ports.yaml";
  for (const char* step_s : {"0.00025", "0.000032"}) {
    const CoupledPair::Overrides steps = {
        {"run.macro_step_s", step_s},
        {"run.duration_s", step_s == std::string("0.00025") ? "0.02" : "0.00256"}};
    const SchemeRun monolithic = run(scenario, Mode::Monolithic, steps);
    for (const char* relaxation : {"aitken", "anderson", "iqn_ils", "iqn_imvj"}) {
      for (const char* iteration : {"serial", "parallel"}) {
        if (relaxation == std::string("aitken") && iteration == std::string("parallel")) continue;
        CoupledPair::Overrides overrides = steps;
        overrides.insert(overrides.end(), {{"coupling.scheme", "implicit"},
                                           {"coupling.relaxation", relaxation},
                                           {"coupling.iteration", iteration}});
        const SchemeRun other = run(scenario, Mode::Inproc, overrides);
        ASSERT_EQ(other.report.status, RunStatus::Done) << other.report.message;
        EXPECT_LT(largest_relative_difference(monolithic.samples, other.samples).motions,
                  kAgreement)
            << relaxation << ", " << iteration;
        double sum = 0.0;
        for (const Sample& sample : other.samples) sum += sample.iterations;
        if (relaxation == std::string("iqn_ils")) {
          EXPECT_LT(sum / 80.0, 7.0) << iteration << ", H = " << step_s;
        }
      }
    }
  }
}

// In steel the mesh's forces cancel in the wrench but for 1e-9 N of rounding, above the default
// tolerance: interface_jacobian sees that its residual only wavers, and keeps what it wavers at. It
// equals the run in one system to that, 1e-8 of the wrenches of some 100 N.
TEST(SchemesEqualMonolithic, SteelRotorToItsRoundOff) {
  for (const char* integrator : {"euler", "verlet"}) {
    const bool first = integrator == std::string("euler");
    const CoupledPair::Overrides steel = {
        {"fem.material.young_Pa", "2e11"},
        {"fem.material.density_kg_per_m3", "7800"},
        {"run.macro_step_s", "0.001"},
        {"mbs.integrator", integrator},
        {"fem.integrator.kind", first ? "backward_euler" : "newmark"}};
    const std::string scenario = "../tests/data/coupled/systems/rotor.yaml";
    const SchemeRun monolithic = run(scenario, Mode::Monolithic, steel);
    const SchemeRun newton = run(scenario, Mode::Inproc, steel);
    ASSERT_EQ(newton.report.status, RunStatus::Done) << newton.report.message;
    const RelativeDifference difference =
        largest_relative_difference(monolithic.samples, newton.samples);
    EXPECT_LT(difference.motions, kAgreement);
    EXPECT_LT(difference.wrenches, 1e-8);
    // A first step that learns the round-off.
    EXPECT_LT(newton.samples.back().iterations, first ? 4 : 5);
  }
}

// Steel answers the first guess of a step with 1e9 N. That says nothing of what the step may leave:
// both runs go on to the rounding of positions times stiffness, 1e-5 N, and agree to that part of
// the wrenches of some 100 N.
TEST(SchemesEqualMonolithic, SteelOnThreePortsToItsRoundOff) {
  const std::string scenario = "../tests/data/coupled/systems/three_ports.yaml";
  const CoupledPair::Overrides steel = {
      {"fem.material.young_Pa", "2e11"}, {"fem.material.density_kg_per_m3", "7800"},
      {"run.macro_step_s", "0.001"},     {"run.duration_s", "0.01"},
      {"mbs.integrator", "verlet"},      {"fem.integrator.kind", "hht"},
      {"fem.integrator.hht_alpha", "0"}};
  const SchemeRun monolithic = run(scenario, Mode::Monolithic, steel);
  const SchemeRun newton = run(scenario, Mode::Inproc, steel);
  ASSERT_EQ(newton.report.status, RunStatus::Done) << newton.report.message;
  for (const SchemeRun* made : {&monolithic, &newton}) {
    for (const Sample& sample : made->samples) EXPECT_LT(sample.residual_N, 1e-4);
  }
  const RelativeDifference difference =
      largest_relative_difference(monolithic.samples, newton.samples);
  EXPECT_LT(difference.motions, 1e-7);
  EXPECT_LT(difference.wrenches, 1e-6);
}

// A bar so stiff, or a step so long, that H² times its stiffness is 1e8 times the mass at its end:
// what the rounding of its nodes' positions makes of the wrench stands in the derivative by
// velocities alone. Both ways of solving end there; they agree to 4 ε K |p|, 1e-6 N of 1e3 N.
TEST(SchemesEqualMonolithic, AStiffBarAtLongStepsToItsRoundOff) {
  for (const char* young_Pa : {"1e9", "1e11"}) {
    for (const char* formulation : {"linear", "corotational"}) {
      const CoupledPair::Overrides metres = {{"fem.mesh.length_scale_m", "1"},
                                             {"fem.material.young_Pa", young_Pa},
                                             {"fem.formulation", formulation},
                                             {"fem.damping.beta_s", "0"},
                                             {"mbs.bodies.weight.mass_kg", "1"},
                                             {"mbs.bodies.weight.inertia_kg_m2", "[1, 1, 1]"},
                                             {"mbs.bodies.weight.position_m", "[1, 0, 0]"},
                                             {"run.macro_step_s", "1"},
                                             {"run.duration_s", "10"}};
      const std::string scenario = "../tests/data/coupled/systems/ten_micrometres.yaml";
      const SchemeRun monolithic = run(scenario, Mode::Monolithic, metres);
      ASSERT_EQ(monolithic.report.status, RunStatus::Done) << monolithic.report.message;
      const SchemeRun newton = run(scenario, Mode::Inproc, metres);
      ASSERT_EQ(newton.report.status, RunStatus::Done) << newton.report.message;
      EXPECT_LT(largest_relative_difference(monolithic.samples, newton.samples).wrenches, 1e-6);
    }
  }
}

// The default tolerance, 1e-11 of the wrench, is below the rounding of steel: 1e-8 N of some N.
TEST(SchemesEqualMonolithic, ExamplesInSteelWithDefaultTolerances) {
  for (const char* example : {"two_masses", "lug", "slider_crank", "pendulum_beam"}) {
    const std::string scenario = std::string(example) + "/scenario.yaml";
    const CoupledPair::Overrides steel = {{"fem.material.young_Pa", "2e11"},
                                          {"run.macro_step_s", "0.001"},
                                          {"run.duration_s", "0.03"}};
    const SchemeRun monolithic = run(scenario, Mode::Monolithic, steel);
    const SchemeRun newton = run(scenario, Mode::Inproc, steel);
    ASSERT_EQ(newton.report.status, RunStatus::Done) << example << ": " << newton.report.message;
    EXPECT_LT(largest_relative_difference(monolithic.samples, newton.samples).motions, 1e-8)
        << example;
  }
}

// With hold prediction the applied wrench is that of one step ago: an error of order H in the
// wrench, and so in every motion. Two ports, four halvings, in the early free motion where the
// wrench still changes.
TEST(ExplicitSerial, ConvergesToTheMonolithicSolutionWithOrderOne) {
  const std::string scenario = "two_masses/scenario.yaml";
  double coarser = 0.0;
  for (int halving = 0; halving <= 4; ++halving) {
    const CoupledPair::Overrides steps = {{"run.duration_s", "0.04"},
                                          {"run.macro_step_s", text_of(2.5e-4 / (1 << halving))},
                                          {"coupling.scheme", "explicit_serial"},
                                          {"coupling.prediction", "hold"}};
    const SchemeRun monolithic = run(scenario, Mode::Monolithic, steps);
    const SchemeRun serial = run(scenario, Mode::Inproc, steps);
    ASSERT_EQ(serial.report.status, RunStatus::Done) << serial.report.message;
    const Eigen::VectorXd difference_of_motion =
        difference(monolithic.samples.back().motions, serial.samples.back().motions);
    // Positions of both ports.
    const double error = std::hypot(difference_of_motion.segment<3>(0).norm(),
                                    difference_of_motion.segment<3>(12).norm());
    if (halving > 0) {
      EXPECT_NEAR(std::log2(coarser / error), 1.0, 0.15) << "halving " << halving;
    }
    coarser = error;
  }
}

// The lug outweighs its payload: linear extrapolation amplifies the wrench's error more than the
// hold does, and the run leaves its solution within a few steps.
TEST(ExplicitSerial, IsStoppedWithTheReasonOnTheLug) {
  const SchemeRun serial =
      run("lug/scenario.yaml", Mode::Inproc,
          {{"coupling.scheme", "explicit_serial"}, {"coupling.prediction", "linear"}});
  EXPECT_EQ(serial.report.status, RunStatus::Diverged);
  EXPECT_LT(serial.report.macro_steps, 20);
  for (const char* part : {"explicit_serial: diverged at t = ", "macro step ", "interface energy",
                           "port 'eye'", "interface_jacobian"}) {
    EXPECT_NE(serial.report.message.find(part), std::string::npos)
        << "'" << part << "' is missing in: " << serial.report.message;
  }
}

// What a run that is stopped says of its end is what a run says that ends before the failed macro
// step: neither the energy books nor the hash hold what was not accepted.
TEST(StoppedRun, HasTheBooksAndTheHashOfItsLastAcceptedState) {
  const std::string lug = "lug/scenario.yaml";
  const std::vector<CoupledPair::Overrides> stops = {
      {{"coupling.scheme", "explicit_serial"}},
      {{"coupling.max_iterations", "3"}, {"coupling.relative_tolerance", "3e-13"}}};
  for (const CoupledPair::Overrides& overrides : stops) {
    const RunReport stopped = run(lug, Mode::Inproc, overrides).report;
    ASSERT_NE(stopped.status, RunStatus::Done);
    ASSERT_GT(stopped.macro_steps, 0) << stopped.message;
    CoupledPair::Overrides until_then = overrides;
    until_then.push_back({"run.duration_s", text_of(to_seconds(stopped.simulated))});
    const RunReport done = run(lug, Mode::Inproc, until_then).report;
    ASSERT_EQ(done.macro_steps, stopped.macro_steps);
    EXPECT_EQ(stopped.state_hash, done.state_hash);
    EXPECT_EQ(stopped.energy_end.sum().total_J(), done.energy_end.sum().total_J());
    EXPECT_EQ(stopped.energy_end.fem.interface_work_J, done.energy_end.fem.interface_work_J);
    EXPECT_EQ(stopped.energy_end.mbs.interface_work_J, done.energy_end.mbs.interface_work_J);
    EXPECT_EQ(stopped.interface_defect_sum_J, done.interface_defect_sum_J);
    EXPECT_EQ(stopped.exchanged_work_J, done.exchanged_work_J);
  }
}

// Steel: neither fixed-point scheme has a solution to run to, Newton's has.
TEST(SteelLug, IsStoppedInFixedPointSchemesAndEqualsMonolithicInNewton) {
  const std::string file = "lug/steel.yaml";
  const scenario::Override short_run = {"run.duration_s", "0.3"};
  for (const char* scheme : {"explicit_serial", "implicit"}) {
    const SchemeRun fixed_point = run(file, Mode::Inproc, {short_run, {"coupling.scheme", scheme}});
    EXPECT_NE(fixed_point.report.status, RunStatus::Done) << scheme;
    EXPECT_NE(fixed_point.report.message.find(scheme), std::string::npos);
    EXPECT_NE(fixed_point.report.message.find("interface_jacobian"), std::string::npos)
        << fixed_point.report.message;
  }
  const SchemeRun monolithic = run(file, Mode::Monolithic, {short_run});
  const SchemeRun newton = run(file, Mode::Inproc, {short_run});
  ASSERT_EQ(newton.report.status, RunStatus::Done) << newton.report.message;
  EXPECT_LT(largest_relative_difference(monolithic.samples, newton.samples).motions, kAgreement);
  // The wrenches are as good as the scenario's tolerance, 1e-7 N, and the round-off of the
  // monolithic ones, 1e-8 N.
  for (std::size_t n = 0; n < newton.samples.size(); ++n) {
    const Eigen::VectorXd gap =
        stack(newton.samples[n].wrenches) - stack(monolithic.samples[n].wrenches);
    EXPECT_LT(wrench_norm_N(unstack_wrenches(gap), newton.ports), 2e-7) << "step " << n;
  }
}

}  // namespace
}  // namespace tandem::coupled_test

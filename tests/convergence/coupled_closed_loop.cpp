// Stiff flexible parts between light port bodies in a closed loop: what no step resolves.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/support/truth_case.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

constexpr const char* kLoop = "../tests/data/coupled/closed_loop.yaml";

/// ρ∞ = 1 is the undamped pair.
CoupledPair::Overrides damped(double rho) {
  return {{"mbs.integrator", "generalised_alpha"},
          {"mbs.rho_infinity", text_of(rho)},
          {"fem.integrator.kind", "generalised_alpha"},
          {"fem.integrator.rho_infinity", text_of(rho)}};
}

RunReport fall(CoupledPair::Overrides overrides, double step_s, double duration_s,
               Mode mode = Mode::Inproc) {
  overrides.push_back({"run.macro_step_s", text_of(step_s)});
  overrides.push_back({"run.duration_s", text_of(duration_s)});
  CoupledPair pair(kLoop, overrides);
  return pair.run(mode, [](const Sample&) {});
}

// A step of 2 ms moves a body of 1 g by 4 mm per newton, so the predicted wrench, which is off by
// about one, leads the ports away from where the flexible side was linearised. The Jacobians there
// were worth nothing: ten evaluations grew to fifty, the run stopped at 0.24 s.
TEST(ClosedLoop, IsSolvedInAFewEvaluationsPerStep) {
  for (const Mode mode : {Mode::Inproc, Mode::Monolithic}) {
    const RunReport report = fall(damped(1.0), 0.002, 0.5, mode);
    ASSERT_EQ(report.status, RunStatus::Done) << report.message;
    EXPECT_LT(static_cast<double>(report.iterations_total), 7.0 * 250.0);
  }
}

// The trapezoidal rule keeps the alternation of the ports and turning feeds it: after some periods
// the motion has grown out of all bounds. Damped in what the step does not resolve, it goes on as
// long as one likes.
TEST(ClosedLoop, GrowsUndampedAndSaysSoAndDoesNotGrowDamped) {
  const RunReport undamped = fall(damped(1.0), 0.004, 3.0);
  EXPECT_NE(undamped.status, RunStatus::Done);
  EXPECT_NE(undamped.message.find("have alternated from step to step"), std::string::npos)
      << undamped.message;
  EXPECT_NE(undamped.message.find("mbs.integrator"), std::string::npos) << undamped.message;

  const RunReport report = fall(damped(0.8), 0.004, 3.0);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  const double held_J = report.energy_start.sum().total_J();
  // Less than the method takes in three seconds at a step that is eight times too long.
  EXPECT_NEAR(report.energy_end.sum().total_J(), held_J, 0.05 * held_J);
  EXPECT_GT(report.energy_end.sum().numerical_loss_J, 0.0);
}

// The damped pair is of second order like the undamped one: against the RK4 trajectory of the uncut
// system, two-sided, as SecondOrder asks it of that.
TEST(GeneralisedAlphaPair, PortMotionsOfTwoMassesConvergeWithOrderTwo) {
  const Trajectory reference = reference_of(two_masses());
  std::map<std::string, double> coarser;
  for (double h_s : {5e-4, 2.5e-4, 1.25e-4, 6.25e-5}) {
    TruthCase truth = two_masses();
    for (const scenario::Override& o : damped(0.8)) truth.overrides.push_back(o);
    const auto errors = largest_errors(truth, monolithic_trajectory(truth, h_s), reference);
    for (const char* quantity : {"left_pos", "right_pos", "distance"}) {
      const double error = errors.at(quantity);
      if (coarser.contains(quantity)) {
        EXPECT_NEAR(std::log2(coarser.at(quantity) / error), 2.0, 0.15)
            << quantity << " at " << h_s << " s";
      }
      coarser[quantity] = error;
    }
  }
}

}  // namespace
}  // namespace tandem::coupled_test

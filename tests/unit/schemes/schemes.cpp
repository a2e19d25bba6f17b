// Schemes against closed forms on the split oscillator, see tests/support/split_oscillator.h.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "protocol/schemes/divergence_monitor.h"
#include "protocol/schemes/residual_floor.h"
#include "tests/support/split_oscillator.h"

namespace tandem {
namespace {

using test::MassMbs;
using test::MassSpringFem;

using test::Journals;
using Case = test::SplitOscillator;

TEST(ExplicitSerial, MultipliesAnErrorOfTheWrenchByMinusKappa) {
  // k = 0 and hold: λ_{n+1} = −μ/m λ_n exactly, so successive wrenches have the ratio −κ to
  // round-off.
  Case c{.fem_kg = 0.5};
  c.coupling = {.scheme = SchemeKind::ExplicitSerial, .prediction = Prediction::Hold};
  MassMbs mbs(c.mbs_kg, {.v = 1.0});
  MassSpringFem fem(c.fem_kg, 0.0);
  ExplicitSerial scheme(c.coupling, fem.info().ports);
  InterfaceState state;
  state.motions = mbs.initialize(WrenchSet(1));
  state.wrenches = fem.initialize(state.motions);
  state.wrenches[0].f_P_W.x() = 1.0;
  const SimTime H = sim_time_from_seconds(1e-3);
  const auto first = scheme.advance(H, state, mbs, fem);
  EXPECT_NEAR(first.wrenches[0].f_P_W.x(), -0.5, 1e-12);
}

TEST(ExplicitSerial, IsStableBelowAndStoppedAboveTheMassRatio) {
  Case c{.fem_kg = 0.9, .stiffness = 10.0};
  c.coupling = {.scheme = SchemeKind::ExplicitSerial, .prediction = Prediction::Hold};
  EXPECT_EQ(run(c).status, RunStatus::Done);
  c.fem_kg = 1.5;
  const RunReport report = run(c);
  EXPECT_EQ(report.status, RunStatus::Diverged);
  EXPECT_EQ(report.exit_code(), 3);
  EXPECT_NE(report.message.find("port 'p'"), std::string::npos) << report.message;
  EXPECT_NE(report.message.find("macro step"), std::string::npos) << report.message;
  EXPECT_NE(report.message.find("interface_jacobian"), std::string::npos) << report.message;
}

// An error of the wrench grows by the root z of z² = −κ (2z − 1): with κ = 1/2 by (1 + √3)/2
// = 1.366 per macro step, and from that the message finds κ again, which is above the limit it
// names.
TEST(ExplicitSerial, NamesTheMassRatioAndTheLimitOfItsPrediction) {
  const std::vector<std::pair<Prediction, std::string>> limits = {
      {Prediction::Hold, "hold is 1."},
      {Prediction::Linear, "linear is 0.333."},
      {Prediction::Quadratic, "quadratic is 0.143."}};
  for (const auto& [prediction, limit] : limits) {
    Case c{
        .fem_kg = prediction == Prediction::Hold ? 1.5 : 0.5, .stiffness = 10.0, .duration_s = 0.2};
    c.coupling = {.scheme = SchemeKind::ExplicitSerial, .prediction = prediction};
    const RunReport report = run(c);
    ASSERT_EQ(report.status, RunStatus::Diverged);
    EXPECT_NE(report.message.find(limit), std::string::npos) << report.message;
    const std::string before = "times its stiffness) is ";
    const auto at = report.message.find(before);
    ASSERT_NE(at, std::string::npos) << report.message;
    // The first steps of the streak still hold other roots.
    EXPECT_NEAR(std::stod(report.message.substr(at + before.size())), c.fem_kg, 0.1 * c.fem_kg)
        << report.message;
  }
}

TEST(DivergenceMonitor, FindsTheRatioThatGrowthBelongsTo) {
  for (const double kappa : {0.5, 1.0, 3.0}) {
    const double z = kappa + std::sqrt(kappa * kappa + kappa);  // z² = κ (2z + 1)
    EXPECT_NEAR(ratio_of_growth(z, Prediction::Linear), kappa, 1e-14);
    EXPECT_EQ(ratio_of_growth(kappa, Prediction::Hold), kappa);
  }
  EXPECT_NEAR(ratio_of_growth(1.0, Prediction::Linear), 1.0 / 3.0, 1e-15);
  EXPECT_NEAR(ratio_of_growth(1.0, Prediction::Quadratic), 1.0 / 7.0, 1e-15);
}

TEST(DivergenceMonitor, RoundOffOfAModelAtRestIsNoDivergence) {
  // Growth by 1e12 within the streak, but of velocities that move nothing: 1e-11 m of 0.1 m at
  // most.
  DivergenceMonitor monitor(1e3, {{"p", 0.1}});
  double force_N = 1e-20;
  for (int n = 0; n < 12; ++n, force_N *= -10.0) {
    MacroStepEnd end;
    end.motions = MotionSet(1);
    end.motions[0].v_WP.x() = force_N;
    end.wrenches = WrenchSet(1);
    end.wrenches[0].f_P_W.x() = force_N;
    end.applied = WrenchSet(1);
    end.residual_N = std::abs(force_N);
    EXPECT_FALSE(monitor.check(sim_time_from_seconds(1e-3), end).has_value());
  }
}

TEST(ExplicitSerial, ConvergesToTheCoupledStepWithOrderOne) {
  // Two-sided window over four halvings; κ = 0.2 so that start-up transients die out at once.
  double last_error = 0.0;
  for (int level = 0; level < 5; ++level) {
    Case c{
        .fem_kg = 0.2, .stiffness = 400.0, .duration_s = 0.16, .step_s = 1e-3 / std::pow(2, level)};
    c.coupling = {.scheme = SchemeKind::ExplicitSerial, .prediction = Prediction::Hold};
    const double error = phase_distance(c, run(c));
    if (level > 0) {
      EXPECT_NEAR(std::log2(last_error / error), 1.0, 0.15) << "level " << level;
    }
    last_error = error;
  }
}

TEST(Implicit, SolvesTheCoupledStepWhereExplicitDiverges) {
  for (Relaxation relaxation : {Relaxation::Constant, Relaxation::Aitken}) {
    Case c{.fem_kg = 1.5, .stiffness = 4000.0};
    c.coupling = {.scheme = SchemeKind::Implicit,
                  .max_iterations = 200,
                  .relaxation = relaxation,
                  .relaxation_factor = 0.4};
    const RunReport report = run(c);
    ASSERT_EQ(report.status, RunStatus::Done) << report.message;
    // The residual limit 1e-10 relative over 100 steps leaves errors of about 1e-9 relative.
    EXPECT_NEAR(report.motions[0].p_WP.x(), exact_step_state(c).x, 1e-9);
  }
}

TEST(Implicit, AitkenIsExactOnAScalarAffineProblem) {
  // With one unknown Aitken's factor is the secant method: exact for an affine map after two
  // residuals.
  Case c{.fem_kg = 3.0, .stiffness = 1000.0};
  c.coupling = {.scheme = SchemeKind::Implicit, .relaxation_factor = 0.1};
  const RunReport report = run(c);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_LE(report.iterations_max, 3);
}

TEST(Implicit, ReachingTheCapIsNotConvergence) {
  // An iteration shrinks the residual by 1 − 0.1 (1 + κ) = 0.4: ten leave 1e-4 of it, not
  // round-off.
  Case c{.fem_kg = 5.0, .stiffness = 100.0};
  c.coupling = {.scheme = SchemeKind::Implicit,
                .max_iterations = 10,
                .tolerance_N = 0.0,
                .relative_tolerance = 1e-15,
                .relaxation = Relaxation::Constant,
                .relaxation_factor = 0.1};
  const RunReport stopped = run(c);
  EXPECT_EQ(stopped.status, RunStatus::NotConverged);
  EXPECT_EQ(stopped.macro_steps, 0);
  EXPECT_NE(stopped.message.find("max_iterations"), std::string::npos) << stopped.message;
  c.coupling.on_not_converged = OnNotConverged::Accept;
  const RunReport accepted = run(c);
  EXPECT_EQ(accepted.status, RunStatus::Done);
  EXPECT_EQ(accepted.not_converged_steps, accepted.macro_steps);
}

TEST(InterfaceJacobian, NeedsTwoEvaluationsWhereTheSidesAreAffine) {
  Case c{.fem_kg = 50.0, .stiffness = 1e6};
  c.coupling = {.scheme = SchemeKind::InterfaceNewton};
  const RunReport report = run(c);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_LE(report.iterations_max, 2);
  EXPECT_NEAR(report.motions[0].p_WP.x(), exact_step_state(c).x, 1e-9);
}

TEST(InterfaceJacobian, ConvergesOnAHardeningSpring) {
  Case c{.fem_kg = 2.0, .stiffness = 1e4, .hardening = 1e3};
  c.coupling = {.scheme = SchemeKind::InterfaceNewton};
  const RunReport report = run(c);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_GT(report.iterations_max, 2);
}

/// Trilinear Coulomb friction on the port: λ = −F clamp(v/v₀, −1, 1). It has no state.
class Brake final : public FemSide {
 public:
  Brake(double limit_N, double speed_m_per_s) : limit_N_(limit_N), speed_(speed_m_per_s) {
    info_ = {.name = "fem", .ports = {{"p", 0.1}}, .can_linearize = true};
  }
  const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override { return {friction(motions)}; }
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override {
    StepResult<WrenchSet> result{.outcome = Outcome::Done, .message = ""};
    result.output = {friction(request.input.end)};
    const bool sticks = std::abs(request.input.end[0].v_WP.x()) < speed_;
    result.jacobian = InterfaceJacobian::Zero(6, 12);
    if (sticks) (*result.jacobian)(0, 6) = -limit_N_ / speed_;
    return result;
  }
  void checkpoint() override { ++accepted; }
  void rollback() override { ++rejected; }
  Observation observe() override { return {}; }
  int accepted = 0, rejected = 0;

 private:
  [[nodiscard]] Wrench friction(const MotionSet& motions) const {
    Wrench wrench;
    wrench.f_P_W.x() = -limit_N_ * std::clamp(motions[0].v_WP.x() / speed_, -1.0, 1.0);
    return wrench;
  }
  SubsystemInfo info_;
  double limit_N_, speed_;
};

TEST(InterfaceJacobian, FindsTheStickBetweenTwoSlips) {
  // Sliding at 0.3 m/s, which the brake's impulse H F/m = 1 m/s more than stops: slipping either
  // way makes it slip the other way, full Newton steps go round without end. It sticks with
  // v + (H F/m) v/v₀ = 0.3 m/s.
  MassMbs mbs(1.0, {.v = 0.3});
  Brake brake(1000.0, 0.1);
  InterfaceJacobianScheme scheme({}, brake.info().ports);
  InterfaceState state;
  state.motions = mbs.initialize(WrenchSet(1));
  state.wrenches = WrenchSet(1);
  mbs.checkpoint();
  const MacroStepEnd end = scheme.advance(sim_time_from_seconds(1e-3), state, mbs, brake);
  ASSERT_EQ(end.outcome, Outcome::Done) << end.message;
  EXPECT_NEAR(end.motions[0].v_WP.x(), 0.3 / 11.0, 1e-12);
  EXPECT_EQ(brake.rejected, end.iterations - 1);
}

TEST(InterfaceJacobian, RefusesASideWithoutJacobian) {
  MassMbs mbs(1.0, {}, false);
  MassSpringFem fem(1.0, 1.0);
  InterfaceJacobianScheme scheme({}, fem.info().ports);
  InterfaceState state;
  state.motions = mbs.initialize(WrenchSet(1));
  state.wrenches = fem.initialize(state.motions);
  EXPECT_THROW((void)scheme.advance(sim_time_from_seconds(1e-3), state, mbs, fem), Error);
}

TEST(CoupledRun, ReportsAFailedSideWithPlaceAndCause) {
  MassMbs mbs(1.0, {.v = 1.0});
  MassSpringFem fem(0.1, 1.0);
  fem.fail_at_advance = 4;
  CouplingParams coupling{.scheme = SchemeKind::ExplicitSerial};
  const auto params =
      scheme_run({sim_time_from_seconds(0.01), sim_time_from_seconds(0.001)}, coupling);
  Journals journals;
  const RunReport report = run_coupled(params, {mbs}, {fem}, journals);
  EXPECT_EQ(report.status, RunStatus::SolverFailed);
  EXPECT_EQ(report.macro_steps, 3);
  EXPECT_NE(report.message.find("macro step 4"), std::string::npos) << report.message;
  EXPECT_NE(report.message.find("fails on purpose"), std::string::npos) << report.message;
}

TEST(CoupledRun, JournalHoldsEveryCallAndMarksTheAcceptedOnes) {
  Case c{.fem_kg = 1.5, .stiffness = 100.0, .duration_s = 0.005};
  c.coupling = {.scheme = SchemeKind::Implicit};
  Journals journals;
  const RunReport report = run(c, journals);
  ASSERT_EQ(report.status, RunStatus::Done);
  ASSERT_EQ(journals.steps.size(), 6U);  // initialization and five macro steps
  for (std::size_t n = 1; n < journals.steps.size(); ++n) {
    const wire::StepJournal& journal = journals.steps[n];
    EXPECT_EQ(journal.calls.size(), 2U * static_cast<std::size_t>(journal.step.iterations));
    int accepted = 0;
    for (const wire::CallRecord& call : journal.calls) accepted += call.accepted ? 1 : 0;
    EXPECT_EQ(accepted, 2);
    EXPECT_TRUE(journal.calls.back().accepted);
  }
}

/// Takes at least a known time in every call.
template <class Side, class In, class Out>
class Slow final : public Subsystem<In, Out> {
 public:
  Slow(Side side, std::chrono::milliseconds time) : side_(std::move(side)), time_(time) {}
  const SubsystemInfo& info() const override { return side_.info(); }
  Out initialize(const In& in) override { return side_.initialize(in); }
  StepResult<Out> advance(const StepRequest<In>& request) override {
    std::this_thread::sleep_for(time_);
    return side_.advance(request);
  }
  void checkpoint() override { side_.checkpoint(); }
  void rollback() override { side_.rollback(); }
  Observation observe() override { return side_.observe(); }
  [[nodiscard]] int advances() const { return side_.advances; }

 private:
  Side side_;
  std::chrono::milliseconds time_;
};

TEST(CoupledRun, LedgerBooksEverySideInItsColumnAndNoTimeTwice) {
  // A sleep is never shorter than asked for, so these bounds hold on any machine: a time booked in
  // the wrong column, left out, or booked twice breaks one of them.
  using std::chrono::milliseconds;
  Slow<MassMbs, WrenchSet, MotionSet> mbs(MassMbs(1.0, {.x = 0.01, .v = 1.0}), milliseconds(1));
  Slow<MassSpringFem, MotionSet, WrenchSet> fem(MassSpringFem(0.5, 100.0), milliseconds(3));
  const auto params =
      scheme_run({sim_time_from_seconds(0.01), sim_time_from_seconds(0.001)}, CouplingParams{});
  Journals journals;
  const auto begin = std::chrono::steady_clock::now();
  const RunReport report = run_coupled(params, {mbs}, {fem}, journals);
  const double around_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_GE(mbs.advances(), 10);
  EXPECT_GE(report.ledger.mbs_compute_s, 1e-3 * mbs.advances());
  EXPECT_GE(report.ledger.fem_compute_s, 3e-3 * fem.advances());
  EXPECT_LE(report.ledger.named_s(), report.wall_s);
  EXPECT_LE(report.wall_s, around_s);
  EXPECT_GE(report.ledger.other_s, 0.0);
  EXPECT_LE(report.ledger.discarded_s, report.ledger.mbs_compute_s + report.ledger.fem_compute_s);
  EXPECT_GT(report.ledger.scheme_s, 0.0);
}

// Residuals that waver at 1e-9 N beside wrenches of 100 N are round-off, and known as such in the
// next macro step at its second evaluation; at 1e-7 N they are not.
TEST(ResidualFloor, IsWhatResidualsWaverAt) {
  ResidualFloor floor(1, 1e-11);
  floor.begin_step(0.0);
  EXPECT_FALSE(floor.reached(1.0, 100.0, 0.0));
  EXPECT_FALSE(floor.reached(1e-9, 100.0, 0.0));
  EXPECT_TRUE(floor.reached(1.2e-9, 100.0, 0.0));
  floor.begin_step(0.0);
  EXPECT_FALSE(floor.reached(1e-9, 100.0, 0.0));
  EXPECT_TRUE(floor.reached(1.5e-9, 100.0, 0.0));
  ResidualFloor large(1, 1e-11);
  large.begin_step(0.0);
  for (int k = 0; k < 50; ++k) EXPECT_FALSE(large.reached(1e-7, 100.0, 0.0));
}

// A wrench that passes through zero has the scale of those before it.
TEST(ResidualFloor, KnowsTheWrenchesBefore) {
  ResidualFloor floor(1, 0.0);
  for (const double accepted_N : {100.0, 1e-3}) {
    floor.begin_step(accepted_N);
    EXPECT_FALSE(floor.reached(9e-9, 1e-3, 0.0));
    EXPECT_TRUE(floor.reached(9e-9, 1e-3, 0.0));
  }
  ResidualFloor young(1, 0.0);
  young.begin_step(1e-3);
  for (int k = 0; k < 50; ++k) EXPECT_FALSE(young.reached(9e-9, 1e-3, 0.0));
}

// A wrench may be small where the joints' forces are not: then the scenario says what is small.
TEST(ResidualFloor, MayBeAHundredTolerances) {
  ResidualFloor floor(1, 1e-11);
  floor.begin_step(0.0);
  EXPECT_FALSE(floor.reached(9e-10, 0.01, 0.0));
  EXPECT_TRUE(floor.reached(9e-10, 0.01, 0.0));
  floor.begin_step(0.0);
  EXPECT_FALSE(floor.reached(1.1e-9, 0.01, 0.0));
  EXPECT_FALSE(floor.reached(1.1e-9, 0.01, 0.0));
}

// A stiff mesh makes more of its motions' rounding than the port's stiffness tells.
TEST(ResidualFloor, MayBeAHundredRoundingsOfTheMotions) {
  ResidualFloor floor(1, 1e-11);
  floor.begin_step(0.0);
  EXPECT_FALSE(floor.reached(9e-8, 0.01, 1e-9));
  EXPECT_TRUE(floor.reached(9e-8, 0.01, 1e-9));
  floor.begin_step(0.0);
  EXPECT_FALSE(floor.reached(1.1e-7, 0.01, 1e-9));
  EXPECT_FALSE(floor.reached(1.1e-7, 0.01, 1e-9));
}

// An iteration that goes on falling, if slowly, is not at its floor.
TEST(ResidualFloor, IsNotReachedWhileResidualsFall) {
  ResidualFloor floor(8, 1e-11);
  floor.begin_step(0.0);
  double residual_N = 1.0;
  for (int k = 0; k < 200; ++k, residual_N *= 0.9)
    EXPECT_FALSE(floor.reached(residual_N, 100.0, 0.0));
}

}  // namespace
}  // namespace tandem

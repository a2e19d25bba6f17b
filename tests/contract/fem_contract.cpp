#include <gtest/gtest.h>

#include <limits>
#include <tuple>

#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

Params of_kind(IntegratorKind integrator, SolverKind solver, int order = 1) {
  Params params = bar_with_two_ports();
  params.mesh.order = order;
  params.integrator.kind = integrator;
  params.solver.kind = solver;
  params.damping = {.alpha_per_s = 1.0, .beta_s = 1e-4};
  return params;
}

class FemContract : public ::testing::TestWithParam<std::tuple<IntegratorKind, SolverKind, int>> {
 protected:
  static Params params() {
    const auto& [integrator, solver, order] = GetParam();
    return of_kind(integrator, solver, order);
  }
};

INSTANTIATE_TEST_SUITE_P(
    Kinds, FemContract,
    ::testing::Values(std::tuple{IntegratorKind::BackwardEuler, SolverKind::Cholmod, 1},
                      std::tuple{IntegratorKind::Hht, SolverKind::Cholmod, 1},
                      std::tuple{IntegratorKind::BackwardEuler, SolverKind::Pcg, 1},
                      std::tuple{IntegratorKind::Hht, SolverKind::Cholmod, 2},
                      std::tuple{IntegratorKind::BackwardEuler, SolverKind::Pcg, 2},
                      std::tuple{IntegratorKind::GeneralisedAlpha, SolverKind::Cholmod, 1},
                      std::tuple{IntegratorKind::Newmark, SolverKind::Pcg, 1},
                      std::tuple{IntegratorKind::QuasiStatic, SolverKind::Cholmod, 1},
                      std::tuple{IntegratorKind::QuasiStatic, SolverKind::Pcg, 1}));

// One body makes every macro step once, the other repeats each one three times, with other inputs
// in between and with the Jacobian: state and wrenches must have the same bits.
TEST_P(FemContract, RepeatedStepsGiveTheBitsOfASingleOne) {
  FlexibleBody once(params());
  FlexibleBody repeated(params());
  once.initialize(pair_motion(0.0));
  repeated.initialize(pair_motion(0.0));
  const SimTime H(2'000'000);  // two micro steps
  for (int k = 0; k < 4; ++k) {
    const double t = 2e-3 * k;
    const auto right = request(pair_motion(t), pair_motion(t + 2e-3), H);
    const auto wrong = request(pair_motion(t), pair_motion(t + 3e-3), H);
    once.checkpoint();
    repeated.checkpoint();
    const auto expected = once.advance(right);
    ASSERT_EQ(repeated.advance(wrong).outcome, Outcome::Done);
    repeated.rollback();
    ASSERT_EQ(repeated.advance(wrong).outcome, Outcome::Done);
    repeated.rollback();
    const auto found = repeated.advance(right);
    EXPECT_EQ(stack(found.output), stack(expected.output));
    EXPECT_EQ(repeated.observe().state_hash, once.observe().state_hash);
  }
}

TEST_P(FemContract, LinearizingChangesNoBit) {
  FlexibleBody plain(params());
  FlexibleBody linearized(params());
  plain.initialize(pair_motion(0.0));
  linearized.initialize(pair_motion(0.0));
  for (int k = 0; k < 3; ++k) {
    const double t = 1e-3 * k;
    const SimTime H(1'000'000);
    plain.advance(request(pair_motion(t), pair_motion(t + 1e-3), H));
    linearized.advance(request(pair_motion(t), pair_motion(t + 1e-3), H, /*linearize=*/true));
    EXPECT_EQ(plain.observe().state_hash, linearized.observe().state_hash);
  }
}

TEST_P(FemContract, RollbackRestoresEveryBitAndTheClock) {
  FlexibleBody body(params());
  body.initialize(pair_motion(0.0));
  body.advance(request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000)));
  body.checkpoint();
  const Observation saved = body.observe();
  for (int k = 0; k < 3; ++k) {
    body.advance(request(pair_motion(1e-3), pair_motion(3e-3), SimTime(2'000'000)));
    EXPECT_NE(body.observe().state_hash, saved.state_hash);
    body.rollback();
    EXPECT_EQ(body.observe().state_hash, saved.state_hash);
    EXPECT_EQ(body.observe().time, saved.time);
  }
}

TEST_P(FemContract, ManyStepsEndExactlyAtTheirSum) {
  FlexibleBody body(params());
  body.initialize(pair_motion(0.0));
  for (int k = 0; k < 10; ++k) {
    const double t = 3e-3 * k;
    body.advance(request(pair_motion(t), pair_motion(t + 3e-3), SimTime(3'000'000)));
  }
  EXPECT_EQ(body.observe().time, SimTime(30'000'000));
}

TEST_P(FemContract, FailedStepDoesNotMoveTheState) {
  FlexibleBody body(params());
  body.initialize(pair_motion(0.0));
  const Observation before = body.observe();
  MotionSet bad = pair_motion(1e-3);
  bad[0].v_WP.x() = std::numeric_limits<double>::quiet_NaN();
  const auto result = body.advance(request(pair_motion(0.0), bad, SimTime(1'000'000)));
  EXPECT_EQ(result.outcome, Outcome::Failed);
  EXPECT_FALSE(result.message.empty());
  EXPECT_EQ(body.observe().state_hash, before.state_hash);
  EXPECT_EQ(body.observe().time, before.time);
}

TEST(FemContractUse, RefusesAStepThatIsNoMultipleOfTheMicroStep) {
  FlexibleBody body(bar_with_two_ports());
  body.initialize(pair_motion(0.0));
  EXPECT_THROW(body.advance(request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'500'000))),
               Error);
}

TEST(FemContractUse, ReachedIterationCapIsNotConverged) {
  Params params = of_kind(IntegratorKind::BackwardEuler, SolverKind::Pcg);
  params.solver.max_iterations = 3;
  params.solver.preconditioner = PreconditionerKind::BlockJacobi;
  params.mass = MassKind::Lumped;  // so that the accelerations at t = 0 need one iteration
  FlexibleBody body(params);
  body.initialize(pair_motion(0.0));
  const auto result =
      body.advance(request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000)));
  EXPECT_EQ(result.outcome, Outcome::NotConverged);
  EXPECT_NE(result.message.find("after 3 iterations"), std::string::npos) << result.message;
  EXPECT_EQ(result.solver_iterations, 3);
}

TEST(FemContractUse, ObserverSeesAcceptedStatesOnly) {
  FlexibleBody body(bar_with_two_ports());
  std::vector<std::int64_t> times;
  body.on_accepted([&](const State& state) { times.push_back(state.time.count()); });
  body.initialize(pair_motion(0.0));
  body.checkpoint();
  for (int repeat = 0; repeat < 2; ++repeat) {
    body.rollback();
    body.advance(request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000)));
  }
  body.checkpoint();
  EXPECT_EQ(times, (std::vector<std::int64_t>{0, 1'000'000}));
}

}  // namespace
}  // namespace tandem::fem

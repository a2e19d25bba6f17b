#include <gtest/gtest.h>

#include <limits>

#include "fem_process/reduced/reduced_body.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

class FemReducedContract : public ::testing::TestWithParam<IntegratorKind> {
 protected:
  Params params() const {
    Params params = bar_with_two_ports();
    params.formulation = FormulationKind::CraigBampton;
    params.integrator.kind = GetParam();
    params.damping = {.alpha_per_s = 1.0, .beta_s = 1e-4};
    return params;
  }
};

INSTANTIATE_TEST_SUITE_P(Kinds, FemReducedContract,
                         ::testing::Values(IntegratorKind::BackwardEuler, IntegratorKind::Hht,
                                           IntegratorKind::GeneralisedAlpha,
                                           IntegratorKind::QuasiStatic));

// One body makes every macro step once, the other repeats each one three times, with other inputs
// in between and with the Jacobian: state and wrenches must have the same bits.
TEST_P(FemReducedContract, RepeatedStepsGiveTheBitsOfASingleOne) {
  ReducedBody once(params());
  ReducedBody repeated(params());
  once.initialize(pair_motion(0.0));
  repeated.initialize(pair_motion(0.0));
  const SimTime H(2'000'000);  // two micro steps
  for (int k = 0; k < 4; ++k) {
    const double t = 2e-3 * k;
    const auto right = request(pair_motion(t), pair_motion(t + 2e-3), H);
    const auto wrong = request(pair_motion(t), pair_motion(t + 3e-3), H, /*linearize=*/true);
    once.checkpoint();
    repeated.checkpoint();
    const auto expected = once.advance(right);
    for (int repeat = 0; repeat < 2; ++repeat) {
      ASSERT_EQ(repeated.advance(wrong).outcome, Outcome::Done);
      EXPECT_NE(repeated.observe().state_hash, once.observe().state_hash);
      repeated.rollback();
    }
    const auto found = repeated.advance(right);
    EXPECT_EQ(stack(found.output), stack(expected.output));
    EXPECT_EQ(repeated.observe().state_hash, once.observe().state_hash);
    EXPECT_EQ(repeated.observe().time, once.observe().time);
  }
}

TEST_P(FemReducedContract, InitializingAgainStartsAfresh) {
  ReducedBody body(params());
  const auto first = stack(body.initialize(pair_motion(0.0)));
  const auto hash = body.observe().state_hash;
  body.advance(request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000)));
  EXPECT_EQ(stack(body.initialize(pair_motion(0.0))), first);
  EXPECT_EQ(body.observe().state_hash, hash);
}

TEST_P(FemReducedContract, FailedStepDoesNotMoveTheState) {
  ReducedBody body(params());
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

}  // namespace
}  // namespace tandem::fem

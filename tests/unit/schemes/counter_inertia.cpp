// What is added to a wrench so that a junction has no mass: the rule by which it is, its
// derivative, and its way back.
#include "protocol/schemes/counter_inertia.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tandem {
namespace {

/// A flexible side that exerts nothing: what comes out is what was added.
class Nothing final : public FemSide {
 public:
  explicit Nothing(std::size_t ports) { info_.ports.resize(ports); }
  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override { return WrenchSet(motions.size()); }
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override {
    StepResult<WrenchSet> result;
    result.outcome = Outcome::Done;
    result.output.resize(info_.ports.size());
    const auto n = static_cast<Eigen::Index>(info_.ports.size());
    if (request.linearize) result.jacobian = InterfaceJacobian::Zero(6 * n, 12 * n);
    return result;
  }
  void checkpoint() override {}
  void rollback() override {}
  Observation observe() override { return {}; }

 private:
  SubsystemInfo info_;
};

constexpr StandInInertia kRule{
    .mass_kg = 2.0, .inertia_kg_m2 = 0.5, .gamma = 0.7, .alpha_m = 0.3, .alpha_f = 0.4};
constexpr std::size_t kJunction = 1;
const SimTime kCounterStep{10'000'000};
constexpr double kCounterStep_s = 0.01;

std::vector<PortInfo> two_ports_with_junction() {
  std::vector<PortInfo> ports(2);
  ports[kJunction].stand_in = kRule;
  return ports;
}

MotionSet moving(double v, double w) {
  MotionSet motions(2);
  motions[kJunction].v_WP.x() = v;
  motions[kJunction].w_WP.z() = w;
  return motions;
}

double speed(int n) { return std::sin(0.8 * n) + 0.3 * n; }

/// The force after `n` steps from speed(0) on.
struct Steps {
  Nothing nothing{2};
  CounterInertia side{nothing, two_ports_with_junction()};
  Steps() { side.initialize(moving(speed(0), 0.0)); }
  StepResult<WrenchSet> to(int n, double v, bool linearize = false) {
    return side.advance({.step = kCounterStep,
                         .input = {moving(speed(n - 1), 0.0), moving(v, -2.0 * v)},
                         .linearize = linearize});
  }
};

// Undone by the rule of the multibody side: what is added moves the inertia as it has moved.
TEST(CounterInertia, MovesTheInertiaByTheRuleOfTheMultibodySide) {
  Steps steps;
  double w = 0.0, a = 0.0;
  for (int n = 1; n <= 5; ++n) {
    steps.side.checkpoint();
    const auto result = steps.to(n, speed(n));
    const double now = result.output[kJunction].f_P_W.x();
    EXPECT_TRUE(result.output[0].f_P_W.isZero(0.0)) << "the other port";
    const double filtered = ((1.0 - kRule.alpha_f) * now + kRule.alpha_f * w) / kRule.mass_kg;
    const double after = (filtered - kRule.alpha_m * a) / (1.0 - kRule.alpha_m);
    const double v =
        speed(n - 1) + kCounterStep_s * ((1.0 - kRule.gamma) * a + kRule.gamma * after);
    EXPECT_NEAR(v, speed(n), 1e-12) << n;
    a = after;
    w = now;
  }
}

TEST(CounterInertia, HasItsDerivative) {
  Steps steps;
  for (int n = 1; n <= 3; ++n) {
    steps.side.checkpoint();
    const double at = speed(n), delta = 1e-3;
    const auto here = steps.to(n, at, true);
    steps.side.rollback();
    const auto there = steps.to(n, at + delta);
    steps.side.rollback();
    const auto row = 6 * static_cast<Eigen::Index>(kJunction);
    const double force =
        (there.output[kJunction].f_P_W.x() - here.output[kJunction].f_P_W.x()) / delta;
    EXPECT_NEAR((*here.jacobian)(row, 2 * row + 6), force, 1e-9 * std::abs(force)) << n;
    (void)steps.to(n, at);
  }
}

TEST(CounterInertia, HasTheSameBitsAfterARollback) {
  Steps steps;
  for (int n = 1; n <= 3; ++n) {
    steps.side.checkpoint();
    (void)steps.to(n, 17.0);
    steps.side.rollback();
    const auto first = steps.to(n, speed(n));
    const auto hash = steps.side.observe().state_hash;
    steps.side.rollback();
    const auto second = steps.to(n, speed(n));
    EXPECT_EQ(stack(first.output), stack(second.output)) << n;
    EXPECT_EQ(steps.side.observe().state_hash, hash) << n;
  }
}

TEST(CounterInertia, IsNeededWhereAPortHasNoInertiaOfItsOwn) {
  EXPECT_TRUE(CounterInertia::needed(two_ports_with_junction()));
  EXPECT_FALSE(CounterInertia::needed(std::vector<PortInfo>(3)));
}

}  // namespace
}  // namespace tandem

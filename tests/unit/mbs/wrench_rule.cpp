#include "mbs_process/wrench_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace tandem::mbs::testing {
namespace {

WrenchRule rule_with(double rho) {
  Params params;
  params.integrator = IntegratorKind::GeneralisedAlpha;
  params.rho_infinity = rho;
  return wrench_rule(params);
}

WrenchSet force(double f_N) {
  WrenchSet wrenches(1);
  wrenches[0].f_P_W.x() = f_N;
  return wrenches;
}

double value(const WrenchSet& wrenches) { return wrenches[0].f_P_W.x(); }

/// A mass on a spring k whose force λ = −k x acts by a rule, h = 1 s.
struct Oscillator {
  WrenchRule rule;
  double mass = 1.0, k = 1.0;
  double x = 0.0, v = 0.0;
  WrenchSet lambda = force(0.0), filtered = force(0.0);

  struct End {
    double x, v;
    WrenchSet filtered;
  };
  [[nodiscard]] End with(double f_N) const {
    const WrenchSet after = rule.filtered(filtered, lambda, force(f_N));
    const double u = v + 0.5 * value(rule.first_half(filtered, after)) / mass;
    return {x + u, u + 0.5 * value(rule.second_half(filtered, after)) / mass, after};
  }
  void step() {
    // x⁺ is affine in λ⁺ = −k x⁺.
    const double at_zero = with(0.0).x;
    const double slope = with(1.0).x - at_zero;
    const double f_N = -k * at_zero / (1.0 + k * slope);
    const End end = with(f_N);
    x = end.x, v = end.v, filtered = end.filtered, lambda = force(f_N);
  }
};

/// Oscillator at rest in its force but for a velocity error, after n steps: |v|.
double speed_after(const WrenchRule& rule, double k, int n) {
  Oscillator oscillator{.rule = rule, .k = k, .v = 1.0};
  for (int i = 0; i < n; ++i) oscillator.step();
  return std::abs(oscillator.v);
}

// The limit of a light body on a stiff spring, Ω = 1e4: the double root −ρ∞ bounds the velocity by
// (1 + c n) ρ∞ⁿ; c = 4 (1 − ρ∞)… is some units. The trapezoidal rule, root −1, keeps it.
TEST(WrenchRule, LosesOneMinusRhoOfInfinitelyFastMotionPerStep) {
  for (const double rho : {0.0, 0.5, 0.8, 0.9}) {
    const double early = speed_after(rule_with(rho), 1e8, 40);
    const double late = speed_after(rule_with(rho), 1e8, 80);
    EXPECT_LT(late, 3.0 * std::pow(rho, 40) * early + 1e-12) << rho;
  }
  EXPECT_NEAR(speed_after(rule_with(1.0), 1e8, 80), 1.0, 1e-2);
  EXPECT_NEAR(speed_after({}, 1e8, 80), 1.0, 1e-2);
}

// Chung and Hulbert's weights for ρ∞ = 1 are those of the trapezoidal rule where λ̄ begins as λ.
TEST(WrenchRule, IsTheTrapezoidalRuleForRhoOne) {
  Oscillator damped{.rule = rule_with(1.0), .k = 0.3, .x = 1.0};
  Oscillator plain{.rule = {}, .k = 0.3, .x = 1.0};
  for (Oscillator* oscillator : {&damped, &plain}) {
    oscillator->lambda = oscillator->filtered = force(-0.3);
  }
  for (int i = 0; i < 100; ++i) damped.step(), plain.step();
  EXPECT_NEAR(damped.x, plain.x, 1e-12);
  EXPECT_NEAR(damped.v, plain.v, 1e-12);
}

// A constant wrench is passed on as it is: a = λ/m, so x = ½ a t² without error.
TEST(WrenchRule, PassesAConstantWrenchOn) {
  const WrenchRule rule = rule_with(0.6);
  Oscillator free{.rule = rule, .mass = 2.0, .k = 0.0};
  free.lambda = free.filtered = force(3.0);
  double x = 0.0, v = 0.0;
  for (int i = 0; i < 10; ++i) {
    const auto end = free.with(3.0);
    free.x = end.x, free.v = end.v, free.filtered = end.filtered;
    x = free.x, v = free.v;
  }
  EXPECT_NEAR(x, 0.5 * 1.5 * 100.0, 1e-11);
  EXPECT_NEAR(v, 1.5 * 10.0, 1e-12);
}

}  // namespace
}  // namespace tandem::mbs::testing

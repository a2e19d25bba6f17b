#include "protocol/schemes/prediction.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tandem {
namespace {

/// v(t), w(t) and f(t) are polynomials of degree `degree`; positions their exact integrals.
double value(int degree, double t) {
  return degree == 0 ? 3.0 : degree == 1 ? 3.0 - 2.0 * t : 3.0 - 2.0 * t + 5.0 * t * t;
}
double integral(int degree, double t) {
  return degree == 0   ? 3.0 * t
         : degree == 1 ? 3.0 * t - t * t
                       : 3.0 * t - t * t + 5.0 / 3.0 * t * t * t;
}

InterfaceSample sample(int degree, SimTime time) {
  const double t = to_seconds(time);
  InterfaceSample s{.time = time, .motions = MotionSet(1), .wrenches = WrenchSet(1)};
  s.motions[0].v_WP.y() = value(degree, t);
  s.motions[0].p_WP.y() = integral(degree, t);
  s.motions[0].w_WP.z() = value(degree, t);
  const double angle = integral(degree, t);
  s.motions[0].q_WP = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
  s.wrenches[0].f_P_W.x() = value(degree, t);
  s.wrenches[0].t_P_W.z() = -value(degree, t);
  return s;
}

/// Steps of 30, 20 and then 50 ms: an adaptive run does not keep its step.
InterfaceState state_of(int degree) {
  const auto at = [degree](int ms) { return sample(degree, SimTime(ms * 1'000'000)); };
  const InterfaceSample now = at(70);
  return {.time = now.time,
          .motions = now.motions,
          .wrenches = now.wrenches,
          .history = {at(50), at(20)}};
}
constexpr SimTime kStep{50'000'000};

class PredictionDegree : public testing::TestWithParam<int> {};

// The values are of size 3 and the weights below 10: 64 ε · 30.
TEST_P(PredictionDegree, ReproducesPolynomialsOfItsDegreeOverUnevenSteps) {
  const int degree = GetParam();
  const InterfaceState state = state_of(degree);
  const InterfaceSample exact = sample(degree, state.time + kStep);
  const auto prediction = static_cast<Prediction>(degree);
  const WrenchSet wrenches = predict_wrenches(prediction, state, kStep);
  EXPECT_LT((stack(wrenches) - stack(exact.wrenches)).norm(), 4e-13);
  const MotionSet motions = predict_motions(prediction, state, kStep);
  EXPECT_LT(difference(exact.motions, motions).norm(), 4e-13);
}

// One degree too low must show, else the test above would not tell degrees apart.
TEST_P(PredictionDegree, MissesAPolynomialOfTheNextDegree) {
  const int degree = GetParam();
  if (degree == 2) return;
  const InterfaceState state = state_of(degree + 1);
  const InterfaceSample exact = sample(degree + 1, state.time + kStep);
  const auto prediction = static_cast<Prediction>(degree);
  EXPECT_GT(difference(exact.motions, predict_motions(prediction, state, kStep)).norm(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(All, PredictionDegree, testing::Values(0, 1, 2));

TEST(Prediction, LowersItsDegreeWhileThePastIsShort) {
  InterfaceState state = state_of(2);
  state.history.pop_back();
  const auto quadratic = stack(predict_wrenches(Prediction::Quadratic, state, kStep));
  EXPECT_EQ(quadratic, stack(predict_wrenches(Prediction::Linear, state, kStep)));
  state.history.clear();
  EXPECT_EQ(stack(predict_wrenches(Prediction::Quadratic, state, kStep)), stack(state.wrenches));
}

TEST(Displaced, IsTheInverseOfDifference) {
  MotionSet a(2);
  a[0].q_WP = Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5);
  a[1].p_WP = {1.0, 2.0, 3.0};
  // Rotations from 1e-9 rad, where the series is used, to 3 rad, near half a turn.
  for (double angle : {1e-9, 1e-4, 0.3, 3.0}) {
    Eigen::VectorXd xi = Eigen::VectorXd::LinSpaced(24, -1.0, 1.0);
    xi.segment<3>(3) = angle * Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
    xi.segment<3>(15) = angle * Eigen::Vector3d::UnitX();
    // 64 ε over the sine of the half angle's complement, at least 0.07 here.
    EXPECT_LT((difference(a, displaced(a, xi)) - xi).norm(), 1e-12) << angle;
  }
}

TEST(MotionNorm, IsWorkConjugateToTheWrenchNorm) {
  // Power λ·ξ̇ ≤ ‖λ‖ ‖ξ̇‖ (Cauchy–Schwarz), with equality when torque/L and L·rate are parallel.
  const std::vector<PortInfo> ports{{"p", 0.2}};
  MotionSet motion(1);
  motion[0].v_WP = {3.0, 0.0, 0.0};
  motion[0].w_WP = {0.0, 4.0 / 0.2, 0.0};
  WrenchSet wrench(1);
  wrench[0].f_P_W = {3.0, 0.0, 0.0};
  wrench[0].t_P_W = {0.0, 4.0 * 0.2, 0.0};
  Eigen::VectorXd xi = difference(MotionSet(1), motion);
  EXPECT_NEAR(motion_norm_m_per_s(xi, ports, 1e-3), 5.0, 1e-14);
  EXPECT_NEAR(interface_power_W(wrench, motion),
              wrench_norm_N(wrench, ports) * motion_norm_m_per_s(xi, ports, 1e-3), 1e-12);
}

}  // namespace
}  // namespace tandem

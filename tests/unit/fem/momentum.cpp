#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

// Sum of the reaction equations over all nodes: internal forces cancel in every element, so the
// wrenches' impulse is the momentum's change. The free nodes' equations hold to the solver's
// residual: CHOLMOD leaves about 1e-15 of the stiffness forces (E A = 12.5 kN · strain), well below
// 1e-11 of the momentum of 1.2 kg · 1 m/s.
class FemMomentum : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, FemMomentum, ::testing::Values(1, 2));

TEST_P(FemMomentum, WrenchImpulseIsMomentumChangeToRoundOff) {
  Params params = bar_with_two_ports();
  params.mesh.order = GetParam();
  params.gravity_m_per_s2 = {0.5, -1.0, -9.81};
  params.damping.beta_s = 1e-3;
  params.loads = {{.kind = Load::Kind::Nodal,
                   .set = {"solid"},
                   .value = {3.0, 1.0, -2.0},
                   .law = Law(HarmonicLaw{.amplitude = 1.0, .frequency_Hz = 20.0})}};
  FlexibleBody body(params);
  body.initialize(pair_motion(0.0));
  const double h = 1e-3;
  double mass = 0.0;
  for (double m : body.model().nodal_mass) mass += m;
  for (int k = 1; k <= 100; ++k) {
    const Eigen::Vector3d before = linear_momentum(body);
    const auto result =
        body.advance(request(pair_motion((k - 1) * h), pair_motion(k * h), SimTime(1'000'000)));
    ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
    const Eigen::Vector3d load =
        std::sin(2 * M_PI * 20.0 * k * h) * Eigen::Vector3d(3.0, 1.0, -2.0);
    const Eigen::Vector3d expected =
        -(linear_momentum(body) - before) + h * (mass * params.gravity_m_per_s2 + load);
    const Eigen::Vector3d impulse = h * (result.output[0].f_P_W + result.output[1].f_P_W);
    EXPECT_LT((impulse - expected).norm(), 1e-11) << "step " << k;
  }
}

/// Σ_j m_j u_j over some nodes, m_j the row sums of M (kg).
Eigen::Vector3d weighted(const Model& model, const std::vector<int>& nodes,
                         const Eigen::VectorXd& u) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int node : nodes) {
    sum += model.nodal_mass[static_cast<std::size_t>(node)] * u.segment<3>(3 * node);
  }
  return sum;
}

/// What the impulses of generalised-α lack of the change of momentum beyond
///   E = h Σ_free m ((1 − γ − α_m) (a_N − a_0) + α_f (q_N − q_0)) + h Σ_prescribed m ½ (ā_N − ā_0),
/// after every step (N s):  h Σ f_P_W = h Σ f_ext − ΔP − E − this.
template <class MotionAt>
std::vector<double> defects_beyond(const MotionAt& motion_at, SimTime step, int steps) {
  const double rho = 0.7;
  Params params = bar_with_two_ports();
  params.micro_step = step;
  params.gravity_m_per_s2 = {0.5, -1.0, -9.81};
  params.damping.beta_s = 1e-3;
  params.integrator = {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = rho};
  FlexibleBody body(params);
  body.initialize(motion_at(0.0));
  const Model& model = body.model();
  const State first = body.state();
  const double h = to_seconds(step);
  double mass = 0.0;
  for (double m : model.nodal_mass) mass += m;
  const double alpha_m = (2 * rho - 1) / (rho + 1);
  const double alpha_f = rho / (rho + 1);
  const double gamma = 0.5 - alpha_m + alpha_f;
  const Eigen::Vector3d begin = linear_momentum(body);
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  std::vector<double> defects;
  for (int k = 1; k <= steps; ++k) {
    const auto result = body.advance(request(motion_at((k - 1) * h), motion_at(k * h), step));
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    if (result.outcome != Outcome::Done) return defects;
    impulse += h * (result.output[0].f_P_W + result.output[1].f_P_W);
    const State& last = body.state();
    const Eigen::Vector3d ends =
        h * weighted(model, model.free,
                     (1 - gamma - alpha_m) * (last.a - first.a) +
                         alpha_f * (last.acceleration - first.acceleration)) +
        h * weighted(model, model.prescribed, 0.5 * (last.a_mean - first.a_mean));
    const Eigen::Vector3d expected =
        k * h * mass * params.gravity_m_per_s2 - (linear_momentum(body) - begin) - ends;
    defects.push_back((impulse - expected).norm());
  }
  return defects;
}

MotionSet without_turning(double t) {
  MotionSet motions = pair_motion(t);
  for (Motion& motion : motions) {
    motion.q_WP.setIdentity();
    motion.w_WP.setZero();
  }
  return motions;
}

// Generalised-α: the sums of a, q and ā over the steps differ from each other by their values at
// the first and the last time alone: the defect E does not grow with the number of steps. Round-off
// as above.
TEST(FemMomentum, ImpulseDefectOfGeneralisedAlphaIsThatOfTheFirstAndLastTime) {
  for (double defect : defects_beyond(without_turning, SimTime(1'000'000), 100)) {
    EXPECT_LT(defect, 1e-11);
  }
}

// Turning, impulses are sums of end forces, which the trapezoidal rule takes for the integral of a
// turning force: what that lacks, of second order in the step, turns with the body and does not
// pile up. Over the same time with half the step it is a quarter (two-sided; the third order is
// below a fifth of that here), and no larger in the second half of the run than in the first.
TEST(FemMomentum, TurningAddsAnImpulseDefectOfSecondOrderThatDoesNotGrow) {
  const auto most = [](const std::vector<double>& defects, std::size_t from, std::size_t to) {
    return *std::max_element(defects.begin() + static_cast<std::ptrdiff_t>(from),
                             defects.begin() + static_cast<std::ptrdiff_t>(to));
  };
  const std::vector<double> coarse = defects_beyond(pair_motion, SimTime(1'000'000), 200);
  const std::vector<double> fine = defects_beyond(pair_motion, SimTime(500'000), 400);
  ASSERT_EQ(coarse.size(), 200u);
  ASSERT_EQ(fine.size(), 400u);
  EXPECT_LT(most(coarse, 100, 200), 1.05 * most(coarse, 0, 100));
  const double ratio = coarse.back() / fine.back();
  EXPECT_GT(ratio, 3.3);
  EXPECT_LT(ratio, 4.8);
}

}  // namespace
}  // namespace tandem::fem

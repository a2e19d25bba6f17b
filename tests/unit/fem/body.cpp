#include <gtest/gtest.h>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

double total_mass(const FlexibleBody& body) {
  double mass = 0.0;
  for (double m : body.model().nodal_mass) mass += m;
  return mass;
}

// A body that falls with its ports: x = ½ g t² is what backward Euler integrates exactly in v
// (v_n = n h g); no strain, no reaction. 1e-8 N is some ε times the stiffness forces of a step.
TEST(FemBody, FreeFallNeedsNoWrench) {
  Params params = bar_with_two_ports();
  params.gravity_m_per_s2 = {0, 0, -9.81};
  FlexibleBody body(params);
  const double h = 1e-3;
  const auto falling = [&](int k) {
    MotionSet motions(2);
    for (std::size_t p = 0; p < 2; ++p) {
      motions[p].v_WP.z() = -9.81 * k * h;
      motions[p].p_WP = {p == 0 ? -0.28 : 0.28, 0, -9.81 * h * h * 0.5 * k * (k + 1)};
    }
    return motions;
  };
  body.initialize(falling(0));
  for (int k = 1; k <= 100; ++k) {
    const auto result = body.advance(request(falling(k - 1), falling(k), SimTime(1'000'000)));
    ASSERT_EQ(result.outcome, Outcome::Done);
    EXPECT_LT(stack(result.output).cwiseAbs().maxCoeff(), 1e-8);
  }
  EXPECT_LT(body.observe().energy.elastic_J, 1e-18);
}

// Ports at rest carry the weight, from the first instant on once the body has come to rest; at
// t = 0 the port nodes carry their own share only, the rest is accelerating.
TEST(FemBody, PortsAtRestCarryTheWeightInTheEnd) {
  Params params = bar_with_two_ports();
  params.gravity_m_per_s2 = {0, 0, -9.81};
  params.damping = {.alpha_per_s = 30.0, .beta_s = 1e-3};
  params.micro_step = SimTime(10'000'000);
  FlexibleBody body(params);
  MotionSet rest(2);
  rest[0].p_WP.x() = -0.28;
  rest[1].p_WP.x() = 0.28;
  body.initialize(rest);
  WrenchSet wrenches;
  for (int k = 0; k < 400; ++k) {
    wrenches = body.advance(request(rest, rest, SimTime(10'000'000))).output;
  }
  const Eigen::Vector3d sum = wrenches[0].f_P_W + wrenches[1].f_P_W;
  EXPECT_NEAR(sum.z(), -9.81 * total_mass(body), 1e-9);
  EXPECT_LT(body.observe().energy.kinetic_J, 1e-20);
}

// A ring of ports is not needed: one port turns the bar about the origin with all nodes following.
// Stiff bar in steady rotation about z: λ = m ω² r_c on the rigid side (outwards). Backward Euler
// takes the port's displacement as h v⁺, so that the centripetal acceleration is off by O(h):
// halving h halves the error.
TEST(FemBody, SteadyRotationLoadsThePortWithTheCentrifugalForce) {
  const double w = 2.0;
  double last = 0.0;
  for (int level = 0; level < 3; ++level) {
    Params params = bar_with_two_ports();
    params.ports.resize(1);
    params.material.young_Pa = 1e10;  // strain m ω² r/(E A) ~ 1e-7
    params.mesh.position_m = {0.5, 0, 0};
    params.ports[0].p_WP = Eigen::Vector3d::Zero();
    params.damping.beta_s = 1e-3;
    params.initial_velocity.angular_rad_per_s = {0, 0, w};
    const SimTime h(2'000'000 >> level);
    params.micro_step = h;
    FlexibleBody body(params);
    const auto turning = [&](double t) {
      Motion m;
      m.q_WP = rotation({0, 0, w * t});
      m.w_WP = {0, 0, w};
      return MotionSet{m};
    };
    body.initialize(turning(0.0));
    double t = 0.0;
    Wrench wrench;
    for (int k = 0; k < 200 << level; ++k) {
      const double next = t + to_seconds(h);
      wrench = body.advance(request(turning(t), turning(next), h)).output[0];
      t = next;
    }
    const Eigen::Vector3d outwards = rotation({0, 0, w * t}) * Eigen::Vector3d::UnitX();
    const double expected = total_mass(body) * w * w * 0.5;
    const double error = (wrench.f_P_W - expected * outwards).norm() / expected;
    EXPECT_LT(error, 2.0 * w * to_seconds(h));
    if (level > 0) {
      EXPECT_NEAR(error / last, 0.5, 0.1);
    }
    last = error;
  }
}

// PCG stops at 1e-12 of the right-hand side; 20 steps of a well-conditioned bar keep nine digits.
TEST(FemBody, CholmodAndPcgGiveTheSameMotion) {
  Params direct = bar_with_two_ports();
  Params iterative = direct;
  iterative.solver = {.kind = SolverKind::Pcg, .tolerance = 1e-12};
  FlexibleBody a(direct);
  FlexibleBody b(iterative);
  a.initialize(pair_motion(0.0));
  b.initialize(pair_motion(0.0));
  for (int k = 0; k < 20; ++k) {
    const auto step =
        request(pair_motion(1e-3 * k), pair_motion(1e-3 * (k + 1)), SimTime(1'000'000));
    const Eigen::VectorXd fa = stack(a.advance(step).output);
    const auto result = b.advance(step);
    EXPECT_GT(result.solver_iterations, 0);
    EXPECT_LT((stack(result.output) - fa).norm(), 1e-8 * fa.norm());
  }
  EXPECT_LT((a.state().x - b.state().x).cwiseAbs().maxCoeff(), 1e-10);
}

// Energy of a free vibration with HHT's α = 0 (trapezoidal rule) is kept up to the O(h²) of its
// nonlinearity; with loads the work booked is what the energy gains.
TEST(FemBody, TrapezoidalRuleBooksTheLoadsWorkAsEnergy) {
  Params params;
  params.mesh.file = temporary_file("energy.inp", box_inp(3));
  params.material = {.young_Pa = 300.0, .poisson = 0.3, .density_kg_per_m3 = 100.0};
  params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = 0.0};
  params.fixed = {{"LEFT"}};
  params.gravity_m_per_s2 = {0, 0, -0.1};
  params.loads = {{.kind = Load::Kind::Nodal, .set = {"RIGHT"}, .value = {2, 3, 0}}};
  params.micro_step = SimTime(2'000'000);
  FlexibleBody body(params);
  body.initialize({});
  const double start = body.observe().energy.total_J();
  double largest = 0.0;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_EQ(body.advance(request({}, {}, params.micro_step)).outcome, Outcome::Done);
    const EnergyBook energy = body.observe().energy;
    largest = std::max(largest, energy.elastic_J);
    EXPECT_NEAR(energy.total_J() - start, energy.external_work_J, 1e-4 * largest + 1e-7);
  }
  EXPECT_GT(largest, 0.01);
}

TEST(FemBody, FixedNodesStay) {
  Params params = bar_with_two_ports();
  params.ports.pop_back();
  params.fixed = {{"right"}};
  FlexibleBody body(params);
  const Eigen::VectorXd X = body.model().reference();
  body.initialize({pair_motion(0.0)[0]});
  body.advance(request({pair_motion(0.0)[0]}, {pair_motion(1e-3)[0]}, SimTime(1'000'000)));
  for (int node : body.model().fixed) {
    EXPECT_EQ(body.state().x.segment<3>(3 * node), X.segment<3>(3 * node));
  }
}

TEST(FemBody, PortNodesFollowTheirFrameExactly) {
  FlexibleBody body(bar_with_two_ports());
  body.initialize(pair_motion(0.0));
  body.advance(request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000)));
  const Motion end = pair_motion(1e-3)[1];
  for (int node : body.model().ports[1].nodes) {
    const Eigen::Vector3d r =
        body.model().mesh.X[static_cast<std::size_t>(node)] - Eigen::Vector3d(0.28, 0, 0);
    const Eigen::Vector3d arm = end.q_WP.toRotationMatrix() * r;
    EXPECT_LT((body.state().x.segment<3>(3 * node) - end.p_WP - arm).norm(), 1e-16);
    EXPECT_LT((body.state().v.segment<3>(3 * node) - end.v_WP - end.w_WP.cross(arm)).norm(), 1e-15);
  }
}

// Corners of a 0.05 m square face at x = 0.25 seen from Po at x = 0.28: 13 nodes between the centre
// (0.03 m away) and the corners (0.0464 m away).
TEST(FemBody, PortLengthIsTheDistanceOfItsNodes) {
  const FlexibleBody body(bar_with_two_ports());
  ASSERT_EQ(body.info().ports.size(), 2U);
  EXPECT_GT(body.info().ports[1].length_m, 0.03);
  EXPECT_LT(body.info().ports[1].length_m, 0.0464);
  EXPECT_TRUE(body.info().can_linearize);
}

TEST(FemBody, InitialVelocityFieldIsAffine) {
  Params params = bar_with_two_ports();
  params.initial_velocity = {.linear_m_per_s = {1, 2, 3},
                             .angular_rad_per_s = {0, 0, 3},
                             .about_m = {0.1, 0, 0},
                             .gradient_per_s = Eigen::Vector3d(2, 0, 0).asDiagonal()};
  const Model model(params);
  const Eigen::VectorXd v = model.initial_velocities();
  for (int i = 0; i < model.mesh.nodes(); ++i) {
    const Eigen::Vector3d X = model.mesh.X[static_cast<std::size_t>(i)];
    const Eigen::Vector3d expected(1 - 3 * X.y() + 2 * (X.x() - 0.1), 2 + 3 * (X.x() - 0.1), 3);
    EXPECT_LT((v.segment<3>(3 * i) - expected).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace tandem::fem

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();

Params params_of(IntegratorKind kind) {
  Params params = params_with_step(kMillisecond);
  params.integrator = kind;
  return params;
}

class MbsEnergy : public ::testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(Integrators, MbsEnergy,
                         ::testing::Values(IntegratorKind::Euler, IntegratorKind::Verlet,
                                           IntegratorKind::GeneralisedAlpha),
                         [](const auto& tested) {
                           switch (tested.param) {
                             case IntegratorKind::Euler:
                               return "Euler";
                             case IntegratorKind::Verlet:
                               return "Verlet";
                             default:
                               return "GeneralisedAlpha";
                           }
                         });

/// Largest |balance error| over n steps, each from the beginning of the run.
double largest_imbalance_J(RigidWorld& world, int n, const WrenchSet& wrenches = {}) {
  const EnergyBook begin = world.observe().energy;
  double largest = 0.0;
  for (int i = 0; i < n; ++i) {
    run(world, world.params().macro_step, 1, wrenches);
    largest = std::max(largest, std::abs(balance_error_J(begin, world.observe().energy)));
  }
  return largest;
}

// An arm on a driven hinge, a load on a ball joint, a spring-damper, a joint spring, a force law, a
// slider that meets its stop, gravity, a port off the centre with force and torque: everything that
// does work. The balance holds in every step whatever the integrator does, to round-off of energies
// of some 10 J over 2000 roundings; joints are solved to their condition number.
TEST_P(MbsEnergy, BooksOfAMechanismBalanceToRoundOff) {
  Params params = params_of(GetParam());
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  params.bodies = {body_at("arm", 1.0, {0.3, 0.0, 0.0}, {0.01, 0.05, 0.05}),
                   body_at("load", 2.0, {0.6, 0.0, -0.2}, {0.02, 0.03, 0.05}),
                   body_at("cart", 1.5, {0.0, 2.0, 0.0})};
  JointParams hinge =
      joint_between("shoulder", JointKind::Hinge, "arm", kWorld, Eigen::Vector3d::Zero(), kY);
  hinge.motor = MotorParams{.kind = MotorParams::Kind::Speed, .law = Law(HarmonicLaw{0, 3, 1, 0})};
  JointParams rail =
      joint_between("rail", JointKind::Slider, "cart", kWorld, Eigen::Vector3d::Zero(), kY);
  rail.limits = {{.axis = 1, .lower = -0.05, .upper = 0.05}};
  params.joints = {hinge, joint_between("wrist", JointKind::Ball, "load", "arm", {0.6, 0.0, 0.0}),
                   rail};
  params.springs = {{.name = "spring",
                     .body1 = "load",
                     .p1_W = {0.6, 0.0, -0.3},
                     .p2_W = {1.0, 0.5, 0.0},
                     .stiffness_N_per_m = 50.0,
                     .damping_N_s_per_m = 1.0}};
  params.joint_springs = {
      {.name = "buffer", .joint = "rail", .stiffness = 20.0, .damping = 0.5, .rest = 0.02}};
  params.forces = {{.name = "wind",
                    .body = "load",
                    .p_BF = {0.0, 0.1, 0.0},
                    .direction_W = {0.0, 1.0, 1.0},
                    .law = Law(HarmonicLaw{1.0, 2.0, 2.0, 0.0})}};
  params.ports = {port_at("p", "load", {0.7, 0.1, -0.2}), port_on("q", "cart")};
  RigidWorld world(params);
  WrenchSet wrenches(2);
  wrenches[0] = {.f_P_W = {1.0, -2.0, 3.0}, .t_P_W = {0.1, 0.2, -0.3}};
  wrenches[1].f_P_W.y() = 5.0;
  const EnergyBook begin = world.observe().energy;
  EXPECT_LT(largest_imbalance_J(world, 1000, wrenches), 2000 * kEpsilon * 100.0);
  const EnergyBook end = world.observe().energy;
  EXPECT_GT(end.damping_loss_J, 0.1);  // else the balance would say nothing
  EXPECT_GT(std::abs(end.external_work_J), 0.1);
  EXPECT_GT(std::abs(end.interface_work_J), 0.1);
  EXPECT_GT(std::abs(end.numerical_loss_J), 1e-4);
  EXPECT_GT(std::abs(end.total_J() - begin.total_J()), 0.1);
}

// No torque: energy is lost by the integrator alone, and how much it says exactly.
TEST_P(MbsEnergy, FreeAsymmetricTopLosesWhatTheIntegratorSays) {
  Params params = params_of(GetParam());
  params.bodies = {body_at("top", 1.0, Eigen::Vector3d::Zero(), {0.1, 0.2, 0.25})};
  params.bodies[0].w_WB = {1.0, 0.2, 8.0};
  RigidWorld world(params);
  const EnergyBook begin = world.observe().energy;
  EXPECT_LT(largest_imbalance_J(world, 1000), 1000 * kEpsilon * begin.total_J());
  const EnergyBook end = world.observe().energy;
  EXPECT_EQ(end.external_work_J, 0.0);
  EXPECT_EQ(end.damping_loss_J, 0.0);
  EXPECT_GT(std::abs(end.total_J() - begin.total_J()), 1e-9 * begin.total_J());
}

// Semi-implicit Euler under a constant force: v_n = n g h, z_n = −½ g h² n (n + 1), so a falling
// body loses ½ m g² h² in every step; by Verlet's steps it loses nothing.
TEST_P(MbsEnergy, FallingBodyLosesWhatTheClosedFormSays) {
  Params params = params_of(GetParam());
  params.gravity_m_per_s2 = {0.0, 0.0, -10.0};
  params.bodies = {body_at("stone", 2.0, Eigen::Vector3d::Zero())};
  RigidWorld world(params);
  const int n = 100;
  EXPECT_LT(largest_imbalance_J(world, n), n * kEpsilon);
  const double loss = GetParam() == IntegratorKind::Euler ? n * 0.5 * 2.0 * 100.0 * 1e-6 : 0.0;
  EXPECT_NEAR(world.observe().energy.numerical_loss_J, loss, n * kEpsilon);
}

// A pendulum without friction: its joint does no work and nothing damps it. What the integrator
// takes is given back within a swing: of first order by Euler's steps, of second by Verlet's.
TEST_P(MbsEnergy, UndampedPendulumHasNumericalLossAlone) {
  const auto largest_loss = [&](SimTime h) {
    Params params = params_of(GetParam());
    params.macro_step = h;
    params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
    params.bodies = {body_at("bob", 1.0, {0.5, 0.0, 0.0}, {0.01, 0.02, 0.02})};
    params.joints = {
        joint_between("pivot", JointKind::Hinge, "bob", kWorld, Eigen::Vector3d::Zero(), kY)};
    RigidWorld world(params);
    const int n = static_cast<int>(std::lround(2.0 / to_seconds(h)));
    EXPECT_LT(largest_imbalance_J(world, n), n * kEpsilon * 10.0);
    world = RigidWorld(params);
    double largest = 0.0;
    for (int i = 0; i < n; ++i) {
      run(world, h, 1);
      largest = std::max(largest, std::abs(world.observe().energy.numerical_loss_J));
    }
    EXPECT_EQ(world.observe().energy.external_work_J, 0.0);
    EXPECT_EQ(world.observe().energy.damping_loss_J, 0.0);
    return largest;
  };
  const double ratio = largest_loss(kMillisecond / 2) / largest_loss(kMillisecond / 4);
  EXPECT_NEAR(ratio, GetParam() == IntegratorKind::Euler ? 2.0 : 4.0, 0.3);
}

// A port wrench's work is f·Δp + t·θ of the port's own motion, however many micro steps it takes.
TEST_P(MbsEnergy, InterfaceWorkIsThatOfThePortsMotion) {
  Params params = params_of(GetParam());
  params.micro_step = kMillisecond / 4;
  params.bodies = {body_at("body", 2.0, Eigen::Vector3d::Zero())};
  params.bodies[0].v_WB = {0.5, 0.0, 0.0};
  params.ports = {port_on("p", "body")};
  RigidWorld world(params);
  // Along the way: a force that acts on through where the port stood at the macro step's beginning
  // has no moment then.
  WrenchSet push(1);
  push[0].f_P_W = {3.0, 0.0, 0.0};
  run(world, kMillisecond, 100, push);
  const EnergyBook energy = world.observe().energy;
  EXPECT_NEAR(energy.interface_work_J, push[0].f_P_W.dot(world.state().bodies[0].p_WB),
              400 * kEpsilon);
}

// The books belong to the state: they come back with it, bit for bit.
TEST_P(MbsEnergy, RollbackRestoresTheBooks) {
  Params params = params_of(GetParam());
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  params.bodies = {body_at("body", 2.0, Eigen::Vector3d::Zero(), {0.1, 0.2, 0.3})};
  params.ports = {port_at("p", "body", {0.1, 0.2, 0.3})};
  RigidWorld world(params);
  WrenchSet push(1);
  push[0].f_P_W = {3.0, 0.0, 1.0};
  run(world, kMillisecond, 5, push);
  world.checkpoint();
  const EnergyBook saved = world.observe().energy;
  run(world, kMillisecond, 1, push);
  const EnergyBook first = world.observe().energy;
  EXPECT_NE(first, saved);
  world.rollback();
  EXPECT_EQ(world.observe().energy, saved);
  run(world, kMillisecond, 1, push);
  EXPECT_EQ(world.observe().energy, first);
}

}  // namespace
}  // namespace tandem::mbs::testing

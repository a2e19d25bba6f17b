// The interface Jacobian of the multibody side: against central differences, closed forms, and the
// number of freedoms that each joint leaves.
#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();

/// Two jointed spinning bodies with springs, and a port off the centre on each.
Params linkage() {
  Params params = params_with_step(kMillisecond);
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  BodyParams a = body_at("a", 2.0, {0.3, 0.1, -0.2}, {0.10, 0.12, 0.15});
  a.w_WB = {1.0, -2.0, 3.0};
  BodyParams b = body_at("b", 1.0, {0.7, 0.0, 0.1}, {0.05, 0.06, 0.07});
  b.q_WB = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
  b.v_WB = {0.5, 0.0, 1.0};
  b.w_WB = {4.0, 1.0, 0.0};
  params.bodies = {a, b};
  params.joints = {joint_between("root", JointKind::Ball, "a", kWorld, Eigen::Vector3d::Zero()),
                   joint_between("elbow", JointKind::Universal, "b", "a", {0.5, 0.0, 0.0}, kZ, kX)};
  params.springs = {{.name = "spring",
                     .body1 = "a",
                     .body2 = "b",
                     .p1_W = {0.1, 0.2, 0.0},
                     .p2_W = {0.9, 0.1, 0.0},
                     .stiffness_N_per_m = 300.0,
                     .damping_N_s_per_m = 2.0,
                     .rest_length_m = 0.5}};
  params.ports = {port_at("pa", "a", {0.4, 0.3, 0.0}), port_at("pb", "b", {0.9, -0.1, 0.2})};
  return params;
}

WrenchSet some_wrenches() {
  return unstack_wrenches(
      (Eigen::VectorXd(12) << 5.0, -3.0, 2.0, 0.4, 0.1, -0.2, -4.0, 1.0, 6.0, 0.0, 0.3, 0.2)
          .finished());
}

MotionSet end_of(RigidWorld& world, SimTime step, const WrenchSet& begin, const WrenchSet& end) {
  world.rollback();
  return world.advance(step_of(step, begin, end)).output;
}

InterfaceJacobian jacobian_of(RigidWorld& world, SimTime step, const WrenchSet& begin,
                              const WrenchSet& end) {
  world.rollback();
  auto request = step_of(step, begin, end);
  request.linearize = true;
  const auto result = world.advance(request);
  EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
  return result.jacobian.value();
}

/// Central differences of the advance itself in the local coordinates of difference().
InterfaceJacobian central_differences(RigidWorld& world, SimTime step, const WrenchSet& begin,
                                      const WrenchSet& end, double delta) {
  const Eigen::VectorXd lambda = stack(end);
  InterfaceJacobian jacobian(2 * lambda.size(), lambda.size());
  for (Eigen::Index i = 0; i < lambda.size(); ++i) {
    Eigen::VectorXd plus = lambda, minus = lambda;
    plus[i] += delta;
    minus[i] -= delta;
    const MotionSet high = end_of(world, step, begin, unstack_wrenches(plus));
    const MotionSet low = end_of(world, step, begin, unstack_wrenches(minus));
    jacobian.col(i) = difference(low, high) / (2 * delta);
  }
  return jacobian;
}

void expect_equal_jacobians(RigidWorld& world, SimTime step, double twist_tolerance) {
  const WrenchSet end = some_wrenches();
  const WrenchSet begin(2);
  world.initialize(begin);
  const InterfaceJacobian probed = jacobian_of(world, step, begin, end);
  const InterfaceJacobian central = central_differences(world, step, begin, end, 1.0);
  for (Eigen::Index port = 0; port < 2; ++port) {
    const auto pose = probed.middleRows<6>(12 * port);
    const auto twist = probed.middleRows<6>(12 * port + 6);
    EXPECT_LT((twist - central.middleRows<6>(12 * port + 6)).norm(),
              twist_tolerance * twist.norm());
    EXPECT_LT((pose - central.middleRows<6>(12 * port)).norm(), 1e-6 * pose.norm());
  }
}

// One step maps wrenches to bodies' twists by an affine function: probing is exact but for rounding
// (1e-12) and the central differences leave the curvature of v_WP, (1e-5 rad)².
TEST(MbsJacobian, EqualsCentralDifferencesInOneStep) {
  RigidWorld world(linkage());
  expect_equal_jacobians(world, kMillisecond, 1e-9);
}

// Later micro steps start from poses and rates that the probe changed by up to 1e-6: so is the
// one-sided difference's curvature.
TEST(MbsJacobian, EqualsCentralDifferencesOverMicroSteps) {
  Params params = linkage();
  params.micro_step = kMillisecond / 4;
  RigidWorld world(params);
  expect_equal_jacobians(world, kMillisecond, 1e-6);
}

// One semi-implicit Euler step of a free body: v⁺ = v + h f/m, w⁺ = w + h I⁻¹ t, p⁺ = p + h v⁺.
TEST(MbsJacobian, OfAFreeBodyIsStepOverMass) {
  Params params = params_with_step(kMillisecond);
  params.bodies = {body_at("body", 4.0, {1.0, 2.0, 3.0}, {0.2, 0.25, 0.4})};
  params.ports = {port_on("port", "body")};
  RigidWorld world(params);
  world.initialize(WrenchSet(1));
  const double h = 1e-3;
  InterfaceJacobian expected = InterfaceJacobian::Zero(12, 6);
  expected.block<3, 3>(6, 0).diagonal().setConstant(h / 4.0);
  expected.block<3, 3>(9, 3).diagonal() << h / 0.2, h / 0.25, h / 0.4;
  expected.topRows<6>() = h * expected.bottomRows<6>();
  const InterfaceJacobian found = jacobian_of(world, kMillisecond, WrenchSet(1), WrenchSet(1));
  // Velocity changes of 1e-3 m/s are rounded to 1e-19; positions of 3 m to 4e-16 of 1e-6 m.
  EXPECT_LT((found - expected).bottomRows<6>().norm(), 1e-12 * expected.bottomRows<6>().norm());
  EXPECT_LT((found - expected).topRows<6>().norm(), 1e-8 * expected.topRows<6>().norm());
}

TEST(MbsJacobian, AskingForItChangesNoBit) {
  RigidWorld plain(linkage());
  RigidWorld linearized(linkage());
  const WrenchSet wrenches = some_wrenches();
  plain.initialize(wrenches);
  linearized.initialize(wrenches);
  for (int i = 0; i < 100; ++i) {
    auto request = step_of(kMillisecond, wrenches, wrenches);
    const auto expected = plain.advance(request);
    request.linearize = true;
    const auto found = linearized.advance(request);
    EXPECT_EQ(difference(expected.output, found.output).cwiseAbs().maxCoeff(), 0.0);
    ASSERT_EQ(plain.observe().state_hash, linearized.observe().state_hash) << i;
  }
}

int freedoms_of(const JointParams& joint) {
  Params params = params_with_step(kMillisecond);
  params.bodies = {body_at("free", 1.0, {0.4, 0.1, 0.0}, {0.10, 0.12, 0.15}),
                   body_at("base", 1.0, {-0.3, 0.0, 0.0})};
  params.joints = {joint,
                   joint_between("ground", JointKind::Fixed, "base", kWorld, {-0.3, 0.0, 0.0})};
  params.ports = {port_on("port", "free")};
  RigidWorld world(params);
  world.initialize(WrenchSet(1));
  const InterfaceJacobian jacobian =
      jacobian_of(world, kMillisecond, WrenchSet(1), WrenchSet(1)).bottomRows<6>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian);
  // Mobilities h/m and h/I are 1e-3 and above; blocked directions answer by round-off alone.
  return static_cast<int>((svd.singularValues().array() > 1e-9).count());
}

TEST(MbsJacobian, CountsTheFreedomsThatEachJointLeaves) {
  const Eigen::Vector3d anchor(0.1, 0.0, 0.0);
  const auto between = [&](JointKind kind, const std::string& body2) {
    const int axes = coordinate_count(kind);
    return joint_between("joint", kind, "free", body2, anchor,
                         axes > 0 ? kZ : Eigen::Vector3d::Zero().eval(),
                         axes > 1 ? kY : Eigen::Vector3d::Zero().eval());
  };
  for (const std::string& body2 : {std::string("base"), std::string(kWorld)}) {
    EXPECT_EQ(freedoms_of(between(JointKind::Ball, body2)), 3);
    EXPECT_EQ(freedoms_of(between(JointKind::Hinge, body2)), 1);
    EXPECT_EQ(freedoms_of(between(JointKind::Slider, body2)), 1);
    EXPECT_EQ(freedoms_of(between(JointKind::Universal, body2)), 2);
    EXPECT_EQ(freedoms_of(between(JointKind::Fixed, body2)), 0);
  }
  EXPECT_EQ(freedoms_of(between(JointKind::Hinge2, "base")), 2);
}

}  // namespace
}  // namespace tandem::mbs::testing

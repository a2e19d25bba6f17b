// The interface Jacobian from the step's own response is that of probing: every joint, random
// mechanisms, closed loops, soft joints, stops and motors; where one of these changes its role,
// it is probed.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "mbs_process/port_jacobian.h"
#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

using Eigen::Vector3d;

/// The Jacobian of the step after `steps` with the same wrenches, by both ways.
struct BothWays {
  InterfaceJacobian response, probing;
  InterfaceJacobian central;   ///< differences
  double pose_rounding = 0.0;  ///< of these: 4 ε of places and attitudes of size 1, in six rows
  InterfaceJacobian free;      ///< of the same bodies without their joints
  int probed_columns = 0;
};

WrenchSet wrenches_for(const Params& params) {
  WrenchSet wrenches(params.ports.size());
  double value = 1.0;
  for (Wrench& wrench : wrenches) {
    wrench.f_P_W = {value, -0.5 * value, 0.3};
    wrench.t_P_W = {0.05, 0.1 * value, -0.02};
    value = -0.8 * value + 0.1;
  }
  return wrenches;
}

InterfaceJacobian without_joints(Params params) {
  params.joints.clear();
  RigidWorld world(params);
  world.initialize(WrenchSet(params.ports.size()));
  auto request =
      step_of(params.macro_step, WrenchSet(params.ports.size()), WrenchSet(params.ports.size()));
  request.linearize = true;
  return world.advance(request).jacobian.value();
}

/// Central differences of the advance by three times the probes either way.
InterfaceJacobian central_differences_of(RigidWorld& world, const WrenchSet& wrenches,
                                         double& rounding) {
  const Params& params = world.params();
  const Eigen::VectorXd lambda = stack(wrenches);
  InterfaceJacobian jacobian(2 * lambda.size(), lambda.size());
  double squares = 0.0;
  for (Eigen::Index column = 0; column < lambda.size(); ++column) {
    const scenario::PortParams& port = params.ports[static_cast<std::size_t>(column / 6)];
    const BodyParams& body = params.bodies[body_index(params, port.body).value()];
    const Vector3d p_BP = port.at_body_frame
                              ? Vector3d(0.0, 0.0, 0.0)
                              : Vector3d(body.q_WB.conjugate() * (port.p_WP - body.p_WB));
    const ProbeSizes sizes = probe_sizes(body, p_BP, to_seconds(params.macro_step));
    const double delta = 3.0 * (column % 6 < 3 ? sizes.force_N : sizes.torque_Nm);
    squares += 1.0 / (delta * delta);
    std::array<MotionSet, 2> ends;
    for (std::size_t side = 0; side < 2; ++side) {
      Eigen::VectorXd moved = lambda;
      moved[column] += side == 0 ? -delta : delta;
      world.rollback();
      ends[side] =
          world.advance(step_of(params.macro_step, wrenches, unstack_wrenches(moved))).output;
    }
    jacobian.col(column) = difference(ends[0], ends[1]) / (2.0 * delta);
  }
  rounding = 4.0 * 2.2e-16 * std::sqrt(6.0 * squares);
  return jacobian;
}

BothWays both_ways(const Params& params, int steps, const WrenchSet& wrenches) {
  RigidWorld world(params);
  world.initialize(WrenchSet(params.ports.size()));
  run(world, params.macro_step, steps, wrenches);
  world.checkpoint();
  BothWays found;
  auto request = step_of(params.macro_step, wrenches, wrenches);
  request.linearize = true;
  for (const auto how : {RigidWorld::Linearization::Probing, RigidWorld::Linearization::Response}) {
    world.rollback();
    world.linearize_by(how);
    const auto result = world.advance(request);
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    if (!result.jacobian) return found;
    (how == RigidWorld::Linearization::Probing ? found.probing : found.response) = *result.jacobian;
  }
  found.probed_columns = world.probed_columns();
  found.central = central_differences_of(world, wrenches, found.pose_rounding);
  found.free = without_joints(params);
  return found;
}

/// Twists are affine in the wrench: both ways agree but for rounding. Probes move a free body by
/// 1e-6 in a step, 1e-3 m/s, which is rounded to 1e-16 of some m/s, and either way of solving
/// leaves 1e-11 of the rows' impulses. One-sided probes of poses are linear to the turn within the
/// step times half of their own turn, 1e-6; of central differences that is squared.
void expect_same(const BothWays& found) {
  ASSERT_EQ(found.response.rows(), found.probing.rows());
  for (Eigen::Index row = 0; row < found.probing.rows(); row += 6) {
    const bool pose = row % 12 == 0;
    if (pose && found.probed_columns > 0) continue;
    const auto expected = (pose ? found.central : found.probing).middleRows<6>(row);
    const double rounding =
        1e-11 * found.free.middleRows<6>(row).norm() + (pose ? found.pose_rounding : 0.0);
    EXPECT_LE((found.response.middleRows<6>(row) - expected).norm(),
              1e-10 * expected.norm() + rounding)
        << "row " << row;
  }
}

void expect_all_by_response(const Params& params, int steps) {
  const BothWays found = both_ways(params, steps, wrenches_for(params));
  EXPECT_EQ(found.probed_columns, 0);
  expect_same(found);
}

/// Two bodies that spin, the first jointed to the second or the world.
Params pair(JointKind kind, bool to_world) {
  Params params = params_with_step(kMillisecond);
  params.gravity_m_per_s2 = {0.3, 0.0, -9.81};
  BodyParams a = body_at("a", 2.0, {0.3, 0.1, -0.2}, {0.10, 0.12, 0.15});
  a.q_WB = Eigen::AngleAxisd(0.4, Vector3d(2.0, -1.0, 1.0).normalized());
  a.w_WB = {1.0, -2.0, 3.0};
  BodyParams b = body_at("b", 1.0, {0.7, 0.0, 0.1}, {0.05, 0.06, 0.07});
  b.q_WB = Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, 3.0).normalized());
  b.v_WB = {0.5, 0.0, 1.0};
  b.w_WB = {4.0, 1.0, 0.0};
  params.bodies = {a, b};
  const int axes = coordinate_count(kind);
  params.joints = {joint_between("joint", kind, "a", to_world ? kWorld : "b", {0.45, 0.02, 0.03},
                                 axes > 0 ? Vector3d(0.2, 0.1, 1.0) : Vector3d(0.0, 0.0, 0.0),
                                 axes > 1 ? Vector3d(1.0, 0.0, -0.2) : Vector3d(0.0, 0.0, 0.0))};
  params.ports = {port_at("pa", "a", {0.4, 0.3, 0.0}), port_at("pb", "b", {0.9, -0.1, 0.2})};
  return params;
}

TEST(MbsResponse, IsThatOfProbingForEveryJoint) {
  for (const JointKind kind : {JointKind::Ball, JointKind::Hinge, JointKind::Slider,
                               JointKind::Universal, JointKind::Fixed, JointKind::Hinge2}) {
    for (const bool to_world : {false, true}) {
      if (kind == JointKind::Hinge2 && to_world) continue;
      SCOPED_TRACE(name_of(kind) + (to_world ? " to the world" : ""));
      expect_all_by_response(pair(kind, to_world), 0);
      expect_all_by_response(pair(kind, to_world), 30);
    }
  }
}

/// Bodies in a random tree, each jointed to an earlier one or the world at random.
Params random_tree(unsigned seed, std::size_t bodies) {
  std::mt19937 generator(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(generator()) / 4294967296.0);
  };
  const auto vector = [&](double most) {
    return Vector3d(uniform(-most, most), uniform(-most, most), uniform(-most, most));
  };
  Params params = params_with_step(kMillisecond);
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  params.cfm = seed % 3 == 0 ? 0.0 : (seed % 3 == 1 ? 1e-10 : 1e-4);
  const std::array kinds = {JointKind::Ball,      JointKind::Hinge, JointKind::Slider,
                            JointKind::Universal, JointKind::Fixed, JointKind::Hinge2};
  for (std::size_t i = 0; i < bodies; ++i) {
    BodyParams body = body_at(numbered("b", i), uniform(0.1, 5.0), vector(1.0));
    const double size = uniform(0.01, 0.2);
    body.inertia_kg_m2 = {size, 1.2 * size, 0.9 * size, 0.1 * size, -0.05 * size, 0.02 * size};
    body.q_WB = Eigen::AngleAxisd(uniform(0.0, 3.0), vector(1.0).normalized());
    body.w_WB = vector(2.0);
    body.v_WB = vector(1.0);
    params.bodies.push_back(body);
    JointKind kind = kinds[generator() % kinds.size()];
    const std::size_t to = generator() % (i + 1);
    if (to == i && kind == JointKind::Hinge2) kind = JointKind::Universal;
    const Vector3d s1 = vector(1.0);
    const Vector3d s2 = s1.cross(vector(1.0));
    const int axes = coordinate_count(kind);
    params.joints.push_back(joint_between(
        numbered("j", i), kind, body.name, to == i ? kWorld : numbered("b", to), vector(1.0),
        axes > 0 ? s1 : Vector3d(0.0, 0.0, 0.0), axes > 1 ? s2 : Vector3d(0.0, 0.0, 0.0)));
    if (i % 2 == 1) params.ports.push_back(port_at(numbered("p", i), body.name, vector(1.0)));
  }
  return params;
}

TEST(MbsResponse, IsThatOfProbingForRandomMechanisms) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    expect_all_by_response(random_tree(seed, 4 + seed % 9), static_cast<int>(seed));
  }
}

/// A four-bar loop of hinges about y, which constrains its plane more than once.
Params four_bar(double cfm) {
  Params params = params_with_step(kMillisecond);
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  params.cfm = cfm;
  params.bodies = {body_at("crank", 0.5, {0.0, 0.0, 0.1}, {0.002, 0.002, 0.0005}),
                   body_at("coupler", 1.0, {0.2, 0.0, 0.2}, {0.001, 0.02, 0.02}),
                   body_at("rocker", 0.7, {0.4, 0.0, 0.1}, {0.003, 0.003, 0.0005})};
  params.joints = {joint_between("a", JointKind::Hinge, "crank", kWorld, {0.0, 0.0, 0.0},
                                 Vector3d(0.0, 1.0, 0.0)),
                   joint_between("b", JointKind::Hinge, "coupler", "crank", {0.0, 0.0, 0.2},
                                 Vector3d(0.0, 1.0, 0.0)),
                   joint_between("c", JointKind::Hinge, "rocker", "coupler", {0.4, 0.0, 0.2},
                                 Vector3d(0.0, 1.0, 0.0)),
                   joint_between("d", JointKind::Hinge, "rocker", kWorld, {0.4, 0.0, 0.0},
                                 Vector3d(0.0, 1.0, 0.0))};
  params.ports = {port_at("pc", "coupler", {0.25, 0.1, 0.25}), port_on("pr", "rocker")};
  return params;
}

TEST(MbsResponse, IsThatOfProbingInClosedLoops) {
  for (const double cfm : {1e-10, 1e-8, 1e-5}) {
    SCOPED_TRACE(cfm);
    expect_all_by_response(four_bar(cfm), 0);
    expect_all_by_response(four_bar(cfm), 100);
  }
}

Params with_motor(JointKind kind, double rate, double most, int axis = 1) {
  Params params = pair(kind, false);
  params.cfm = 1e-10;
  params.joints[0].motor = MotorParams{.law = constant(rate), .axis = axis, .max_effort = most};
  return params;
}

TEST(MbsResponse, ContainsMotorsThatHoldAndThatYield) {
  for (const JointKind kind : {JointKind::Hinge, JointKind::Slider, JointKind::Universal}) {
    SCOPED_TRACE(name_of(kind));
    expect_all_by_response(with_motor(kind, 2.0, std::numeric_limits<double>::infinity()), 5);
    expect_all_by_response(with_motor(kind, 2.0, 1e6), 5);
    expect_all_by_response(with_motor(kind, 50.0, 0.5), 5);
  }
  expect_all_by_response(with_motor(JointKind::Universal, 2.0, 1e6, 2), 5);
  expect_all_by_response(with_motor(JointKind::Hinge2, 2.0, 1e6, 2), 5);
}

/// A joint pressed against a stop, or not yet at it.
Params with_limit(JointKind kind, double lower, double upper, int axis = 1) {
  Params params = pair(kind, false);
  params.cfm = 1e-10;
  params.joints[0].limits = {{.axis = axis, .lower = lower, .upper = upper}};
  return params;
}

TEST(MbsResponse, ContainsStopsThatPressAndThatAreAway) {
  for (const JointKind kind :
       {JointKind::Hinge, JointKind::Slider, JointKind::Universal, JointKind::Hinge2}) {
    SCOPED_TRACE(name_of(kind));
    // Zero is passed by the first step in one of both directions.
    for (const auto& [lower, upper] : {std::pair{0.0, 3.0}, {-3.0, 0.0}, {-3.0, 3.0}, {0.0, 0.0}}) {
      for (const int axis : {1, coordinate_count(kind)}) {
        if (kind == JointKind::Hinge2 && axis == 2) continue;  // turns freely
        SCOPED_TRACE(axis + 10 * lower + 100 * upper);
        const Params params = with_limit(kind, lower, upper, axis);
        const BothWays found = both_ways(params, 2, wrenches_for(params));
        // After two steps some of these stops are about to let go.
        EXPECT_LE(found.probed_columns, 4);
        expect_same(found);
      }
    }
  }
}

/// A box on a slider that stands on its lower stop, pushed by 1 N.
Params standing(double motor_effort) {
  Params params = params_with_step(kMillisecond);
  params.cfm = 1e-10;
  params.bodies = {body_at("box", 2.0, {0.0, 0.0, 0.5})};
  params.joints = {joint_between("slide", JointKind::Slider, "box", kWorld, {0.0, 0.0, 0.0},
                                 Vector3d(0.0, 0.0, 1.0))};
  params.joints[0].limits = {{.axis = 1, .lower = 0.0, .upper = 1.0}};
  if (motor_effort > 0.0) {
    params.joints[0].motor = MotorParams{.law = constant(-1.0), .max_effort = motor_effort};
  }
  params.ports = {port_on("port", "box")};
  return params;
}

WrenchSet push(double force_N) {
  WrenchSet wrenches(1);
  wrenches[0].f_P_W.z() = force_N;
  return wrenches;
}

TEST(MbsResponse, ContainsAMotorAgainstAStop) {
  const BothWays found = both_ways(standing(5.0), 3, push(-1.0));
  EXPECT_EQ(found.probed_columns, 0);
  expect_same(found);
}

// Probes of this box are 2 N: a load of 1 N beside the stop's change of role is within their reach,
// and 100 N are not.
TEST(MbsResponse, ProbesTheColumnsInWhichAStopLetsGo) {
  const BothWays near = both_ways(standing(0.0), 3, push(-1.0));
  EXPECT_EQ(near.probed_columns, 1);
  EXPECT_EQ(near.response.col(2), near.probing.col(2));
  expect_same(near);
  EXPECT_EQ(both_ways(standing(0.0), 3, push(-100.0)).probed_columns, 0);
}

TEST(MbsResponse, ProbesStepsThatAreSeveral) {
  Params params = pair(JointKind::Hinge, false);
  params.micro_step = kMillisecond / 2;
  const BothWays found = both_ways(params, 2, wrenches_for(params));
  EXPECT_EQ(found.probed_columns, 12);
  EXPECT_EQ(found.response, found.probing);
}

TEST(MbsResponse, IsTheSameToTheBitWhenRepeated) {
  const Params params = random_tree(5, 10);
  const WrenchSet wrenches = wrenches_for(params);
  EXPECT_EQ(both_ways(params, 4, wrenches).response, both_ways(params, 4, wrenches).response);
}

}  // namespace
}  // namespace tandem::mbs::testing

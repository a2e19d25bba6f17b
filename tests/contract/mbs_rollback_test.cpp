// Checkpoint and rollback of the multibody side are exact: everything here is compared by bits.
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <thread>

#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

using Generator = std::mt19937_64;

double uniform(Generator& generator, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}

Eigen::Vector3d random_vector(Generator& generator, double size) {
  const double x = uniform(generator, -size, size);
  const double y = uniform(generator, -size, size);
  return {x, y, uniform(generator, -size, size)};
}

Eigen::Quaterniond random_rotation(Generator& generator) {
  return Eigen::Quaterniond(
      Eigen::AngleAxisd(uniform(generator, -3.0, 3.0), random_vector(generator, 1.0).normalized()));
}

/// A chain of bodies on joints of random kinds with limits, motors, springs and forces.
Params random_mechanism(std::uint64_t seed) {
  Generator generator(seed);
  Params params;
  params.macro_step = 2 * kMillisecond;
  params.micro_step = kMillisecond;
  const std::size_t count = 1 + seed % 5;
  std::string previous = kWorld;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = numbered("b", i);
    const Eigen::Vector3d anchor = p + random_vector(generator, 0.3);
    p = anchor + random_vector(generator, 0.5);
    const Eigen::Vector3d moments = Eigen::Vector3d::Constant(2.0) + random_vector(generator, 0.5);
    BodyParams body = body_at(name, uniform(generator, 0.5, 3.0), p, moments);
    body.q_WB = random_rotation(generator);
    body.v_WB = random_vector(generator, 1.0);
    body.w_WB = random_vector(generator, 3.0);
    params.bodies.push_back(body);
    const Eigen::Vector3d axis = random_vector(generator, 1.0);
    const Eigen::Vector3d axis2 = axis.unitOrthogonal();
    const int pick = static_cast<int>(generator() % 7);
    const auto joint_name = numbered("j", i);
    if (pick == 0)
      params.joints.push_back(joint_between(joint_name, JointKind::Ball, name, previous, anchor));
    if (pick == 1)
      params.joints.push_back(
          joint_between(joint_name, JointKind::Slider, name, previous, anchor, axis));
    if (pick == 2)
      params.joints.push_back(
          joint_between(joint_name, JointKind::Universal, name, previous, anchor, axis, axis2));
    if (pick == 3 && previous != kWorld)
      params.joints.push_back(
          joint_between(joint_name, JointKind::Hinge2, name, previous, anchor, axis, axis2));
    if (pick == 4)
      params.joints.push_back(joint_between(joint_name, JointKind::Fixed, name, previous, anchor));
    if (pick >= 5) {
      JointParams hinge = joint_between(joint_name, JointKind::Hinge, name, previous, anchor, axis);
      if (pick == 5) hinge.limits = {{.axis = 1, .lower = -0.05, .upper = 0.05}};
      if (pick == 6) {
        hinge.motor = MotorParams{.kind = MotorParams::Kind::Position,
                                  .law = Law(HarmonicLaw{0.0, 0.4, 3.0, 0.1}),
                                  .axis = 1,
                                  .max_effort = 50.0};
      }
      params.joints.push_back(hinge);
      params.joint_springs.push_back({.name = numbered("js", i),
                                      .joint = joint_name,
                                      .stiffness = 20.0,
                                      .damping = 0.1,
                                      .rest = 0.2});
    }
    params.springs.push_back({.name = numbered("s", i),
                              .body1 = name,
                              .body2 = previous,
                              .p1_W = p,
                              .p2_W = anchor,
                              .stiffness_N_per_m = 100.0,
                              .damping_N_s_per_m = 1.0,
                              .rest_length_m = 0.1});
    params.forces.push_back({.name = numbered("f", i),
                             .body = name,
                             .kind = ForceParams::Kind::Force,
                             .p_BF = random_vector(generator, 0.2),
                             .direction_W = Eigen::Vector3d::UnitY(),
                             .law = Law(HarmonicLaw{1.0, 5.0, 2.0, 0.3})});
    params.ports.push_back(port_at(numbered("p", i), name, anchor, random_rotation(generator)));
    previous = name;
  }
  return params;
}

WrenchSet random_wrenches(Generator& generator, std::size_t count) {
  WrenchSet wrenches(count);
  for (Wrench& wrench : wrenches) {
    wrench.f_P_W = random_vector(generator, 20.0);
    wrench.t_P_W = random_vector(generator, 5.0);
  }
  return wrenches;
}

/// Steps a world n times with a fixed sequence of wrenches, with a rejected trial in each step when
/// `trials` is set, and returns the hash of the state after each step.
std::vector<std::uint64_t> hashes_of_run(RigidWorld& world, std::uint64_t seed, int n, int trials) {
  const std::size_t ports = world.info().ports.size();
  Generator generator(seed);
  Generator rejected(seed + 1);
  std::vector<std::uint64_t> hashes;
  WrenchSet begin = random_wrenches(generator, ports);
  world.initialize(begin);
  for (int i = 0; i < n; ++i) {
    const WrenchSet end = random_wrenches(generator, ports);
    world.checkpoint();
    for (int trial = 0; trial < trials; ++trial) {
      auto request = step_of(world.params().macro_step, begin, random_wrenches(rejected, ports));
      request.linearize = trial == 0;
      const auto trial_result = world.advance(request);
      EXPECT_EQ(trial_result.outcome, Outcome::Done) << trial_result.message;
      world.rollback();
    }
    const auto result = world.advance(step_of(world.params().macro_step, begin, end));
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    hashes.push_back(world.observe().state_hash);
    begin = end;
  }
  return hashes;
}

TEST(MbsRollback, RejectedTrialsLeaveNoTraceInRandomMechanisms) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Params params = random_mechanism(seed);
    if (seed % 3 == 1) params.integrator = IntegratorKind::Verlet;
    if (seed % 3 == 2) params.integrator = IntegratorKind::GeneralisedAlpha;
    RigidWorld plain(params);
    RigidWorld tried(params);
    EXPECT_EQ(hashes_of_run(plain, seed, 50, 0), hashes_of_run(tried, seed, 50, 3)) << seed;
  }
}

TEST(MbsRollback, InitializeStartsTheSameRunAgain) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Params params = random_mechanism(seed);
    if (seed % 2 == 1) params.integrator = IntegratorKind::GeneralisedAlpha;
    RigidWorld world(params);
    const auto first = hashes_of_run(world, seed, 30, 0);
    EXPECT_EQ(first, hashes_of_run(world, seed, 30, 1)) << seed;
  }
}

TEST(MbsRollback, OtherWorldsOfTheProcessDoNotMatter) {
  RigidWorld alone(random_mechanism(4));
  const auto expected = hashes_of_run(alone, 4, 40, 0);
  RigidWorld world(random_mechanism(4));
  std::vector<RigidWorld> others;
  others.reserve(40);
  Generator generator(4);
  const std::size_t ports = world.info().ports.size();
  WrenchSet begin = random_wrenches(generator, ports);
  world.initialize(begin);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    others.emplace_back(random_mechanism(i));
    hashes_of_run(others.back(), i, 3, 1);
    if (i % 3 == 0) others.clear();
    const WrenchSet end = random_wrenches(generator, ports);
    world.advance(step_of(world.params().macro_step, begin, end));
    EXPECT_EQ(world.observe().state_hash, expected[i]);
    begin = end;
  }
}

TEST(MbsRollback, WorldsInThreadsGiveTheSameBits) {
  std::vector<std::vector<std::uint64_t>> expected(8);
  std::vector<std::vector<std::uint64_t>> found(8);
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    RigidWorld world(random_mechanism(seed));
    expected[seed] = hashes_of_run(world, seed, 50, 1);
  }
  std::vector<std::thread> threads;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    threads.emplace_back([&found, seed] {
      RigidWorld world(random_mechanism(seed));
      found[seed] = hashes_of_run(world, seed, 50, 1);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(expected, found);
}

// A micro step is a pure function of the state, so it does not matter where steps are cut: torques
// are about where the ports stand when a macro step begins.
TEST(MbsRollback, TwoMicroStepsInOneAdvanceEqualTwoAdvances) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    RigidWorld once(random_mechanism(seed));
    RigidWorld twice(random_mechanism(seed));
    Generator generator(seed);
    const WrenchSet wrenches = random_wrenches(generator, once.info().ports.size());
    once.initialize(wrenches);
    MotionSet begin = twice.initialize(wrenches);
    run(once, 2 * kMillisecond, 25, wrenches);
    for (int i = 0; i < 25; ++i) {
      const MotionSet middle = twice.advance(step_of(kMillisecond, wrenches, wrenches)).output;
      WrenchSet second = wrenches;
      for (std::size_t p = 0; p < second.size(); ++p) {
        second[p].t_P_W += (begin[p].p_WP - middle[p].p_WP).cross(second[p].f_P_W);
      }
      begin = twice.advance(step_of(kMillisecond, wrenches, second)).output;
    }
    EXPECT_EQ(once.observe().state_hash, twice.observe().state_hash) << seed;
  }
}

}  // namespace
}  // namespace tandem::mbs::testing

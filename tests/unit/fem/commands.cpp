#include <gtest/gtest.h>

#include "protocol/contract/error.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

constexpr double kStep_s = 1e-2;

/// A soft row of three cubes (300 kg), clamped at x = 0.
Params clamped_row(IntegratorKind integrator = IntegratorKind::BackwardEuler) {
  static const std::filesystem::path file = temporary_file("commands.inp", box_inp(3));
  Params params;
  params.mesh.file = file;
  params.material = {.young_Pa = 3e4, .poisson = 0.3, .density_kg_per_m3 = 100.0};
  params.integrator.kind = integrator;
  params.micro_step = sim_time_from_seconds(kStep_s);
  params.fixed = {{"LEFT"}};
  return params;
}

void advance(FlexibleBody& body, int steps) {
  for (int k = 0; k < steps; ++k) {
    const auto result = body.advance({.step = sim_time_from_seconds(kStep_s), .input = {}});
    ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
    body.checkpoint();
  }
}

void make(FlexibleBody& body, const std::string& command) {
  const CommandResult result = body.command(command);
  ASSERT_TRUE(result.accepted) << result.message;
  body.checkpoint();
}

class FemCommand : public ::testing::TestWithParam<IntegratorKind> {};

INSTANTIATE_TEST_SUITE_P(Kinds, FemCommand,
                         ::testing::Values(IntegratorKind::BackwardEuler, IntegratorKind::Hht,
                                           IntegratorKind::GeneralisedAlpha,
                                           IntegratorKind::Newmark));

// Released under gravity, the body falls: whatever it does inside, the change of momentum is the
// impulse of its weight, to the round-off of the elastic forces (1e4 N · 1e-16 a step). Its weights
// of old and new forces make generalised-α pay the impulse of the first step late by α_f h.
TEST_P(FemCommand, ReleasedBodyGainsTheImpulseOfItsWeight) {
  Params params = clamped_row(GetParam());
  params.gravity_m_per_s2 = {0, 0, -9.81};
  FlexibleBody body(params);
  body.initialize({});
  body.checkpoint();
  advance(body, 20);
  make(body, "release LEFT");
  EXPECT_TRUE(body.model().prescribed.empty());
  const Eigen::Vector3d begin = linear_momentum(body);
  advance(body, 50);
  const Eigen::Vector3d gained = linear_momentum(body) - begin;
  EXPECT_LT((gained - Eigen::Vector3d(0, 0, -300.0 * 9.81 * 50 * kStep_s)).norm(), 1e-8);
}

TEST_P(FemCommand, FixedNodesStayWhereTheyWere) {
  Params params = clamped_row(GetParam());
  params.gravity_m_per_s2 = {0, 0, -1.0};
  FlexibleBody body(params);
  body.initialize({});
  body.checkpoint();
  advance(body, 20);
  make(body, "fix RIGHT");
  const Eigen::VectorXd held = body.state().x;
  advance(body, 20);
  for (int node : find_set(body.model().mesh, {.name = "RIGHT"}).nodes) {
    EXPECT_EQ(body.state().x.segment<3>(3 * node), held.segment<3>(3 * node));
    EXPECT_EQ(body.state().v.segment<3>(3 * node).norm(), 0.0);
    EXPECT_GT((held.segment<3>(3 * node) - body.model().reference().segment<3>(3 * node)).norm(),
              1e-3);
  }
}

// A force by command is the same as a nodal load of the scenario, from the first step on; given
// again it takes the place of the last one, 0,0,0 ends it. Equal up to the order of the sums.
TEST_P(FemCommand, ForceIsThatOfANodalLoad) {
  Params loaded = clamped_row(GetParam());
  loaded.loads = {{.kind = Load::Kind::Nodal, .set = {"RIGHT"}, .value = {1.0, 20.0, -3.5}}};
  FlexibleBody by_load(loaded);
  by_load.initialize({});
  by_load.checkpoint();
  FlexibleBody by_command(clamped_row(GetParam()));
  by_command.initialize({});
  make(by_command, "force RIGHT 5,5,5");
  make(by_command, "force RIGHT 1,20,-3.5");
  advance(by_load, 30);
  advance(by_command, 30);
  const double scale = (by_load.state().x - by_load.model().reference()).norm();
  ASSERT_GT(scale, 1e-3);
  EXPECT_LT((by_load.state().x - by_command.state().x).norm(), 1e-11 * scale);
  EXPECT_NEAR(by_load.observe().energy.external_work_J, by_command.observe().energy.external_work_J,
              1e-10);
  make(by_command, "force RIGHT 0,0,0");
  EXPECT_TRUE(by_command.state().boundary.forces.empty());
}

// Every macro step repeated after wrong ones, commands between, and a rollback over a command: the
// bits of the plain run.
TEST_P(FemCommand, RollbackIsExactAcrossCommands) {
  Params params = clamped_row(GetParam());
  params.gravity_m_per_s2 = {0, 0.3, -1.0};
  params.solver.kind = GetParam() == IntegratorKind::Hht ? SolverKind::Pcg : SolverKind::Cholmod;
  FlexibleBody plain(params);
  FlexibleBody repeated(params);
  const SimTime H = sim_time_from_seconds(2 * kStep_s);
  for (FlexibleBody* body : {&plain, &repeated}) {
    body->initialize({});
    body->checkpoint();
  }
  const std::vector<std::string> commands{"force RIGHT 0,0,40", "release LEFT", "fix RIGHT",
                                          "fix LEFT", "release RIGHT"};
  for (const std::string& command : commands) {
    make(plain, command);
    plain.advance({.step = H, .input = {}});
    plain.checkpoint();

    repeated.command(command);
    repeated.rollback();  // the command is undone
    repeated.advance({.step = H, .input = {}});
    repeated.rollback();
    make(repeated, command);
    repeated.advance({.step = H, .input = {}});
    repeated.rollback();
    repeated.advance({.step = H, .input = {}});
    repeated.checkpoint();
    EXPECT_EQ(repeated.observe().state_hash, plain.observe().state_hash) << command;
  }
}

TEST(FemChanges, ScheduledAreThoseByHand) {
  Params params = clamped_row();
  params.gravity_m_per_s2 = {0, 0, -1.0};
  FlexibleBody by_hand(params);
  params.changes = {{sim_time_from_seconds(0.045), "release LEFT", {}},
                    {sim_time_from_seconds(0.1), force_command({0.1, 1e-3, 7}, "RIGHT"), {}}};
  FlexibleBody scheduled(params);
  for (FlexibleBody* body : {&by_hand, &scheduled}) {
    body->initialize({});
    body->checkpoint();
  }
  advance(scheduled, 20);
  advance(by_hand, 5);  // 0.045 s is between two steps: the change waits for the next
  make(by_hand, "release LEFT");
  advance(by_hand, 5);
  make(by_hand, "force RIGHT 0.1,0.001,7");
  advance(by_hand, 10);
  EXPECT_EQ(by_hand.state().x, scheduled.state().x);
  EXPECT_EQ(by_hand.state().v, scheduled.state().v);
}

TEST(FemChanges, WrongCommandsAreRefusedAndChangeNothing) {
  Params params = clamped_row();
  params.ports = {{"port", {"RIGHT"}, Eigen::Vector3d(3.0, 0.5, 0.5)}};
  FlexibleBody body(params);
  MotionSet rest(1);
  rest[0].p_WP = {3.0, 0.5, 0.5};
  body.initialize(rest);
  const std::uint64_t hash = body.observe().state_hash;
  const auto refused = [&](const std::string& command, const std::string& reason) {
    const CommandResult result = body.command(command);
    EXPECT_FALSE(result.accepted) << command;
    EXPECT_NE(result.message.find(reason), std::string::npos) << result.message;
    EXPECT_EQ(body.observe().state_hash, hash) << command;
  };
  refused("release RIGTH", "no node set 'RIGTH'");
  refused("release RIGHT", "not fixed");
  refused("fix LEFT", "fixed already");
  refused("fix RIGHT", "in the port 'port'");
  refused("force LEFT 1,2", "no force");
  refused("force LEFT 1,2,x", "no force");
  refused("force LEFT 1,2,inf", "no force");
  refused("force 1,2,3", "no node set ''");
  refused("force 1,2,3 LEFT", "'force SET FX,FY,FZ'");  // the other way round
  refused("melt LEFT", "no command");
  refused("", "no command");
}

TEST(FemChanges, WrongScheduleIsFoundBeforeTheRun) {
  Params params = clamped_row();
  params.changes = {{sim_time_from_seconds(0.1), "release LEFT", {"a.yaml", 7, 3}},
                    {sim_time_from_seconds(0.2), "release LEFT", {"a.yaml", 8, 3}}};
  try {
    FlexibleBody body(params);
    FAIL() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_TRUE(std::string(error.what()).starts_with("a.yaml:8:3: ")) << error.what();
  }
  params.integrator.kind = IntegratorKind::QuasiStatic;
  params.changes.resize(1);
  EXPECT_THROW(FlexibleBody{params}, Error);  // nothing would hold it
}

}  // namespace
}  // namespace tandem::fem

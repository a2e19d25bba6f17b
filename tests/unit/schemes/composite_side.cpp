// Several flexible bodies, or several multibody worlds, as one side.
#include "protocol/driver/composite_side.h"

#include <gtest/gtest.h>

#include "protocol/contract/error.h"
#include "protocol/contract/hash.h"

namespace tandem {
namespace {

/// Answers λ = k p at each port; counts what it is asked, and fails where it is told to.
class SpringBody final : public FemSide {
 public:
  SpringBody(std::vector<std::string> ports, double stiffness_N_per_m) : k_(stiffness_N_per_m) {
    info_ = {.name = "fem", .ports = {}, .micro_step = {}, .can_linearize = true};
    for (std::string& port : ports)
      info_.ports.push_back({.name = std::move(port), .length_m = k_});
  }
  const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override { return answer(motions); }
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override {
    ++advances;
    StepResult<WrenchSet> result;
    result.outcome = outcome;
    result.message = outcome == Outcome::Done ? "" : "fem: broken";
    if (outcome != Outcome::Failed) result.output = answer(request.input.end);
    result.output_error_N = k_;
    if (request.linearize) {
      const auto n = static_cast<Eigen::Index>(info_.ports.size());
      result.jacobian = Eigen::MatrixXd::Constant(6 * n, 12 * n, k_);
    }
    return result;
  }
  void checkpoint() override { ++checkpoints; }
  void rollback() override { ++rollbacks; }
  CommandResult command(const std::string& text) override {
    commanded = text;
    return {.accepted = true, .message = "done", .cost = {}};
  }
  Observation observe() override {
    return {.energy = {.elastic_J = k_}, .state_hash = static_cast<std::uint64_t>(k_)};
  }

  Outcome outcome = Outcome::Done;
  int advances = 0, checkpoints = 0, rollbacks = 0;
  std::string commanded;

 private:
  WrenchSet answer(const MotionSet& motions) const {
    WrenchSet wrenches(motions.size());
    for (std::size_t i = 0; i < motions.size(); ++i) {
      wrenches[i].f_P_W = k_ * motions[i].p_WP;
    }
    return wrenches;
  }
  double k_;
  SubsystemInfo info_;
};

/// Ports 0 and 2 on 'soft' (k = 3 N/m), 1 on 'stiff' (k = 4 N/m).
struct TwoBodies : testing::Test {
  SpringBody* soft = new SpringBody({"a", "c"}, 3.0);
  SpringBody* stiff = new SpringBody({"b"}, 4.0);
  CompositeFem both = [this] {
    std::vector<FemPart> parts;
    parts.push_back({"soft", std::unique_ptr<FemSide>(soft), {0, 2}});
    parts.push_back({"stiff", std::unique_ptr<FemSide>(stiff), {1}});
    return CompositeFem(std::move(parts));
  }();
  static MotionSet motions() {
    MotionSet motions(3);
    for (std::size_t i = 0; i < 3; ++i) motions[i].p_WP.x() = static_cast<double>(i + 1);
    return motions;
  }
  StepResult<WrenchSet> advance(bool linearize = false) {
    return both.advance({.step = sim_time_from_seconds(1e-3),
                         .input = {motions(), motions()},
                         .linearize = linearize});
  }
};

TEST_F(TwoBodies, AnswerInTheOrderOfThePortTable) {
  EXPECT_EQ(both.info().ports[1].name, "b");
  EXPECT_EQ(both.info().ports[2].name, "c");
  EXPECT_EQ(both.info().ports[2].body, 0);
  EXPECT_EQ(both.info().ports[1].body, 1);
  EXPECT_EQ(both.initialize(motions())[1].f_P_W.x(), 8.0);
  const StepResult<WrenchSet> result = advance();
  EXPECT_EQ(result.outcome, Outcome::Done);
  EXPECT_EQ(result.output[0].f_P_W.x(), 3.0);
  EXPECT_EQ(result.output[1].f_P_W.x(), 8.0);
  EXPECT_EQ(result.output[2].f_P_W.x(), 9.0);
  EXPECT_EQ(result.output_error_N, 5.0);  // √(3² + 4²)
  EXPECT_FALSE(result.jacobian);
}

TEST_F(TwoBodies, HaveABlockDiagonalJacobian) {
  const Eigen::MatrixXd L = advance(true).jacobian.value();
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      const bool same = (row == 1) == (column == 1);
      const double expected = !same ? 0.0 : row == 1 ? 4.0 : 3.0;
      EXPECT_EQ((L.block<6, 12>(6 * row, 12 * column).minCoeff()), expected);
      EXPECT_EQ((L.block<6, 12>(6 * row, 12 * column).maxCoeff()), expected);
    }
  }
}

// A macro step that one fails is no step of the others either.
TEST_F(TwoBodies, RollBackTogether) {
  stiff->outcome = Outcome::Failed;
  const StepResult<WrenchSet> result = advance(true);
  EXPECT_EQ(result.outcome, Outcome::Failed);
  EXPECT_EQ(result.message, "stiff: fem: broken");
  EXPECT_TRUE(result.output.empty());
  EXPECT_EQ(soft->rollbacks, 1);
  EXPECT_EQ(stiff->rollbacks, 1);
  EXPECT_EQ(soft->advances, 1) << "all compute at the same time";
}

TEST_F(TwoBodies, TakeTheWorstOutcome) {
  soft->outcome = Outcome::NotConverged;
  const StepResult<WrenchSet> result = advance();
  EXPECT_EQ(result.outcome, Outcome::NotConverged);
  EXPECT_EQ(result.output[1].f_P_W.x(), 8.0);
  EXPECT_EQ(soft->rollbacks, 0);
}

TEST_F(TwoBodies, TakeCommandsByName) {
  EXPECT_TRUE(both.command("stiff fix HUB").accepted);
  EXPECT_EQ(stiff->commanded, "fix HUB");
  EXPECT_EQ(soft->commanded, "");
  const CommandResult refused = both.command("fix HUB");
  EXPECT_FALSE(refused.accepted);
  EXPECT_EQ(refused.message,
            "fem: 'fix HUB': which flexible body is meant? Name it with --body: soft, stiff.");
}

TEST_F(TwoBodies, AddTheirBooksAndHashes) {
  const Observation seen = both.observe();
  EXPECT_EQ(seen.energy.elastic_J, 7.0);
  StateHash hash;
  hash.add(std::uint64_t{3});
  hash.add(std::uint64_t{4});
  EXPECT_EQ(seen.state_hash, hash.value());
}

/// Answers p = λ / m at each port; counts roll-backs, and fails where it is told to.
class MassWorld final : public MbsSide {
 public:
  MassWorld(std::vector<std::string> ports, double mass_kg, JointGap gap) : m_(mass_kg) {
    info_ = {.name = "mbs",
             .ports = {},
             .micro_step = sim_time_from_seconds(1e-3 / mass_kg),
             .can_linearize = true};
    for (std::string& port : ports) info_.ports.push_back({.name = std::move(port)});
    gap_ = gap;
  }
  const SubsystemInfo& info() const override { return info_; }
  MotionSet initialize(const WrenchSet& wrenches) override { return answer(wrenches); }
  StepResult<MotionSet> advance(const StepRequest<WrenchSet>& request) override {
    StepResult<MotionSet> result;
    result.outcome = outcome;
    result.message = outcome == Outcome::Done ? "" : "mbs: broken";
    if (outcome != Outcome::Failed) result.output = answer(request.input.end);
    const auto n = static_cast<Eigen::Index>(info_.ports.size());
    if (request.linearize) result.jacobian = Eigen::MatrixXd::Constant(12 * n, 6 * n, m_);
    return result;
  }
  void checkpoint() override {}
  void rollback() override { ++rollbacks; }
  Observation observe() override {
    return {.energy = {.kinetic_J = m_},
            .state_hash = static_cast<std::uint64_t>(m_),
            .widest_joint = gap_};
  }

  Outcome outcome = Outcome::Done;
  int rollbacks = 0;

 private:
  MotionSet answer(const WrenchSet& wrenches) const {
    MotionSet motions(wrenches.size());
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      motions[i].p_WP = wrenches[i].f_P_W / m_;
    }
    return motions;
  }
  double m_;
  JointGap gap_;
  SubsystemInfo info_;
};

/// Ports 0 and 2 in 'heavy' (4 kg), 1 in 'light' (2 kg).
struct TwoWorlds : testing::Test {
  MassWorld* heavy =
      new MassWorld({"a", "c"}, 4.0, {.gap_m = 1e-3, .part = 0.1, .joint = 3, .world = 0});
  MassWorld* light =
      new MassWorld({"b"}, 2.0, {.gap_m = 1e-4, .part = 0.2, .joint = 1, .world = 0});
  CompositeMbs both = [this] {
    std::vector<MbsPart> parts;
    parts.push_back({"heavy", std::unique_ptr<MbsSide>(heavy), {0, 2}});
    parts.push_back({"light", std::unique_ptr<MbsSide>(light), {1}});
    return CompositeMbs(std::move(parts));
  }();
  StepResult<MotionSet> advance() {
    WrenchSet wrenches(3);
    for (Wrench& wrench : wrenches) wrench.f_P_W.x() = 8.0;
    return both.advance(
        {.step = sim_time_from_seconds(1e-3), .input = {wrenches, wrenches}, .linearize = true});
  }
};

TEST_F(TwoWorlds, AnswerInTheOrderOfThePortTable) {
  EXPECT_EQ(both.info().name, "mbs");
  EXPECT_EQ(both.info().ports[1].name, "b");
  EXPECT_EQ(both.info().micro_step, sim_time_from_seconds(1e-3 / 4.0)) << "the shorter one";
  const StepResult<MotionSet> result = advance();
  EXPECT_EQ(result.output[0].p_WP.x(), 2.0);
  EXPECT_EQ(result.output[1].p_WP.x(), 4.0);
  EXPECT_EQ(result.output[2].p_WP.x(), 2.0);
}

TEST_F(TwoWorlds, HaveABlockDiagonalJacobian) {
  const Eigen::MatrixXd B = advance().jacobian.value();
  ASSERT_EQ(B.rows(), 36);
  ASSERT_EQ(B.cols(), 18);
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      const bool same = (row == 1) == (column == 1);
      const double expected = !same ? 0.0 : row == 1 ? 2.0 : 4.0;
      EXPECT_EQ((B.block<12, 6>(12 * row, 6 * column).minCoeff()), expected);
      EXPECT_EQ((B.block<12, 6>(12 * row, 6 * column).maxCoeff()), expected);
    }
  }
}

TEST_F(TwoWorlds, RollBackTogether) {
  light->outcome = Outcome::Failed;
  const StepResult<MotionSet> result = advance();
  EXPECT_EQ(result.outcome, Outcome::Failed);
  EXPECT_EQ(result.message, "light: mbs: broken");
  EXPECT_EQ(heavy->rollbacks, 1);
  EXPECT_EQ(light->rollbacks, 1);
}

TEST_F(TwoWorlds, AddTheirBooksAndNameTheWidestJoint) {
  const Observation seen = both.observe();
  EXPECT_EQ(seen.energy.kinetic_J, 6.0);
  StateHash hash;
  hash.add(std::uint64_t{4});
  hash.add(std::uint64_t{2});
  EXPECT_EQ(seen.state_hash, hash.value());
  ASSERT_EQ(seen.bodies.size(), 2U);
  EXPECT_EQ(seen.bodies[1].name, "light");
  EXPECT_EQ(seen.widest_joint.world, 1);
  EXPECT_EQ(seen.widest_joint.joint, 1);
  EXPECT_EQ(seen.widest_joint.part, 0.2);
}

TEST_F(TwoWorlds, TakeNoCommands) {
  const CommandResult refused = both.command("heavy fix HUB");
  EXPECT_FALSE(refused.accepted);
  EXPECT_EQ(refused.message, "mbs: takes no commands, not 'heavy fix HUB'.");
}

}  // namespace
}  // namespace tandem

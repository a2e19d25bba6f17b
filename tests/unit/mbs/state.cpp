// The fingerprint of the multibody side's state covers all that its future depends on.
#include "mbs_process/state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

namespace tandem::mbs::testing {
namespace {

TEST(MbsState, EveryBitOfEveryMemberIsInTheHash) {
  State sound;
  sound.bodies.resize(2);
  sound.bodies[1].p_WB = {1.0, 2.0, 3.0};
  sound.joint_coordinates = {{0.5, 0.25}};
  const auto nudge = [](double& x) { x = std::nextafter(x, std::numeric_limits<double>::max()); };
  std::vector<std::function<void(State&)>> changes = {
      [](State& s) { s.time += SimTime(1); },
      [&](State& s) { nudge(s.joint_coordinates[0][0]); },
      [&](State& s) { nudge(s.joint_coordinates[0][1]); },
      [&](State& s) { nudge(s.book.external_work_J); },
      [&](State& s) { nudge(s.book.interface_work_J); },
      [&](State& s) { nudge(s.book.damping_loss_J); },
      [&](State& s) { nudge(s.book.numerical_loss_J); },
      [](State& s) { std::swap(s.bodies[0], s.bodies[1]); }};
  for (Eigen::Index i = 0; i < 3; ++i) {
    changes.emplace_back([&, i](State& s) { nudge(s.bodies[1].p_WB[i]); });
    changes.emplace_back([&, i](State& s) { nudge(s.bodies[1].v_WB[i]); });
    changes.emplace_back([&, i](State& s) { nudge(s.bodies[1].w_WB[i]); });
  }
  for (Eigen::Index i = 0; i < 4; ++i) {
    changes.emplace_back([&, i](State& s) { nudge(s.bodies[1].q_WB.coeffs()[i]); });
  }
  std::set<std::uint64_t> hashes = {hash_of(sound)};
  for (const auto& change : changes) {
    State changed = sound;
    change(changed);
    EXPECT_TRUE(hashes.insert(hash_of(changed)).second);
  }
}

}  // namespace
}  // namespace tandem::mbs::testing

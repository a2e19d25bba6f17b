#include "fem_process/ports/floating_frame.h"

#include <gtest/gtest.h>

#include "fem_process/kernels/cross_matrix.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

MotionSet three_parts() {
  MotionSet motions = pair_motion(0.3);
  motions.push_back(motions[0]);
  motions[2].p_WP += Eigen::Vector3d(0.1, 0.4, -0.2);
  motions[2].q_WP = rotation({0.3, 0.1, -0.2}) * motions[2].q_WP;
  motions[2].v_WP = {0.4, -1.0, 2.0};
  motions[2].w_WP = {-1.0, 0.5, 0.2};
  return motions;
}

MotionSet start_of_three_parts() {
  MotionSet motions = three_parts();
  for (Motion& motion : motions) motion.q_WP = rotation({0.1, -0.4, 0.2});
  motions[1].p_WP += Eigen::Vector3d(0.05, 0.02, 0.01);
  return motions;
}

MotionSet moved(MotionSet motions, const Eigen::VectorXd& change, double amount) {
  for (std::size_t b = 0; b < motions.size(); ++b) {
    const auto at = 12 * static_cast<Eigen::Index>(b);
    Motion& m = motions[b];
    m.p_WP += amount * change.segment<3>(at);
    m.q_WP = rotation(amount * change.segment<3>(at + 3)) * m.q_WP;
    m.v_WP += amount * change.segment<3>(at + 6);
    m.w_WP += amount * change.segment<3>(at + 9);
  }
  return motions;
}

class FemFloatingFrame : public ::testing::TestWithParam<std::vector<double>> {
 protected:
  FloatingFrame frame() const {
    return FloatingFrame(start_of_three_parts(), GetParam(), {0.1, 0.2, 0.3});
  }
};

INSTANTIATE_TEST_SUITE_P(Weights, FemFloatingFrame,
                         ::testing::Values(std::vector<double>{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                           std::vector<double>{0.0, 1.0, 0.0},
                                           std::vector<double>{0.0, 0.0, 0.0}));

// Central differences over 1e-5 leave 1e-10 of third derivatives of order 1, and round-off 1e-11.
TEST_P(FemFloatingFrame, ChangeMatchesCentralDifferences) {
  const FloatingFrame frame = this->frame();
  const auto at = frame.place(three_parts());
  for (int seed = 0; seed < 36; ++seed) {
    const Eigen::VectorXd change = Eigen::VectorXd::Unit(36, seed);
    const auto exact = frame.change(at, change);
    const double amount = 1e-5;
    const auto above = frame.place(moved(three_parts(), change, amount));
    const auto below = frame.place(moved(three_parts(), change, -amount));
    const double scale = 1.0 / (2.0 * amount);
    EXPECT_LT((scale * (above.p_WF - below.p_WF) - exact.p_WF).norm(), 1e-8);
    EXPECT_LT((scale * (above.R_WF - below.R_WF) - exact.R_WF).norm(), 1e-8);
    EXPECT_LT((scale * (above.v_WF - below.v_WF) - exact.v_WF).norm(), 1e-8);
    EXPECT_LT((scale * (above.w_WF - below.w_WF) - exact.w_WF).norm(), 1e-8);
    EXPECT_LT((scale * (above.z - below.z) - exact.z).norm(), 1e-8);
    EXPECT_LT((scale * (above.z_dot - below.z_dot) - exact.z_dot).norm(), 1e-8);
    EXPECT_LT((scale * (above.jacobian - below.jacobian) - exact.jacobian).norm(), 1e-8);
  }
}

// Velocities are the poses' derivatives along the twists.
TEST_P(FemFloatingFrame, RatesAreDerivativesOfThePlacement) {
  const FloatingFrame frame = this->frame();
  const auto at = frame.place(three_parts());
  Eigen::VectorXd drift = Eigen::VectorXd::Zero(36);
  for (Eigen::Index b = 0; b < 3; ++b) drift.segment<6>(12 * b) = at.twists.segment<6>(6 * b);
  const auto rate = frame.change(at, drift);
  EXPECT_LT((rate.p_WF - at.v_WF).norm(), 1e-14);
  EXPECT_LT((rate.R_WF - cross_matrix(at.w_WF) * at.R_WF).norm(), 1e-14);
  EXPECT_LT((rate.z - at.z_dot).norm(), 1e-14);
}

// The parts displaced and turned as one, past half a turn where quaternions change sign.
TEST(FemFloatingFrameRigid, MovesWithARigidMotionOfAllParts) {
  const MotionSet begin = start_of_three_parts();
  const FloatingFrame frame(begin, {0.5, 0.25, 0.25}, Eigen::Vector3d::Zero());
  const Eigen::Vector3d shift(3.0, -1.0, 2.0);
  for (double angle : {0.4, 2.0, 3.5, 6.0}) {
    const Eigen::Quaterniond turn = rotation(angle * Eigen::Vector3d(1, 2, -2) / 3.0);
    MotionSet motions = begin;
    for (Motion& motion : motions) {
      motion.p_WP = shift + turn * motion.p_WP;
      motion.q_WP = turn * motion.q_WP;
    }
    const auto at = frame.place(motions);
    EXPECT_LT((at.R_WF - turn.toRotationMatrix()).norm(), 1e-14);
    EXPECT_LT((at.p_WF - shift - turn * frame.reference()).norm(), 1e-14);
    EXPECT_LT(at.z.norm(), 1e-14);
  }
}

}  // namespace
}  // namespace tandem::fem

// Interface Jacobians that are kept and corrected from what the evaluations show.
#include "protocol/schemes/jacobian_block.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace tandem {
namespace {

const SimTime kStep = sim_time_from_seconds(1e-3);

/// Numbers without order, the same every time.
Eigen::MatrixXd waves(Eigen::Index rows, Eigen::Index columns, double phase) {
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) {
      m(r, c) = std::sin(phase + 1.7 * static_cast<double>(r * r) + 2.9 * static_cast<double>(c));
    }
  }
  return m;
}

JacobianBlock learning_block(const Eigen::MatrixXd& taken, std::size_t secants) {
  JacobianBlock block(Refresh::Broyden, 1, secants);
  EXPECT_TRUE(block.begin_step(kStep));
  block.take(taken);
  return block;
}

// All secants that are kept hold, whatever the weights: round-off of sums of twelve numbers.
TEST(JacobianBlock, MapsTheLastSecantsRight) {
  const Eigen::MatrixXd L = waves(6, 12, 0.3);
  const Eigen::MatrixXd in = waves(12, 5, 4.0);
  const Eigen::VectorXd weights = waves(12, 1, 9.0).cwiseAbs() + Eigen::VectorXd::Ones(12);
  JacobianBlock block = learning_block(waves(6, 12, 0.8), 5);
  for (Eigen::Index k = 0; k < in.cols(); ++k) {
    EXPECT_TRUE(block.learn(in.col(k), L * in.col(k), weights));
  }
  EXPECT_LT((block.value() * in - L * in).norm(), 1e-12);
  EXPECT_GT((block.value() - L).norm(), 0.1) << "five secants cannot tell twelve columns";
}

// As many secants as columns tell all of an affine side.
TEST(JacobianBlock, LearnsAnAffineSideFromAsManySecantsAsItHasInputs) {
  const Eigen::MatrixXd L = waves(6, 12, 0.3);
  const Eigen::MatrixXd in = waves(12, 12, 4.0) + 3.0 * Eigen::MatrixXd::Identity(12, 12);
  JacobianBlock block = learning_block(Eigen::MatrixXd::Zero(6, 12), 12);
  for (Eigen::Index k = 0; k < in.cols(); ++k) {
    block.learn(in.col(k), L * in.col(k), Eigen::VectorXd::Ones(12));
  }
  EXPECT_LT((block.value() - L).norm(), 1e-10);
}

// A body whose ports turn with it has the derivative R L Rᵀ, with the rotation of each port on its
// rows and columns; secants turn likewise: the next correction does not spoil what they say.
TEST(JacobianBlock, TurnsWithThePorts) {
  const Eigen::MatrixXd L = waves(12, 24, 0.3);
  JacobianBlock block = learning_block(waves(12, 24, 0.8), 3);
  MotionSet begin(2);
  begin[0].q_WP = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 2) / 3.0);
  begin[1].q_WP = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitY());
  block.turn_with(begin);
  const Eigen::MatrixXd in = waves(24, 3, 4.0);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(24);
  block.learn(in.col(0), L * in.col(0), ones);
  block.learn(in.col(1), L * in.col(1), ones);

  const Eigen::Quaterniond turn[2] = {
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())),
      Eigen::Quaterniond(Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitX()))};
  MotionSet end = begin;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(12, 12);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(24, 24);
  for (Eigen::Index p = 0; p < 2; ++p) {
    const auto at = static_cast<std::size_t>(p);
    end[at].q_WP = turn[at] * begin[at].q_WP;
    for (Eigen::Index k = 0; k < 2; ++k) {
      rows.block<3, 3>(6 * p + 3 * k, 6 * p + 3 * k) = turn[at].toRotationMatrix();
    }
    for (Eigen::Index k = 0; k < 4; ++k) {
      columns.block<3, 3>(12 * p + 3 * k, 12 * p + 3 * k) = turn[at].toRotationMatrix();
    }
  }
  const Eigen::MatrixXd expected = rows * block.value() * columns.transpose();
  block.turn_with(end);
  EXPECT_LT((block.value() - expected).norm(), 1e-13);
  block.learn(columns * in.col(2), rows * L * in.col(2), ones);
  EXPECT_LT((block.value() * columns * in - rows * L * in).norm(), 1e-12);
}

TEST(JacobianBlock, AutomaticAsksOnceWhereTheSideTakesMicroStepsAndElseEveryStep) {
  for (const bool micro : {false, true}) {
    JacobianBlock block(Refresh::Automatic, 1, 3);
    const std::int64_t n = micro ? 4 : 1;
    EXPECT_TRUE(block.begin_step(kStep, n));
    block.take(waves(6, 12, 0.3));
    EXPECT_EQ(block.begin_step(kStep, n), !micro);
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(12);
    EXPECT_EQ(block.learn(ones, Eigen::VectorXd::Ones(6), ones), micro);
    EXPECT_TRUE(block.begin_step(2 * kStep, n)) << "it belongs to the step's length";
  }
}

}  // namespace
}  // namespace tandem

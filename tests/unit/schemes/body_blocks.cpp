// The interface Jacobian of several flexible bodies.
#include "protocol/schemes/body_blocks.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tandem {
namespace {

const SimTime kMacroStep = sim_time_from_seconds(1e-3);

/// Three ports: the first and the last belong to body 0, the one between to body 1.
std::vector<PortInfo> interleaved_ports() {
  return {{.name = "a", .length_m = 1.0, .body = 0},
          {.name = "b", .length_m = 1.0, .body = 1},
          {.name = "c", .length_m = 1.0, .body = 0}};
}

Eigen::MatrixXd without_order(Eigen::Index rows, Eigen::Index columns, double phase) {
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) {
      m(r, c) = std::sin(phase + 1.3 * static_cast<double>(r * r) + 2.3 * static_cast<double>(c));
    }
  }
  return m;
}

/// Rows of ports 0 and 2 of three.
Eigen::VectorXd of_first_body(const Eigen::VectorXd& all) {
  const Eigen::Index n = all.size() / 3;
  Eigen::VectorXd own(2 * n);
  own << all.head(n), all.tail(n);
  return own;
}

// Whatever is taken and learned, ports of different bodies do not feel each other.
TEST(BodyBlocks, HaveNothingBetweenBodies) {
  BodyBlocks blocks(interleaved_ports(), Refresh::Broyden, 1, 5);
  EXPECT_TRUE(blocks.begin_step(kMacroStep, 1));
  blocks.take(without_order(18, 36, 0.1));
  EXPECT_TRUE(blocks.learn(without_order(36, 1, 0.4), without_order(18, 1, 0.9),
                           Eigen::VectorXd::Ones(36)));
  const Eigen::MatrixXd& L = blocks.value();
  EXPECT_EQ((L.block<6, 12>(0, 12).norm()), 0.0);
  EXPECT_EQ((L.block<6, 12>(6, 0).norm()), 0.0);
  EXPECT_EQ((L.block<6, 12>(6, 24).norm()), 0.0);
  EXPECT_EQ((L.block<6, 12>(12, 12).norm()), 0.0);
  EXPECT_GT((L.block<6, 12>(0, 24).norm()), 1.0);
}

// Each body's block is what a side of that body alone would learn, bit for bit.
TEST(BodyBlocks, LearnAsEachBodyAlone) {
  BodyBlocks blocks(interleaved_ports(), Refresh::Broyden, 1, 5);
  JacobianBlock alone(Refresh::Broyden, 1, 5);
  EXPECT_TRUE(blocks.begin_step(kMacroStep, 1));
  EXPECT_TRUE(alone.begin_step(kMacroStep));
  const Eigen::MatrixXd taken = without_order(18, 36, 0.1);
  Eigen::MatrixXd own(12, 24);
  own << taken.block<6, 12>(0, 0), taken.block<6, 12>(0, 24), taken.block<6, 12>(12, 0),
      taken.block<6, 12>(12, 24);
  blocks.take(taken);
  alone.take(own);
  const Eigen::VectorXd weights = without_order(36, 1, 3.0).cwiseAbs();
  for (int k = 0; k < 3; ++k) {
    const Eigen::VectorXd in = without_order(36, 1, 0.4 + k);
    const Eigen::VectorXd out = without_order(18, 1, 0.9 + k);
    blocks.learn(in, out, weights);
    alone.learn(of_first_body(in), of_first_body(out), of_first_body(weights));
  }
  EXPECT_EQ((blocks.value().block<6, 12>(0, 24)), (alone.value().block<6, 12>(0, 12)));
  EXPECT_EQ((blocks.value().block<6, 12>(12, 0)), (alone.value().block<6, 12>(6, 0)));
}

}  // namespace
}  // namespace tandem

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "fem_process/sides/make_side.h"
#include "tests/support/fem_support.h"

namespace tandem::fem::testing {

inline Motion moved(Motion m, int coordinate, double amount) {
  const Eigen::Vector3d change = amount * Eigen::Vector3d::Unit(coordinate % 3);
  if (coordinate < 3) m.p_WP += change;
  if (coordinate >= 3 && coordinate < 6) m.q_WP = rotation(change) * m.q_WP;
  if (coordinate >= 6 && coordinate < 9) m.v_WP += change;
  if (coordinate >= 9) m.w_WP += change;
  return m;
}

/// Largest difference between the reported Jacobian and central differences, each column relative
/// to its block of three columns' largest entry per row kind (force or torque).
inline double jacobian_error(Params params, int micro_steps, double amount) {
  const SimTime h = params.micro_step;
  const auto owned = make_body(std::move(params));
  FemSide& body = *owned;
  body.initialize(pair_motion(0.0));
  // A few steps first, so that the bar is deformed and the port nodes carry forces.
  double t = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double next = t + to_seconds(h);
    const auto first = body.advance(request(pair_motion(t), pair_motion(next), h));
    EXPECT_EQ(first.outcome, Outcome::Done) << first.message;
    t = next;
  }
  body.checkpoint();
  const SimTime H = micro_steps * h;
  StepRequest<MotionSet> asked =
      request(pair_motion(t), pair_motion(t + to_seconds(H)), H, /*linearize=*/true);
  const StepResult<WrenchSet> result = body.advance(asked);
  EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
  EXPECT_TRUE(result.jacobian.has_value());
  InterfaceJacobian differences(12, 24);
  asked.linearize = false;
  // Two central differences, of which the square of the amount drops out.
  for (int column = 0; column < 24; ++column) {
    const auto difference = [&](double by) -> Eigen::VectorXd {
      Eigen::VectorXd ends[2];
      for (int side = 0; side < 2; ++side) {
        body.rollback();
        StepRequest<MotionSet> varied = asked;
        const auto port = static_cast<std::size_t>(column / 12);
        varied.input.end[port] = moved(asked.input.end[port], column % 12, side == 0 ? -by : by);
        ends[side] = stack(body.advance(varied).output);
      }
      return (ends[1] - ends[0]) / (2 * by);
    };
    differences.col(column) = (4.0 * difference(amount) - difference(2.0 * amount)) / 3.0;
  }
  double worst = 0.0;
  for (int row = 0; row < 12; row += 3) {
    for (int column = 0; column < 24; column += 3) {
      const double scale = std::max(differences.block<3, 3>(row, column).cwiseAbs().maxCoeff(),
                                    1e-6 * differences.cwiseAbs().maxCoeff());
      const double error =
          (result.jacobian->block<3, 3>(row, column) - differences.block<3, 3>(row, column))
              .cwiseAbs()
              .maxCoeff();
      worst = std::max(worst, error / scale);
    }
  }
  return worst;
}

}  // namespace tandem::fem::testing

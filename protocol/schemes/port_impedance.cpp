#include "protocol/schemes/port_impedance.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>

#include "protocol/contract/error.h"
#include "protocol/schemes/residual_floor.h"

namespace tandem {
namespace {

constexpr double kStraightTolerance = 1e-12;
constexpr std::int32_t kMostPasses = 30;
constexpr std::int32_t kPassesWithoutGain = 4;

/// Rows of the twists in a Jacobian with 12 rows per port.
Eigen::MatrixXd twist_rows(const Eigen::MatrixXd& jacobian) {
  Eigen::MatrixXd rows(jacobian.rows() / 2, jacobian.cols());
  for (Eigen::Index i = 0; 12 * i < jacobian.rows(); ++i) {
    rows.middleRows<6>(6 * i) = jacobian.middleRows<6>(12 * i + 6);
  }
  return rows;
}

}  // namespace

ImpedanceEnd PortImpedance::advance(SimTime H, const WrenchSet& begin, const Eigen::VectorXd& a,
                                    const Eigen::MatrixXd& Z, const WrenchSet& guess,
                                    MbsSide& mbs) {
  ImpedanceEnd end{.result = {}, .applied = guess};
  bool linearize = block_.begin_step(H);
  MotionSet last_motions;
  Eigen::VectorXd last_lambda;
  const auto norm_N = [this](const Eigen::VectorXd& x) {
    return wrench_norm_N(unstack_wrenches(x), ports_);
  };
  ResidualFloor floor(kPassesWithoutGain, 0.0);
  floor.begin_step(wrench_norm_N(begin, ports_));
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) mbs.rollback();
    end.result = mbs.advance({.step = H, .input = {begin, end.applied}, .linearize = linearize});
    end.evaluations = k;
    if (end.result.outcome == Outcome::Failed) return end;
    const Eigen::VectorXd lambda = stack(end.applied);
    if (k > 1) {
      (void)block_.learn(lambda - last_lambda, difference(last_motions, end.result.output));
    }
    if (linearize) {
      require(end.result.jacobian.has_value(),
              "coupling: the multibody side has no interface Jacobian, which tlm and "
              "retained_inertia need. Use implicit or explicit_serial without them.");
      block_.take(*end.result.jacobian);
    }
    const Eigen::VectorXd damped = Z * twists(end.result.output);
    const Eigen::VectorXd residual = a - damped - lambda;
    const double scale_N = std::max({norm_N(a), norm_N(damped), norm_N(lambda)});
    const double limit_N = kStraightTolerance * scale_N;
    if (norm_N(residual) <= limit_N || floor.reached(norm_N(residual), scale_N, 0.0)) return end;
    if (k == kMostPasses) {
      end.result.outcome = Outcome::NotConverged;
      end.result.message = fmt::format(
          "the impedance at the ports of the multibody side leaves {:.3g} N after {} evaluations: "
          "a "
          "joint limit switches within the step. Lower run.macro_step_s.",
          norm_N(residual), k);
      return end;
    }
    const Eigen::Index n = residual.size();
    const Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n) + Z * twist_rows(block_.value());
    last_lambda = lambda;
    last_motions = end.result.output;
    end.applied = unstack_wrenches(lambda + matrix.partialPivLu().solve(residual));
    linearize = k % kPassesWithoutGain == 0;
  }
}

}  // namespace tandem

#include "protocol/schemes/jacobian_block.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>
#include <vector>

namespace tandem {
namespace {

/// A secant whose part that is new to the newer ones is smaller says more about round-off.
constexpr double kFilter = 1e-4;

/// Turns rows of vectors, those of every port by its rotation.
template <class Values>
void turn_rows(const std::vector<Eigen::Matrix3d>& turns, Values& values) {
  const Eigen::Index rows = values.rows() / static_cast<Eigen::Index>(turns.size());
  for (Eigen::Index row = 0; row < values.rows(); row += 3) {
    const Eigen::Matrix3d& turn = turns[static_cast<std::size_t>(row / rows)];
    values.template middleRows<3>(row) = (turn * values.template middleRows<3>(row)).eval();
  }
}

}  // namespace

bool JacobianBlock::begin_step(SimTime H, std::int64_t micro_steps) {
  const bool other_step = std::exchange(step_, H) != H;
  ++age_;
  learns_ = refresh_ == Refresh::Broyden || (refresh_ == Refresh::Automatic && micro_steps > 1);
  if (value_.size() == 0 || other_step) return true;
  if (refresh_ == Refresh::EveryNSteps) return age_ >= every_steps_;
  return !learns_;
}

void JacobianBlock::turn_with(const MotionSet& motions) {
  const MotionSet stood = std::exchange(stood_, motions);
  if (value_.size() == 0 || stood.size() != motions.size()) return;
  std::vector<Eigen::Matrix3d> turns;
  for (std::size_t p = 0; p < motions.size(); ++p) {
    turns.push_back((motions[p].q_WP * stood[p].q_WP.conjugate()).normalized().toRotationMatrix());
  }
  turn_rows(turns, value_);
  Eigen::MatrixXd columns = value_.transpose();
  turn_rows(turns, columns);
  value_ = columns.transpose();
  for (Secant& secant : secants_) {
    turn_rows(turns, secant.in);
    turn_rows(turns, secant.out);
  }
}

void JacobianBlock::take(Eigen::MatrixXd jacobian) {
  value_ = std::move(jacobian);
  age_ = 0;
  secants_.clear();
}

bool JacobianBlock::learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out,
                          const Eigen::VectorXd& weights) {
  const Eigen::VectorXd root = weights.cwiseSqrt();
  const double size = root.cwiseProduct(d_in).norm();
  if (!learns_ || !(size > 0.0)) return false;
  secants_.push_front({d_in / size, d_out / size});
  if (secants_.size() > most_secants_) secants_.pop_back();
  std::vector<Eigen::VectorXd> directions;
  for (const Secant& secant : secants_) {
    Eigen::VectorXd q = root.cwiseProduct(secant.in);
    for (int pass = 0; pass < 2; ++pass) {
      for (const Eigen::VectorXd& newer : directions) q -= newer.dot(q) * newer;
    }
    const double part = q.norm();
    if (part < kFilter) continue;
    q /= part;
    value_ += (secant.out - value_ * secant.in) * (root.cwiseProduct(q).transpose() / part);
    directions.push_back(std::move(q));
  }
  return true;
}

bool JacobianBlock::learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out) {
  return learn(d_in, d_out, Eigen::VectorXd::Ones(d_in.size()));
}

}  // namespace tandem

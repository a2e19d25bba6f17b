#include "protocol/schemes/jacobian_block.h"

#include <utility>

namespace tandem {

bool JacobianBlock::begin_step(SimTime H) {
  const bool other_step = std::exchange(step_, H) != H;
  ++age_;
  if (value_.size() == 0 || other_step || refresh_ == Refresh::EveryStep) return true;
  return refresh_ == Refresh::EveryNSteps && age_ >= every_steps_;
}

void JacobianBlock::take(Eigen::MatrixXd jacobian) {
  value_ = std::move(jacobian);
  age_ = 0;
}

bool JacobianBlock::learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out) {
  const double size2 = d_in.squaredNorm();
  if (refresh_ != Refresh::Broyden || !(size2 > 0.0)) return false;
  value_ += (d_out - value_ * d_in) * (d_in.transpose() / size2);
  return true;
}

}  // namespace tandem

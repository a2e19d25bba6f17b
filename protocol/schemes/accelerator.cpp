#include "protocol/schemes/accelerator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tandem {

void RelaxedIteration::begin_step(const Eigen::VectorXd& weights, bool /*last_accepted*/) {
  weights_ = weights;
  factor_ = first_factor_;
  r_.resize(0);
}

void RelaxedIteration::observe(const Eigen::VectorXd& x, const Eigen::VectorXd& r) {
  if (aitken_ && r_.size() > 0) {
    const Eigen::VectorXd change = weights_.cwiseProduct(r - r_);
    const double denominator = change.squaredNorm();
    if (denominator > 0.0) {
      const double next = -factor_ * weights_.cwiseProduct(r_).dot(change) / denominator;
      factor_ = std::copysign(std::clamp(std::abs(next), 1e-4, 2.0), next);
    }
  }
  x_ = x;
  r_ = r;
}

std::unique_ptr<Accelerator> make_accelerator(const CouplingParams& params) {
  using Kind = QuasiNewton::Kind;
  const QuasiNewtonParams& qn = params.quasi_newton;
  switch (params.relaxation) {
    case Relaxation::Constant:
      return std::make_unique<RelaxedIteration>(false, params.relaxation_factor);
    case Relaxation::Aitken:
      return std::make_unique<RelaxedIteration>(true, params.relaxation_factor);
    case Relaxation::Anderson:
      return std::make_unique<QuasiNewton>(Kind::Ils, 0, qn.filter, params.relaxation_factor);
    case Relaxation::IqnIls:
      return std::make_unique<QuasiNewton>(Kind::Ils, qn.reused_steps, qn.filter,
                                           params.relaxation_factor);
    case Relaxation::IqnImvj:
      return std::make_unique<QuasiNewton>(Kind::Imvj, 0, qn.filter, params.relaxation_factor);
  }
  throw std::logic_error("relaxation without an accelerator");
}

}  // namespace tandem

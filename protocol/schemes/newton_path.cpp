#include "protocol/schemes/newton_path.h"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

/// Growth of the residual in one step that is not gone on from.
constexpr double kBlownUp = 10.0;

/// Halved so often, a step is below a hundredth.
constexpr std::int32_t kMostTurns = 8;

/// What a whole step has to leave of the residual at most, or the next one is halved.
constexpr double kRound = 0.5;

}  // namespace

bool NewtonPath::turns_back(double residual_N) {
  linearise_ = false;
  if (!(residual_N > kBlownUp * residual_N_)) return false;
  linearise_ = !linearised_there_;
  if (linearised_there_) part_ *= 0.5;
  lambda_ = linearise_ ? last_ : unstack_wrenches(stack(last_) + part_ * delta_);
  return true;
}

bool NewtonPath::turns_back_from_astray() {
  const bool begun = std::isfinite(residual_N_);
  if (!begun || astray_ == kMostTurns) return false;
  ++astray_;
  return turns_back(std::numeric_limits<double>::infinity());
}

void NewtonPath::linearised(double residual_N) {
  const double ratio = residual_N / linearised_N_;
  // A part p of a step leaves 1 − p where the linearisation holds: then whole steps are due again.
  const bool as_expected = ratio <= std::pow(1.0 - 0.9 * part_, steps_);
  const double enough = std::max(kRound, std::pow(1.0 - 0.5 * part_, steps_));
  if (as_expected) {
    part_ = 1.0;
  } else if (ratio > enough) {
    part_ *= 0.5;
  }
  linearised_N_ = residual_N;
  linearised_here_ = true;
  steps_ = 0;
}

void NewtonPath::go(const Eigen::VectorXd& delta, double residual_N) {
  delta_ = delta;
  last_ = lambda_;
  residual_N_ = residual_N;
  lambda_ = unstack_wrenches(stack(last_) + part_ * delta_);
  linearised_there_ = linearised_here_;
  linearised_here_ = false;
  ++steps_;
}

}  // namespace tandem

#include "protocol/schemes/residual_floor.h"

#include <algorithm>

namespace tandem {
namespace {

constexpr double kMostRoundOff = 1e-10;
constexpr double kMostRoundings = 100.0;
constexpr double kMostPoseRoundings = 4.0;
/// A residual that wavers reaches twice what it was seen at.
constexpr double kWavering = 2.0;
/// Part of what the inner solver leaves below which a residual need not be watched.
constexpr double kWellBelow = 0.1;
/// So that one odd macro step does not stay the measure of all.
constexpr double kFading = 0.95;

}  // namespace

void ResidualFloor::begin_step(double wrench_N) {
  idle_ = 0;
  smallest_N_ = 0.0;
  scale_N_ = largest_N_ = std::max(largest_N_, wrench_N);
  floor_N_ *= kFading;
}

bool ResidualFloor::reached(double residual_N, double wrench_N, double round_off_N, double pose_N,
                            double solver_N) {
  scale_N_ = std::max({scale_N_, residual_N, wrench_N});
  const bool first = smallest_N_ == 0.0;
  if (first || residual_N < 0.5 * smallest_N_) {
    idle_ = 0;
    smallest_N_ = residual_N;
  } else {
    ++idle_;
  }
  if (residual_N <= kWellBelow * solver_N) return true;
  if (residual_N <= solver_N && idle_ >= patience_) return true;
  const double most_N = std::max({negligible_N_, kMostRoundOff * scale_N_,
                                  kMostRoundings * round_off_N, kMostPoseRoundings * pose_N});
  if (residual_N > most_N) return false;
  if (residual_N <= floor_N_ && !first) return true;
  if (idle_ < patience_ || residual_N > kWavering * smallest_N_) return false;
  floor_N_ = std::max(floor_N_, kWavering * residual_N);
  return true;
}

}  // namespace tandem

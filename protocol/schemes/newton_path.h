#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <utility>

#include "protocol/contract/port.h"

namespace tandem {

/// The wrenches through which Newton's iteration of a macro step goes: λ ← λ + p δλ with the part
/// p ≤ 1 of its step.
///
/// Near the solution p is 1. Steps that do not lower the residual from one linearisation to the
/// next go round between pieces of a law (touching or not, stick or slip): they are halved. A
/// residual that has blown up is no place to go on from: on a light body between stiff ones a
/// wrench that is off by a few newtons is a motion that is off by centimetres. Then the path goes
/// back, to linearise where it came from, or, where it did, to half the way.
class NewtonPath {
 public:
  explicit NewtonPath(WrenchSet start) : lambda_(std::move(start)) {}

  /// Where the sides are to be evaluated.
  [[nodiscard]] const WrenchSet& lambda() const { return lambda_; }
  /// λ of the last evaluation that was gone on from.
  [[nodiscard]] const WrenchSet& last() const { return last_; }

  /// Judges an evaluation at lambda(). True: its residual has blown up, lambda() is another one and
  /// nothing else is to be taken from it; linearise() tells whether both sides are to be linearised
  /// there.
  [[nodiscard]] bool turns_back(double residual_N);
  [[nodiscard]] bool linearise() const { return linearise_; }

  /// As where a residual has blown up. There may be no other solution than one that turns a port by
  /// so much, so this is done kMostTurns times in a macro step. True: lambda() is another one.
  [[nodiscard]] bool turns_back_from_astray();

  /// Both sides have been linearised at lambda(), whose residual this is.
  void linearised(double residual_N);
  /// Goes on by Newton's step δλ.
  void go(const Eigen::VectorXd& delta, double residual_N);
  /// Residual of the evaluation gone on from last (N).
  [[nodiscard]] double residual_N() const { return residual_N_; }

 private:
  WrenchSet lambda_, last_;
  Eigen::VectorXd delta_;
  double part_ = 1.0;
  double residual_N_ = std::numeric_limits<double>::infinity();
  double linearised_N_ = std::numeric_limits<double>::infinity();
  std::int32_t steps_ = 0;         ///< since the last linearisation
  std::int32_t astray_ = 0;        ///< ports have been led astray so often
  bool linearised_here_ = false;   ///< at lambda()
  bool linearised_there_ = false;  ///< at last()
  bool linearise_ = false;
};

}  // namespace tandem

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/schemes/coupling_params.h"

namespace tandem {

/// Accelerates a fixed-point iteration x ← G(x) with residuals r = G(x) − x, macro step by macro
/// step. Norms are of W r with the weights W of the unknowns, so that forces and torques, or
/// wrenches and motions, can stand in one vector.
class Accelerator {
 public:
  virtual ~Accelerator() = default;

  /// Begins the iteration of a macro step. `last_accepted`: the run went on from the macro step
  /// begun before, so that what was learnt in it may be kept; else it was rolled back.
  virtual void begin_step(const Eigen::VectorXd& weights, bool last_accepted) = 0;

  /// Takes notice of an evaluation.
  virtual void observe(const Eigen::VectorXd& x, const Eigen::VectorXd& r) = 0;

  /// The x to evaluate next, after observe().
  [[nodiscard]] virtual Eigen::VectorXd next() = 0;
};

/// x + ω r with ω constant, or Aitken's Δ² factor ω ← −ω r_old·(r − r_old)/‖r − r_old‖², kept in
/// size within [1e-4, 2]: an accidental near equality of two residuals must not throw the iterate
/// out of the region where the sides converge. [Irons & Tuck 1969; Küttler & Wall 2008, eq. 44]
class RelaxedIteration final : public Accelerator {
 public:
  RelaxedIteration(bool aitken, double factor) : aitken_(aitken), first_factor_(factor) {}
  void begin_step(const Eigen::VectorXd& weights, bool last_accepted) override;
  void observe(const Eigen::VectorXd& x, const Eigen::VectorXd& r) override;
  [[nodiscard]] Eigen::VectorXd next() override { return x_ + factor_ * r_; }

 private:
  bool aitken_;
  double first_factor_;
  double factor_ = 1.0;
  Eigen::VectorXd weights_, x_, r_;
};

/// Newton's iteration on r(x) = 0 with a secant approximation of the inverse Jacobian. With the
/// columns V = Δr and W = Δ(x + r) of successive evaluations
///   IQN-ILS:   x ← x + r + W α,                       α = argmin ‖V α + r‖ ;
///   IQN-IMVJ:  x ← x + r − J r + (W − J V) α,         J ← J + (W − J V) V⁺ after the macro step.
/// IQN-ILS keeps the columns of the last accepted macro steps, newest first; without any it is
/// Anderson's acceleration. IQN-IMVJ has its whole past in J and keeps none. A column whose part
/// that is new to the newer ones is less than `filter` of it is left out (QR decomposition with
/// filter). The first evaluation of a run, with no columns at all, is relaxed by a factor.
/// [Degroote, Bathe & Vierendeels 2009; Lindner et al. 2015; Haelterman et al. 2016 (filter)]
class QuasiNewton final : public Accelerator {
 public:
  enum class Kind { Ils, Imvj };
  QuasiNewton(Kind kind, std::int32_t reused_steps, double filter, double first_factor)
      : kind_(kind), reused_steps_(reused_steps), filter_(filter), first_factor_(first_factor) {}
  void begin_step(const Eigen::VectorXd& weights, bool last_accepted) override;
  void observe(const Eigen::VectorXd& x, const Eigen::VectorXd& r) override;
  [[nodiscard]] Eigen::VectorXd next() override;

 private:
  /// Secant pair.
  struct Column {
    Eigen::VectorXd dr, dx;
  };
  using Columns = std::vector<Column>;  ///< newest last
  /// Columns that passed the filter, and the factors of their scaled dr: W V = Q R.
  struct Basis {
    std::vector<const Column*> columns;
    Eigen::MatrixXd Q, R;
  };
  [[nodiscard]] Basis orthogonalise() const;
  /// Adds `column` to the basis unless it brings nothing new.
  void extend(const Column& column, Basis& basis) const;
  void learn_jacobian();

  /// Evaluations of a macro step after which everything learnt is forgotten: columns that are
  /// differences of round-off, or too old, can keep an iteration from converging. Without a past
  /// not before as many as an affine problem may need.
  static constexpr std::int32_t kPatience = 15;

  Kind kind_;
  std::int32_t reused_steps_;
  double filter_, first_factor_;
  std::int32_t evaluations_ = 0;  ///< in this macro step, since it forgot
  Eigen::VectorXd weights_, x_, r_;
  Columns current_;
  std::vector<Columns> past_;  ///< accepted macro steps, oldest first
  Eigen::MatrixXd jacobian_;   ///< IMVJ; empty = 0
};

[[nodiscard]] std::unique_ptr<Accelerator> make_accelerator(const CouplingParams& params);

}  // namespace tandem

#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fem_process/body/model.h"
#include "fem_process/elements/formulation.h"
#include "fem_process/solvers/linear_solver.h"

namespace tandem::fem {

struct StaticParams {
  std::vector<double> load_factors{1.0};  ///< of all loads and gravity, in this order
  double tolerance = 1e-8;  ///< ‖f_ext − f_int‖₂ ≤ tolerance ‖f_ext‖₂ on free nodes
  int max_iterations = 100;  ///< linear solves for one increment
  bool safeguards = true;    ///< line search and load cutting where plain fails
  double law_time_s = 0.0;   ///< time at which the loads' laws are read
};

/// Throws a Usage error that names the first bad value.
void check(const StaticParams& params);

/// Equilibrium at one load factor.
struct LoadStep {
  double factor = 0.0;
  int iterations = 0;     ///< linear solves, those of given-up attempts included
  int cuts = 0;           ///< how often the increment was halved
  bool searched = false;  ///< whether the line search was needed
  int inverted_elements = 0;
  double residual = 0.0;  ///< ‖f_ext − f_int‖/‖f_ext‖
  Eigen::VectorXd x;      ///< positions (m)
};

struct StaticResult {
  SolveReport report;           ///< NotConverged: the steps before are good
  std::vector<LoadStep> steps;  ///< those that converged
};

/// Static equilibrium f_int(x) = s f_ext of a model under load control: the fixed nodes stay, the
/// load factor s goes through its list, every load step is iterated to equilibrium:
///   K(x) δ = s f_ext − f_int(x),   x ← x + α δ.
/// K is the formulation's own stiffness: with Σ R K Rᵀ this is the plain iteration of [MZ12], which
/// converges linearly and diverges once the stiffening by tension exceeds K; with an exact tangent
/// it is Newton's. α = 1 first. Where that stalls, the increment starts again with a line search
/// for δᵀ(s f_ext − f_int(x + α δ)) = 0 [Crisfield 1991, section 9.2]; where that stalls too, the
/// increment is halved. A tangent that is not positive definite on the way is replaced by
/// Σ R K Rᵀ, which always is. Dead loads. Deterministic.
class StaticAnalysis {
 public:
  /// `model` must outlive the analysis.
  StaticAnalysis(const Model& model, StaticParams params);

  /// `observer` is called with every converged load step.
  [[nodiscard]] StaticResult run(const std::function<void(const LoadStep&)>& observer = {});

 private:
  struct Point {
    Eigen::VectorXd x;
    Eigen::VectorXd residual;  ///< of free nodes (N)
    BlockValues K;
    double norm = 0.0;
    int inverted = 0;
  };
  [[nodiscard]] Point evaluate(Eigen::VectorXd x, double factor) const;
  [[nodiscard]] bool converged(const Point& point, double factor) const;
  SolveReport direction(const Point& point, Eigen::VectorXd& delta);
  [[nodiscard]] Point move(const Point& from, const Eigen::VectorXd& delta, double factor,
                           bool search) const;
  SolveReport iterate(Point& point, double factor, bool search, LoadStep& step);
  SolveReport increment(Point& point, double from, double to, int depth, LoadStep& step);

  const Model& model_;
  StaticParams params_;
  Eigen::VectorXd load_;  ///< at factor 1 (N)
  double load_norm_ = 0.0;
  std::unique_ptr<LinearSolver> solver_;
  std::unique_ptr<const Formulation> definite_;  ///< made when first needed
  bool search_ = false;                          ///< the plain iteration has failed before
};

}  // namespace tandem::fem

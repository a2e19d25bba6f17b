#include "fem_process/reduced/modal_analysis.h"

#include <Spectra/SymGEigsShiftSolver.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "fem_process/matrix/node_vectors.h"
#include "fem_process/solvers/linear_solver.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

/// M of the free nodes, in Spectra's form.
class MassOperator {
 public:
  using Scalar = double;
  explicit MassOperator(const Model& model) : pattern_(model.interior.pattern) {
    for (int source : model.interior.source) {
      values_.push_back(model.mass[static_cast<std::size_t>(source)]);
    }
  }
  [[nodiscard]] Eigen::Index rows() const { return 3 * pattern_.rows(); }
  [[nodiscard]] Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x_in, double* y_out) const {
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(x_in, rows());
    Eigen::Map<Eigen::VectorXd>(y_out, rows()) = (*this)(x);
  }
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& x) const {
    return multiply_scalar(pattern_, values_, x);
  }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

 private:
  const BlockPattern& pattern_;
  std::vector<double> values_;  ///< per block (kg)
};

/// y = (I − Φ Φᵀ M) (K − σ M)⁻¹ x with the known modes Φ.
class ShiftInvert {
 public:
  using Scalar = double;
  ShiftInvert(const Model& model, const MassOperator& M, double shift)
      : M_(M), solver_(make_solver({.kind = SolverKind::Cholmod}, model.interior.pattern)) {
    Eigen::VectorXd f_int;
    BlockValues K;
    model.formulation->evaluate(model.reference(), f_int, K);
    BlockValues A(9 * model.interior.pattern.blocks());
    for (std::size_t b = 0; b < model.interior.source.size(); ++b) {
      Eigen::Map<Block> target = block(A, static_cast<int>(b));
      target = block(K, model.interior.source[b]);
      target.diagonal().array() -= shift * M.values()[b];
    }
    const SolveReport report = solver_->factorize(A);
    if (report.outcome != Outcome::Done) {
      throw Error(ErrorKind::NotSolved,
                  "fem: modes of " + model.mesh.file.string() +
                      ": the shifted stiffness is not positive definite. Check the material and "
                      "the mesh for elements of extreme shape.");
    }
  }
  [[nodiscard]] Eigen::Index rows() const { return M_.rows(); }
  [[nodiscard]] Eigen::Index cols() const { return M_.rows(); }
  /// Spectra's hook; the shift is factorised already.
  void set_shift(const double& /*sigma*/) const {}
  void perform_op(const double* x_in, double* y_out) const {
    Eigen::MatrixXd y = Eigen::Map<const Eigen::VectorXd>(x_in, rows());
    solver_->solve(y, Eigen::VectorXd::Constant(1, y.norm()));
    if (known.cols() > 0) y -= known * (known.transpose() * M_(y.col(0)));
    Eigen::Map<Eigen::VectorXd>(y_out, rows()) = y.col(0);
  }

  Eigen::MatrixXd known;  ///< columns with φᵀ M φ = 1

 private:
  const MassOperator& M_;
  std::unique_ptr<LinearSolver> solver_;
};

/// −1 % of the squared rate at which a sound wave crosses the part: near its lowest eigenvalues,
/// and large beside the round-off of K.
double shift_of(const Model& model) {
  const double length = diagonal_of(model.mesh);
  double fastest = 0.0;
  for (const Material& material : model.materials.list) {
    fastest = std::max(fastest, squared_wave_speed(material));
  }
  return -0.01 * fastest / (length * length);
}

struct Pairs {
  Eigen::VectorXd values;  ///< ω² (1/s²), ascending
  Eigen::MatrixXd vectors;
};

Pairs lanczos(ShiftInvert& inverse, MassOperator& M, int count, double shift) {
  const auto n = static_cast<int>(M.rows());
  const int subspace = std::min(n, std::max(2 * count + 1, 20));
  Spectra::SymGEigsShiftSolver<ShiftInvert, MassOperator, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, M, count, subspace, shift);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-12, Spectra::SortRule::SmallestAlge);
  if (solver.info() != Spectra::CompInfo::Successful) {
    throw Error(ErrorKind::NotSolved,
                "fem: the Lanczos iteration for " + std::to_string(count) +
                    " modes has not converged. Ask for more or fewer modes (fem.analysis.modes).");
  }
  return {solver.eigenvalues(), solver.eigenvectors()};
}

void append(Pairs& pairs, const Pairs& more) {
  const Eigen::Index n = pairs.values.size();
  pairs.values.conservativeResize(n + more.values.size());
  pairs.values.tail(more.values.size()) = more.values;
  pairs.vectors.conservativeResize(more.vectors.rows(), n + more.values.size());
  pairs.vectors.rightCols(more.values.size()) = more.vectors;
}

void sort(Pairs& pairs, Eigen::Index keep) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(pairs.values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return pairs.values(a) < pairs.values(b);
  });
  Pairs sorted{Eigen::VectorXd(keep), Eigen::MatrixXd(pairs.vectors.rows(), keep)};
  for (Eigen::Index i = 0; i < keep; ++i) {
    sorted.values(i) = pairs.values(order[static_cast<std::size_t>(i)]);
    sorted.vectors.col(i) = pairs.vectors.col(order[static_cast<std::size_t>(i)]);
  }
  pairs = std::move(sorted);
}

}  // namespace

Modes lowest_modes(const Model& model, int count) {
  MassOperator M(model);
  require(count >= 1 && count < M.rows(),
          "fem: " + std::to_string(count) + " modes of a model with " + std::to_string(M.rows()) +
              " free displacements. Ask for at least 1 and fewer than that (fem.analysis.modes).");
  const double shift = shift_of(model);
  ShiftInvert inverse(model, M, shift);
  Pairs found = lanczos(inverse, M, count, shift);
  while (found.values.size() + 1 < M.rows()) {
    inverse.known = found.vectors;
    const Pairs next = lanczos(inverse, M, 1, shift);
    // Equal within what the iteration resolves: one more of the highest changes nothing.
    const bool lower = next.values(0) < found.values(count - 1) * (1.0 - 1e-9);
    append(found, next);
    sort(found, found.values.size());
    if (!lower) break;
  }
  sort(found, count);

  Modes modes;
  modes.frequencies_Hz = found.values.cwiseMax(0.0).cwiseSqrt() / (2.0 * M_PI);
  modes.shapes = Eigen::MatrixXd::Zero(3 * model.mesh.nodes(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd shape =
        found.vectors.col(i) / std::sqrt(found.vectors.col(i).dot(M(found.vectors.col(i))));
    // The sign is arbitrary: the largest displacement is made positive.
    Eigen::Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    if (shape(largest) < 0.0) shape = -shape;
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(3 * model.mesh.nodes());
    scatter_add(shape, model.free, whole);
    modes.shapes.col(i) = whole;
  }
  return modes;
}

}  // namespace tandem::fem

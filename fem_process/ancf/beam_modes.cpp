#include "fem_process/ancf/beam_modes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {

Eigen::VectorXd eigenfrequencies_Hz(const BeamSystem& system, const Eigen::VectorXd& q, int count) {
  constexpr std::size_t kMostUnknowns = 2000;
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (!system.mesh().fixed[static_cast<std::size_t>(i / 3)]) free.push_back(i);
  }
  require(free.size() <= kMostUnknowns,
          "fem: eigenfrequencies of beams are computed densely, for at most 2000 unknowns; these "
          "have " +
              std::to_string(free.size()) + ". Lower fem.ancf.chain.elements.");
  ElementArrays elements = system.element_arrays();
  system.kernel().tangents(q, Eigen::VectorXd::Zero(q.size()), 0.0, elements);
  const ColumnPattern& pattern = system.solver().pattern();
  const auto dense = [&](double mass_factor) {
    std::vector<double> values;
    system.assemble(elements, mass_factor, values);
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(q.size(), q.size());
    for (int column = 0; column < pattern.size; ++column) {
      const auto at = static_cast<std::size_t>(column);
      for (int p = pattern.column_start[at]; p < pattern.column_start[at + 1]; ++p) {
        const auto entry = static_cast<std::size_t>(p);
        full(pattern.row[entry], column) = values[entry];
      }
    }
    return Eigen::MatrixXd(full(free, free));
  };
  const Eigen::MatrixXd K = dense(0.0);
  std::fill(elements.tangent.begin(), elements.tangent.end(), 0.0);
  const Eigen::MatrixXd M = dense(1.0);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (K + K.transpose()),
                                                                         M, Eigen::EigenvaluesOnly);
  const Eigen::Index n = std::min<Eigen::Index>(count, solver.eigenvalues().size());
  return solver.eigenvalues().head(n).cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

}  // namespace tandem::fem::ancf

#include "fem_process/reduced/component_modes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem_process/matrix/node_vectors.h"
#include "fem_process/reduced/modal_analysis.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

constexpr double kTwoPi = 2.0 * M_PI;

/// Displacements of all nodes when one rigid part moves in one of its six ways.
Eigen::VectorXd rigid_displacement(const Model& model, const RigidPart& part,
                                   const std::vector<int>& nodes, int way) {
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(way % 3);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * model.mesh.nodes());
  for (int node : nodes) {
    const Eigen::Vector3d r = model.mesh.X[static_cast<std::size_t>(node)] - part.p0;
    u.segment<3>(3 * node) = way < 3 ? axis : axis.cross(r);
  }
  return u;
}

/// All rigid parts moving as one must move the interior with them.
void require_held(const Model& model, const std::vector<RigidPart>& parts,
                  const Eigen::MatrixXd& modes) {
  std::vector<int> all(static_cast<std::size_t>(model.mesh.nodes()));
  std::iota(all.begin(), all.end(), 0);
  const double length = diagonal_of(model.mesh);
  for (int way = 0; way < 6; ++way) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(modes.rows());
    for (std::size_t b = 0; b < parts.size(); ++b) {
      const Eigen::Index at = 6 * static_cast<Eigen::Index>(b);
      sum += modes.col(at + way);
      if (way < 3) continue;
      // Turning about the first part's point moves the other points.
      const Eigen::Vector3d lever = parts[b].p0 - parts[0].p0;
      const Eigen::Vector3d shift = Eigen::Vector3d::Unit(way % 3).cross(lever);
      sum += modes.middleCols<3>(at) * shift;
    }
    const double error =
        (sum - rigid_displacement(model, parts[0], all, way)).cwiseAbs().maxCoeff();
    require(error <= 1e-6 * (way < 3 ? 1.0 : length),
            "fem: " + model.mesh.file.string() +
                ": ports and fixed sets do not hold the body, so it has no static constraint "
                "modes. Give craig_bampton a port of at least three nodes that are not in line.");
  }
}

BlockValues reference_stiffness(const Model& model) {
  Eigen::VectorXd f_int;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f_int, K);
  return K;
}

/// All pairs of a small model by a dense solver: Lanczos is for a few of many.
Modes all_modes(const Model& model, Eigen::Index count) {
  const Eigen::Index n = 3 * static_cast<Eigen::Index>(model.free.size());
  const BlockValues K_all = reference_stiffness(model);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n);
  const BlockPattern& pattern = model.interior.pattern;
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      const int source = model.interior.source[static_cast<std::size_t>(b)];
      const int j = pattern.column[static_cast<std::size_t>(b)];
      K.block<3, 3>(3 * i, 3 * j) = block(K_all, source);
      M.block<3, 3>(3 * i, 3 * j)
          .diagonal()
          .setConstant(model.mass[static_cast<std::size_t>(source)]);
    }
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(K, M);
  require(solver.info() == Eigen::Success,
          "fem: the eigenproblem of " + model.mesh.file.string() +
              " was not solved. Check the material and the mesh for elements of extreme shape.");
  Modes modes{solver.eigenvalues().head(count).cwiseMax(0.0).cwiseSqrt() / kTwoPi,
              Eigen::MatrixXd::Zero(3 * model.mesh.nodes(), count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(modes.shapes.rows());
    scatter_add(solver.eigenvectors().col(i), model.free, whole);
    modes.shapes.col(i) = whole;
  }
  return modes;
}

Modes first_modes(const Model& model, Eigen::Index count) {
  const Eigen::Index n = 3 * static_cast<Eigen::Index>(model.free.size());
  require(count <= n, "fem: " + std::to_string(count) + " modes of a body with " +
                          std::to_string(n) +
                          " free displacements. Lower fem.craig_bampton.modes.");
  if (count == 0) return {Eigen::VectorXd(0), Eigen::MatrixXd(3 * model.mesh.nodes(), 0)};
  return 3 * count > n ? all_modes(model, count) : lowest_modes(model, static_cast<int>(count));
}

}  // namespace

Eigen::MatrixXd constraint_modes(const Model& model, const std::vector<RigidPart>& parts) {
  const BlockPattern& pattern = model.pattern();
  const BlockValues K = reference_stiffness(model);
  BlockValues K_free(9 * model.interior.pattern.blocks());
  for (std::size_t b = 0; b < model.interior.source.size(); ++b) {
    block(K_free, static_cast<int>(b)) = block(K, model.interior.source[b]);
  }
  const auto columns = 6 * static_cast<Eigen::Index>(parts.size());
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(3 * model.mesh.nodes(), columns);
  if (parts.empty()) return modes;
  Eigen::MatrixXd rhs(3 * static_cast<Eigen::Index>(model.free.size()), columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    const RigidPart& part = parts[static_cast<std::size_t>(c / 6)];
    modes.col(c) = rigid_displacement(model, part, part.nodes, static_cast<int>(c % 6));
    rhs.col(c) = -gather(multiply(pattern, K, modes.col(c)), model.free);
  }
  const auto solver = make_solver({.kind = SolverKind::Cholmod}, model.interior.pattern);
  SolveReport report = solver->factorize(K_free);
  if (report.outcome == Outcome::Done) {
    report = solver->solve(rhs, Eigen::VectorXd::Ones(columns));
  }
  if (report.outcome != Outcome::Done || !rhs.allFinite()) rhs.setZero();  // found just below
  for (Eigen::Index c = 0; c < columns; ++c) {
    Eigen::VectorXd mode = modes.col(c);
    scatter_add(rhs.col(c), model.free, mode);
    modes.col(c) = mode;
  }
  require_held(model, parts, modes);
  return modes;
}

BoundaryModes fixed_boundary_modes(const Model& model, const CraigBamptonParams& params) {
  const Eigen::Index n = 3 * static_cast<Eigen::Index>(model.free.size());
  Eigen::Index keep = params.modes;
  Modes modes;
  if (!params.frequency_limit_Hz) {
    modes = first_modes(model, keep);
  } else {
    // Twice as many until one lies beyond the limit.
    const double limit = *params.frequency_limit_Hz;
    for (Eigen::Index count = std::min<Eigen::Index>(8, n);; count = std::min(2 * count, n)) {
      modes = first_modes(model, count);
      if (count == n || modes.frequencies_Hz(count - 1) > limit) break;
    }
    keep = (modes.frequencies_Hz.array() <= limit).count();
  }
  return {kTwoPi * modes.frequencies_Hz.head(keep), modes.shapes.leftCols(keep)};
}

}  // namespace tandem::fem

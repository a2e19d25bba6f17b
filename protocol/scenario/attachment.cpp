#include "protocol/scenario/attachment.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace tandem::scenario {
namespace {

/// What the three ways to write a matrix are called.
struct MatrixNames {
  const char* translation;
  const char* rotation;
  const char* matrix;
};
constexpr MatrixNames kStiffness = {"stiffness_N_per_m", "stiffness_Nm_per_rad",
                                    "stiffness_matrix"};
constexpr MatrixNames kDamping = {"damping_Ns_per_m", "damping_Nms_per_rad", "damping_matrix"};

Matrix6 read_matrix(const Node& bushing, const MatrixNames& names) {
  Matrix6 matrix = Matrix6::Zero();
  if (bushing.has(names.matrix)) {
    const std::vector<double> values = bushing.reals(names.matrix);
    matrix = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data());
  }
  if (bushing.has(names.translation)) {
    matrix.diagonal().head<3>() = bushing.vector3(names.translation);
  }
  if (bushing.has(names.rotation)) {
    matrix.diagonal().tail<3>() = bushing.vector3(names.rotation);
  }
  return matrix;
}

/// Symmetric with no negative eigenvalue once lengths are scaled so that both halves of the
/// diagonal are of one size: signs of eigenvalues do not depend on that.
void check_matrix(const Node& bushing, const MatrixNames& names) {
  const bool parts = bushing.has(names.translation) || bushing.has(names.rotation);
  if (bushing.has(names.matrix) && parts) {
    bushing.fail(names.matrix, fmt::format("stands beside {} or {}. Give the matrix or its "
                                           "diagonal.",
                                           names.translation, names.rotation));
  }
  const char* const key = bushing.has(names.matrix)        ? names.matrix
                          : bushing.has(names.translation) ? names.translation
                                                           : names.rotation;
  Matrix6 matrix = read_matrix(bushing, names);
  const double linear = matrix.topLeftCorner<3, 3>().cwiseAbs().maxCoeff();
  const double angular = matrix.bottomRightCorner<3, 3>().cwiseAbs().maxCoeff();
  Eigen::Matrix<double, 6, 1> scale = Eigen::Matrix<double, 6, 1>::Ones();
  if (linear > 0.0) scale.head<3>().setConstant(1.0 / std::sqrt(linear));
  if (angular > 0.0) scale.tail<3>().setConstant(1.0 / std::sqrt(angular));
  matrix = scale.asDiagonal() * matrix * scale.asDiagonal();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::abs(matrix(i, j) - matrix(j, i)) <= 1e-9) continue;
      bushing.fail(key, fmt::format("is not symmetric: row {}, column {} differs from row {}, "
                                    "column {}. Write the same value in both.",
                                    i + 1, j + 1, j + 1, i + 1));
    }
  }
  const double least =
      Eigen::SelfAdjointEigenSolver<Matrix6>(matrix, Eigen::EigenvaluesOnly).eigenvalues()(0);
  if (least < -1e-9) {
    bushing.fail(key,
                 "has a negative eigenvalue: the bushing would make energy. Make the diagonal "
                 "positive and the couplings smaller.");
  }
}

void check_bushing(const Node& bushing) {
  check_matrix(bushing, kStiffness);
  check_matrix(bushing, kDamping);
  const auto given = [&](const MatrixNames& names) {
    return !read_matrix(bushing, names).isZero(0.0);
  };
  if (given(kStiffness) || given(kDamping)) return;
  bushing.fail("orientation_wxyz",
               "stands in a bushing without stiffness and damping. Add stiffness_N_per_m: [x, y, "
               "z] and stiffness_Nm_per_rad: [x, y, z].");
}

Key bushing_key() {
  Section bushing;
  bushing.title = "Bushing";
  bushing.doc =
      "Stiffness and damping between the port's frame and the least-squares frame of its nodes, "
      "with the elastic centre at the port's origin: diagonals, or full matrices row by row for x, "
      "y, z and the rotations about them.";
  bushing.keys = {
      reals("stiffness_N_per_m", "N/m").count(3).doc_is("Stiffness along the bushing's axes."),
      reals("stiffness_Nm_per_rad", "N·m/rad")
          .count(3)
          .doc_is("Stiffness about the bushing's axes, per component of the rotation vector."),
      reals("stiffness_matrix", "N/m, N, N·m/rad")
          .count(36)
          .doc_is("All of it, in place of the diagonals: symmetric, no negative eigenvalue."),
      reals("damping_Ns_per_m", "N·s/m").count(3).doc_is("Damping along the axes."),
      reals("damping_Nms_per_rad", "N·m·s/rad").count(3).doc_is("Damping about the axes."),
      reals("damping_matrix", "N·s/m, N·s, N·m·s/rad")
          .count(36)
          .doc_is("All of it, in place of the diagonals: symmetric, no negative eigenvalue."),
      reals("orientation_wxyz", "")
          .count(4)
          .of_unit_length()
          .by_default("[1, 0, 0, 0]")
          .doc_is("Rotation q_PB of the bushing's axes against the port's as a quaternion [w, x, "
                  "y, z]."),
  };
  bushing.check = check_bushing;
  return section("bushing", std::move(bushing))
      .must()
      .only_when("attachment", {"bushing"})
      .doc_is("Spring and damper of six directions.");
}

}  // namespace

std::vector<Key> attachment_keys() {
  return {
      choice("attachment", {"rigid", "averaging", "bushing"})
          .by_default("rigid")
          .doc_is("How the nodes hang on the port: every node follows it (RBE2); their weighted "
                  "least-squares frame follows it, the nodes deform and share the wrench (RBE3); "
                  "or a bushing stands between the port and that frame."),
      choice("weights", {"uniform", "area"})
          .only_when("attachment", {"averaging", "bushing"})
          .by_default("uniform")
          .doc_is("Weights of the nodes in that frame, and so their shares of the wrench: equal, "
                  "or the areas of the surface that belong to them, which makes a force a uniform "
                  "traction."),
      bushing_key(),
  };
}

Attachment read_attachment(const Node& port) {
  Attachment attachment;
  const std::string kind = port.text("attachment");
  if (kind == "rigid") return attachment;
  attachment.kind = kind == "bushing" ? AttachmentKind::Bushing : AttachmentKind::Averaging;
  if (port.text("weights") == "area") attachment.weights = NodeWeights::Area;
  if (attachment.kind == AttachmentKind::Averaging) return attachment;
  const Node bushing = port.section("bushing");
  attachment.bushing = {.stiffness = read_matrix(bushing, kStiffness),
                        .damping = read_matrix(bushing, kDamping),
                        .q_PB = bushing.quaternion_wxyz("orientation_wxyz")};
  return attachment;
}

}  // namespace tandem::scenario

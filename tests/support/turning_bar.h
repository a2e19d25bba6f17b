#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <tuple>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem::testing {

/// A steel bar of four unit cubes that turns at a constant rate about its clamped end, against the
/// static centrifugal solution on the same mesh, K u = ω² M X, and closed forms of a turning body.
inline constexpr double kRate_rad_per_s = 20.0;
inline const Eigen::Vector3d kAxisPoint(0.0, 0.5, 0.5);

inline Params bar(const IntegratorParams& integrator, FormulationKind formulation, int order,
                  double turn_rad) {
  static const std::filesystem::path file = temporary_file("turning.inp", box_inp(4));
  Params params;
  params.mesh.file = file;
  params.mesh.order = order;
  params.formulation = formulation;
  params.integrator = integrator;
  params.material = {.young_Pa = 2.1e11, .poisson = 0.3, .density_kg_per_m3 = 7850.0};
  params.damping.beta_s = 1e-3;
  params.ports = {{"hub", {"LEFT"}, kAxisPoint}};
  params.initial_velocity = {.angular_rad_per_s = {0.0, 0.0, kRate_rad_per_s},
                             .about_m = kAxisPoint};
  params.micro_step = sim_time_from_seconds(turn_rad / kRate_rad_per_s);
  return params;
}

using TurningBarKind = std::tuple<IntegratorParams, FormulationKind, int>;
inline const IntegratorParams kHht{.kind = IntegratorKind::Hht, .hht_alpha = -0.3};
inline const IntegratorParams kGeneralised{.kind = IntegratorKind::GeneralisedAlpha,
                                           .rho_infinity = 0.5};
inline const auto kFormulations =
    ::testing::Values(FormulationKind::Corotational, FormulationKind::ConsistentCorotational,
                      FormulationKind::TotalLagrangian);

struct Static {
  double extension_m = 0.0;
  double force_N = 0.0;    ///< m ω² r_c
  double kinetic_J = 0.0;  ///< ½ ω² J
  double elastic_J = 0.0;  ///< ½ u·K u
};

/// From M and K of the reference alone, densely; the shaft along z through a point.
inline Static centrifugal(const Model& model, const Eigen::Vector3d& shaft = kAxisPoint) {
  const double w2 = kRate_rad_per_s * kRate_rad_per_s;
  Eigen::VectorXd arm = model.reference();
  for (Eigen::Index i = 0; i < arm.size(); i += 3) {
    arm.segment<3>(i) -= shaft;
    arm(i + 2) = 0.0;
  }
  const Eigen::VectorXd load = w2 * multiply_scalar(model.pattern(), model.mass, arm);
  Eigen::VectorXd f;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f, K);
  const auto n = 3 * static_cast<Eigen::Index>(model.free.size());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  const BlockPattern& pattern = model.interior.pattern;
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      dense.block<3, 3>(3 * i, 3 * pattern.column[static_cast<std::size_t>(b)]) =
          block(K, model.interior.source[static_cast<std::size_t>(b)]);
    }
  }
  Eigen::VectorXd rhs(n);
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    rhs.segment<3>(3 * static_cast<Eigen::Index>(k)) = load.segment<3>(3 * model.free[k]);
  }
  const Eigen::VectorXd u = dense.ldlt().solve(rhs);
  Static found;
  const std::vector<int>& tip = find_set(model.mesh, {"RIGHT"}).nodes;
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    if (std::find(tip.begin(), tip.end(), model.free[k]) == tip.end()) continue;
    found.extension_m += u(3 * static_cast<Eigen::Index>(k)) / static_cast<double>(tip.size());
  }
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < load.size(); i += 3) force += load.segment<3>(i);
  found.force_N = force.norm();
  found.kinetic_J = 0.5 * arm.dot(load);
  found.elastic_J = 0.5 * u.dot(rhs);
  return found;
}

}  // namespace tandem::fem::testing

#include "fem_process/material/material.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <string>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

constexpr int kTensorRow[6] = {0, 1, 2, 0, 1, 2};
constexpr int kTensorColumn[6] = {0, 1, 2, 1, 2, 0};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// Stresses along the axes to strains along the axes (1/Pa).
Eigen::Matrix3d normal_compliance(const Orthotropic& o) {
  const Eigen::Vector3d& E = o.young_Pa;
  Eigen::Matrix3d S;
  S << 1.0 / E(0), -o.poisson(0) / E(0), -o.poisson(1) / E(0),  //
      -o.poisson(0) / E(0), 1.0 / E(1), -o.poisson(2) / E(1),   //
      -o.poisson(1) / E(0), -o.poisson(2) / E(1), 1.0 / E(2);
  return S;
}

/// Stresses in material axes to stresses in W, both as vectors.
Matrix6d stress_turn(const Eigen::Matrix3d& axes) {
  Matrix6d turn;
  for (int k = 0; k < 6; ++k) {
    Eigen::Matrix3d unit = Eigen::Matrix3d::Zero();
    unit(kTensorRow[k], kTensorColumn[k]) = 1.0;
    unit(kTensorColumn[k], kTensorRow[k]) = 1.0;
    const Eigen::Matrix3d turned = axes * unit * axes.transpose();
    for (int i = 0; i < 6; ++i) turn(i, k) = turned(kTensorRow[i], kTensorColumn[i]);
  }
  return turn;
}

Matrix6d orthotropic_elasticity(const Orthotropic& o) {
  Matrix6d D = Matrix6d::Zero();
  D.topLeftCorner<3, 3>() = normal_compliance(o).inverse();
  D.diagonal().tail<3>() << o.shear_Pa(0), o.shear_Pa(2), o.shear_Pa(1);  // 12, 23, 13
  const Matrix6d turn = stress_turn(o.axes);
  const Matrix6d turned = turn * D * turn.transpose();
  return 0.5 * (turned + turned.transpose());
}

std::string list_of(const Eigen::Vector3d& values) {
  return number(values(0)) + ", " + number(values(1)) + ", " + number(values(2));
}

bool positive(const Eigen::Vector3d& values) {
  return values.allFinite() && (values.array() > 0.0).all();
}

/// |ν_ij| < √(E_i/E_j) for every pair, then the determinant (Sylvester's criterion).
std::string poisson_defect(const Orthotropic& o) {
  if (!o.poisson.allFinite()) return "the orthotropic Poisson's ratios must be finite.";
  const char* const names[] = {"12", "13", "23"};
  for (int k = 0; k < 3; ++k) {
    const int i = k == 2 ? 1 : 0;
    const int j = k == 0 ? 1 : 2;
    const double most = std::sqrt(o.young_Pa(i) / o.young_Pa(j));
    if (std::abs(o.poisson(k)) < most) continue;
    return std::string("Poisson's ratio nu_") + names[k] + " = " + number(o.poisson(k)) +
           " of an orthotropic material must be below sqrt(E_" + names[k][0] + "/E_" + names[k][1] +
           ") = " + number(most) +
           " in size: its strain energy would be negative. nu_ij is the contraction along j in "
           "tension along i; data sheets may give nu_ji = nu_ij E_j/E_i.";
  }
  const Eigen::Vector3d root = o.young_Pa.cwiseSqrt();
  const Eigen::Matrix3d scaled = root.asDiagonal() * normal_compliance(o) * root.asDiagonal();
  const double determinant = scaled.determinant();
  if (determinant > 0.0) return "";
  return "the orthotropic Poisson's ratios nu_12, nu_13, nu_23 = " + list_of(o.poisson) +
         " leave no positive strain energy: 1 - nu_12 nu_21 - nu_23 nu_32 - nu_31 nu_13 - "
         "2 nu_21 nu_32 nu_13 = " +
         number(determinant) + " must be positive. Take smaller ratios.";
}

std::string defect_of(const Orthotropic& o) {
  if (!positive(o.young_Pa)) {
    return "the orthotropic Young's moduli " + list_of(o.young_Pa) +
           " Pa must be positive. Give them in Pa.";
  }
  if (!positive(o.shear_Pa)) {
    return "the orthotropic shear moduli " + list_of(o.shear_Pa) +
           " Pa must be positive. Give them in Pa.";
  }
  if (!((o.axes * o.axes.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9)) {
    return "the material axes must be of unit length and at right angles.";
  }
  return poisson_defect(o);
}

}  // namespace

Matrix6d elasticity(const Material& material) {
  if (material.orthotropic) return orthotropic_elasticity(*material.orthotropic);
  const double nu = material.poisson;
  const double lambda = material.young_Pa * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double mu = material.young_Pa / (2.0 * (1.0 + nu));
  Matrix6d D = Matrix6d::Zero();
  D.topLeftCorner<3, 3>().setConstant(lambda);
  D.diagonal() << lambda + 2.0 * mu, lambda + 2.0 * mu, lambda + 2.0 * mu, mu, mu, mu;
  return D;
}

double squared_wave_speed(const Material& material) {
  const double young =
      material.orthotropic ? material.orthotropic->young_Pa.maxCoeff() : material.young_Pa;
  return young / material.density_kg_per_m3;
}

std::string defect_of(const Material& material) {
  if (!(material.density_kg_per_m3 > 0.0 && std::isfinite(material.density_kg_per_m3))) {
    return "density " + number(material.density_kg_per_m3) +
           " kg/m³ must be positive. Give it in kg/m³.";
  }
  if (material.orthotropic) return defect_of(*material.orthotropic);
  if (!(material.young_Pa > 0.0 && std::isfinite(material.young_Pa))) {
    return "Young's modulus " + number(material.young_Pa) + " Pa must be positive. Give it in Pa.";
  }
  if (!(material.poisson > -1.0 && material.poisson < 0.5)) {
    return "Poisson's ratio " + number(material.poisson) +
           " must be above -1 and below 0.5. Use 0.49 for nearly incompressible rubber.";
  }
  return "";
}

void check(const Material& material) {
  const std::string defect = defect_of(material);
  require(defect.empty(), "fem: " + defect);
}

std::optional<Eigen::Matrix3d> material_axes(const Eigen::Vector3d& axis_1,
                                             const Eigen::Vector3d& in_plane_12) {
  const Eigen::Vector3d normal = axis_1.cross(in_plane_12);
  if (!(normal.norm() > 1e-9 * axis_1.norm() * in_plane_12.norm())) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = axis_1.normalized();
  axes.col(2) = normal.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace tandem::fem

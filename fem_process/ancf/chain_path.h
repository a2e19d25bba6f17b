#pragma once

#include <Eigen/Core>

#include "fem_process/ancf/beam_mesh.h"

namespace tandem::fem::ancf {

/// Local frame of a path: x along it, y the lateral direction, z = x × y. On closed paths z points
/// outward.
struct PathPoint {
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns x, y, z
};

/// A straight line from `start`.
struct LinePath {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  Eigen::Vector3d lateral = Eigen::Vector3d::UnitY();
  double length_m = 0.0;
};

/// The band around two circles of radii R₁, R₂ (those of the centre line), not crossed: run from
/// circle 1 to circle 2, round that, back, round circle 1; s = 0 where it leaves circle 1. Seen
/// along the lateral direction it turns right-handed. With equal centres and radii: a ring.
struct LoopPath {
  Eigen::Vector3d center1 = Eigen::Vector3d::Zero();
  Eigen::Vector3d center2 = Eigen::Vector3d::Zero();
  double radius1_m = 0.0;
  double radius2_m = 0.0;
  Eigen::Vector3d lateral = Eigen::Vector3d::UnitY();

  [[nodiscard]] double length_m() const;
  [[nodiscard]] PathPoint at(double s_m) const;

 private:
  struct Shape;
  [[nodiscard]] Shape shape() const;
};

/// How a chain is laid on its path: elements of equal length whose stress-free length is that of
/// the path over (1 + strain); cross-sections contracted to `lateral_stretch`.
struct Laying {
  int elements = 1;
  double strain = 0.0;
  double lateral_stretch = 1.0;
  Joint joint = Joint::Rigid;
  Eigen::Vector3d pin_axis = Eigen::Vector3d::UnitY();
  bool curved_reference = false;
};
[[nodiscard]] Chain lay(const LinePath& path, const Laying& laying);
[[nodiscard]] Chain lay(const LoopPath& path, const Laying& laying);

}  // namespace tandem::fem::ancf

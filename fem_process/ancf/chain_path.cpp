#include "fem_process/ancf/chain_path.h"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {
namespace {

constexpr double kPi = std::numbers::pi;

PathPoint on_circle(const Eigen::Vector3d& center, double radius, const Eigen::Vector3d& along,
                    const Eigen::Vector3d& up, double angle) {
  const Eigen::Vector3d normal = std::cos(angle) * up + std::sin(angle) * along;
  const Eigen::Vector3d tangent = std::cos(angle) * along - std::sin(angle) * up;
  PathPoint point{.r = center + radius * normal};
  point.axes << tangent, normal.cross(tangent), normal;
  return point;
}

Chain lay_along(double length_m, bool closed, const Laying& laying,
                const std::function<PathPoint(double)>& at) {
  const int n = laying.elements;
  require(n > 0, "fem: a chain needs at least one element.");
  require(length_m > 0.0 && std::isfinite(length_m), "fem: the path of a chain has no length.");
  Chain chain{.closed = closed,
              .joint = laying.joint,
              .pin_axis = laying.pin_axis,
              .curved_reference = laying.curved_reference};
  chain.lengths_m.assign(static_cast<std::size_t>(n), length_m / n / (1.0 + laying.strain));
  const Eigen::Vector3d stretch(1.0 + laying.strain, laying.lateral_stretch,
                                laying.lateral_stretch);
  for (int e = 0; e < n; ++e) {
    for (int end = 0; end < 2; ++end) {
      // The last end of a closed chain is the first one, to the bit.
      const int station = closed ? (e + end) % n : e + end;
      const PathPoint point = at(length_m * station / n);
      chain.ends.push_back({point.r, point.axes * stretch.asDiagonal()});
    }
  }
  return chain;
}

}  // namespace

/// Angles are counted from `up` toward `along`: the runs leave circle 1 at `lean` and return to it
/// at π − lean.
struct LoopPath::Shape {
  Eigen::Vector3d along, up;
  double lean = 0.0;
  double run_m = 0.0;
};

LoopPath::Shape LoopPath::shape() const {
  const Eigen::Vector3d y = lateral.normalized();
  Eigen::Vector3d along = center2 - center1;
  require(std::abs(along.dot(y)) <= 1e-9 * (1.0 + along.norm()),
          "fem: the two circles of a loop do not lie in one plane normal to its lateral axis.");
  const double distance = along.norm();
  Shape shape;
  if (distance == 0.0) {
    require(radius1_m == radius2_m, "fem: a ring has one radius. Make both radii equal.");
    // Any direction across the axis will do: the same one for the same axis.
    Eigen::Index least = 0;
    y.cwiseAbs().minCoeff(&least);
    shape.along = (Eigen::Vector3d::Unit(least) - y(least) * y).normalized();
  } else {
    require(std::abs(radius1_m - radius2_m) < distance,
            "fem: one circle of the loop lies inside the other. Move them apart.");
    shape.along = along / distance;
    shape.lean = std::asin((radius1_m - radius2_m) / distance);
    shape.run_m = distance * std::cos(shape.lean);
  }
  shape.up = shape.along.cross(y);
  return shape;
}

double LoopPath::length_m() const {
  const Shape s = shape();
  return 2.0 * s.run_m + radius2_m * (kPi - 2.0 * s.lean) + radius1_m * (kPi + 2.0 * s.lean);
}

PathPoint LoopPath::at(double s_m) const {
  const Shape s = shape();
  const double arc2 = radius2_m * (kPi - 2.0 * s.lean);
  if (s_m < s.run_m) {
    PathPoint point = on_circle(center1, radius1_m, s.along, s.up, s.lean);
    point.r += s_m * point.axes.col(0);
    return point;
  }
  s_m -= s.run_m;
  if (s_m < arc2) return on_circle(center2, radius2_m, s.along, s.up, s.lean + s_m / radius2_m);
  s_m -= arc2;
  if (s_m < s.run_m) {
    PathPoint point = on_circle(center2, radius2_m, s.along, s.up, kPi - s.lean);
    point.r += s_m * point.axes.col(0);
    return point;
  }
  s_m -= s.run_m;
  return on_circle(center1, radius1_m, s.along, s.up, kPi - s.lean + s_m / radius1_m);
}

Chain lay(const LinePath& path, const Laying& laying) {
  const Eigen::Vector3d x = path.direction.normalized();
  const Eigen::Vector3d z = x.cross(path.lateral).normalized();
  require(z.allFinite() && z.norm() > 0.5, "fem: the lateral axis lies along the line.");
  PathPoint start{.r = path.start};
  start.axes << x, z.cross(x), z;
  return lay_along(path.length_m, false, laying, [&](double s) {
    return PathPoint{path.start + s * x, start.axes};
  });
}

Chain lay(const LoopPath& path, const Laying& laying) {
  return lay_along(path.length_m(), true, laying, [&](double s) { return path.at(s); });
}

}  // namespace tandem::fem::ancf

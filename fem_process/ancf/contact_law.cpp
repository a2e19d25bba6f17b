#include "fem_process/ancf/contact_law.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tandem::fem::ancf {
namespace {

/// The friction of a point under the pressure p with the gradients ∂p/∂r, ∂p/∂v.
void add_friction(const ContactParams& params, const ContactPoint& point,
                  const Eigen::RowVector3d& p_by_r, const Eigen::RowVector3d& p_by_v,
                  bool derivatives, Traction& out) {
  const Eigen::Vector3d& n = point.normal;
  const double normal_slip = n.dot(point.slip);
  const Eigen::Vector3d v_t = point.slip - normal_slip * n;
  const double speed = v_t.norm();
  const double limit = params.friction * out.pressure;
  const bool sticks = params.friction_slope_N_s_per_m3 * speed <= limit;
  const double slope = sticks ? params.friction_slope_N_s_per_m3 : limit / speed;
  out.force -= slope * v_t;
  if (!derivatives) return;
  const Eigen::Matrix3d tangential = Eigen::Matrix3d::Identity() - n * n.transpose();
  out.by_slip = -slope * tangential;
  if (!sticks) {
    const Eigen::Vector3d along = v_t / speed;
    out.by_slip += slope * along * along.transpose();
    out.by_position -= params.friction * along * p_by_r;
    out.by_velocity -= params.friction * along * p_by_v;
  }
  // v_t turns with the normal: its derivative has parts along n, which friction follows too.
  const Eigen::Matrix3d turn = normal_slip * point.normal_by_position +
                               n * (point.normal_by_position.transpose() * point.slip).transpose();
  Eigen::Matrix3d of_turn = slope * turn;
  if (!sticks) {
    const Eigen::Vector3d along = v_t / speed;
    of_turn -= slope * along * (along.transpose() * turn);
  }
  out.by_position += out.by_slip * point.slip_by_position + of_turn;
  out.by_velocity += out.by_slip;
}

}  // namespace

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

bool traction(const ContactParams& params, const ContactPoint& point, bool derivatives,
              Traction& out) {
  const Eigen::Vector3d& n = point.normal;
  const double p =
      params.stiffness_N_per_m3 * point.depth - params.damping_N_s_per_m3 * n.dot(point.approach);
  if (!(p > 0.0)) return false;
  out.pressure = p;
  out.depth = point.depth;
  out.force = p * n;
  const Eigen::RowVector3d p_by_v = -params.damping_N_s_per_m3 * n.transpose();
  const Eigen::RowVector3d p_by_r =
      -params.stiffness_N_per_m3 * n.transpose() -
      params.damping_N_s_per_m3 *
          (point.normal_by_position.transpose() * point.approach).transpose();
  if (derivatives) {
    out.by_position = n * p_by_r + p * point.normal_by_position;
    out.by_velocity = n * p_by_v;
    out.by_slip.setZero();
  }
  if (params.friction > 0.0) add_friction(params, point, p_by_r, p_by_v, derivatives, out);
  return true;
}

std::optional<ContactPoint> on_cylinder(double radius_m, const Eigen::Vector3d& axis,
                                        const Motion& wheel, const Eigen::Vector3d& r,
                                        const Eigen::Vector3d& v) {
  const Eigen::Vector3d d = r - wheel.p_WP;
  const Eigen::Vector3d radial = d - d.dot(axis) * axis;
  const double rho = radial.norm();
  if (rho >= radius_m || rho == 0.0) return std::nullopt;
  ContactPoint point;
  point.depth = radius_m - rho;
  point.normal = radial / rho;
  point.normal_by_position = (Eigen::Matrix3d::Identity() - axis * axis.transpose() -
                              point.normal * point.normal.transpose()) /
                             rho;
  point.approach = v - wheel.v_WP;
  point.slip = point.approach - wheel.w_WP.cross(d);
  point.slip_by_position = -cross_matrix(wheel.w_WP);
  return point;
}

std::optional<ContactPoint> on_plane(const Eigen::Vector3d& origin, const Eigen::Vector3d& normal,
                                     const Eigen::Vector3d& r, const Eigen::Vector3d& v) {
  const double depth = normal.dot(origin - r);
  if (depth <= 0.0) return std::nullopt;
  ContactPoint point;
  point.depth = depth;
  point.normal = normal;
  point.approach = v;
  point.slip = v;
  return point;
}

double seat_angle(const Teeth& teeth, const Motion& wheel, const Eigen::Vector3d& r) {
  const Eigen::Vector3d d_P = wheel.q_WP.conjugate() * (r - wheel.p_WP);
  return std::remainder(std::atan2(d_P.x(), d_P.z()) - teeth.phase_rad,
                        2.0 * std::numbers::pi / teeth.count);
}

bool tooth_force(const Teeth& teeth, double base_radius_m, const Motion& wheel,
                 const Eigen::Vector3d& r, const Eigen::Vector3d& v, ToothForce& out) {
  const Eigen::Vector3d d = r - wheel.p_WP;
  const Eigen::Vector3d axis = wheel.q_WP * Eigen::Vector3d::UnitY();
  const Eigen::Vector3d radial = d - d.dot(axis) * axis;
  const double rho = radial.norm();
  const double engaged =
      std::clamp((base_radius_m + teeth.height_m - rho) / teeth.pin_radius_m, 0.0, 1.0);
  if (engaged == 0.0 || rho == 0.0) return false;
  const double angle = seat_angle(teeth, wheel, r);
  const double depth = rho * std::sin(std::abs(angle)) - teeth.backlash * teeth.pin_radius_m;
  if (depth <= 0.0) return false;
  const double side = angle < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d along = axis.cross(radial / rho);
  const double rate = side * along.dot(v - wheel.v_WP - wheel.w_WP.cross(d));
  const double push = teeth.stiffness_N_per_m * depth + teeth.damping_N_s_per_m * rate;
  if (push <= 0.0) return false;
  out.force = -side * engaged * push * along;
  out.by_position = -engaged * teeth.stiffness_N_per_m * along * along.transpose();
  out.by_velocity = -engaged * teeth.damping_N_s_per_m * along * along.transpose();
  return true;
}

}  // namespace tandem::fem::ancf

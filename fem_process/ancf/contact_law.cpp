#include "fem_process/ancf/contact_law.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem_process/kernels/cross_matrix.h"

namespace tandem::fem::ancf {
namespace {

/// Damping c that comes in over the depth d₀, and its derivative by d.
struct Damping {
  double value = 0.0;
  double by_depth = 0.0;
};
Damping damping_at(double depth, double full, double full_depth) {
  if (depth >= full_depth) return {full, 0.0};
  return {full * (depth / full_depth), full / full_depth};
}

/// The pressure's gradients.
struct PressureSlopes {
  Eigen::RowVector3d by_position, by_velocity;
};

/// The friction of a point under the pressure p, with `slopes` its derivatives too.
void add_friction(const ContactParams& params, const ContactPoint& point,
                  const PressureSlopes* slopes, Traction& out) {
  const Eigen::Vector3d& n = point.normal;
  const double normal_slip = n.dot(point.slip);
  const Eigen::Vector3d v_t = point.slip - normal_slip * n;
  const double speed = v_t.norm();
  const double limit = params.friction * out.pressure;
  const bool sticks = params.friction_slope_N_s_per_m3 * speed <= limit;
  const double slope = sticks ? params.friction_slope_N_s_per_m3 : limit / speed;
  out.force -= slope * v_t;
  out.loss += slope * speed * speed;
  if (slopes == nullptr) return;
  const Eigen::Matrix3d tangential = Eigen::Matrix3d::Identity() - n * n.transpose();
  out.by_slip = -slope * tangential;
  if (!sticks) {
    const Eigen::Vector3d along = v_t / speed;
    out.by_slip += slope * along * along.transpose();
    out.by_position -= params.friction * along * slopes->by_position;
    out.by_velocity -= params.friction * along * slopes->by_velocity;
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

bool traction(const ContactParams& params, const ContactPoint& point, bool derivatives,
              Traction& out) {
  const Eigen::Vector3d& n = point.normal;
  const Damping c = damping_at(point.depth, params.damping_N_s_per_m3, params.damping_depth_m);
  const double leaving = n.dot(point.approach);  // −d'
  const double elastic = params.stiffness_N_per_m3 * point.depth;
  const double p = elastic - c.value * leaving;
  if (!(p > 0.0)) {
    // Leaves faster than the damper lets the spring follow: the damper takes what the spring gives.
    out = {.depth = point.depth, .stored = 0.5 * elastic * point.depth, .loss = elastic * leaving};
    return true;
  }
  out.pressure = p;
  out.depth = point.depth;
  out.force = p * n;
  out.stored = 0.5 * params.stiffness_N_per_m3 * point.depth * point.depth;
  out.loss = c.value * leaving * leaving;
  PressureSlopes slopes;
  if (derivatives) {
    slopes.by_velocity = -c.value * n.transpose();
    slopes.by_position =
        -(params.stiffness_N_per_m3 - c.by_depth * leaving) * n.transpose() -
        c.value * (point.normal_by_position.transpose() * point.approach).transpose();
    out.by_position = n * slopes.by_position + p * point.normal_by_position;
    out.by_velocity = n * slopes.by_velocity;
    out.by_slip.setZero();
  }
  if (params.friction > 0.0) add_friction(params, point, derivatives ? &slopes : nullptr, out);
  return true;
}

bool on_cylinder(double radius_m, const Eigen::Vector3d& axis, const Motion& wheel,
                 const Eigen::Vector3d& r, const Eigen::Vector3d& v, bool derivatives,
                 ContactPoint& out) {
  const Eigen::Vector3d d = r - wheel.p_WP;
  const Eigen::Vector3d radial = d - d.dot(axis) * axis;
  const double rho = radial.norm();
  if (rho >= radius_m || rho == 0.0) return false;
  out.depth = radius_m - rho;
  out.normal = radial / rho;
  out.approach = v - wheel.v_WP;
  out.slip = out.approach - wheel.w_WP.cross(d);
  if (!derivatives) return true;
  out.normal_by_position = (Eigen::Matrix3d::Identity() - axis * axis.transpose() -
                            out.normal * out.normal.transpose()) /
                           rho;
  out.slip_by_position = -cross_matrix(wheel.w_WP);
  return true;
}

bool on_plane(const Eigen::Vector3d& origin, const Eigen::Vector3d& normal,
              const Eigen::Vector3d& r, const Eigen::Vector3d& v, ContactPoint& out) {
  const double depth = normal.dot(origin - r);
  if (depth <= 0.0) return false;
  out.depth = depth;
  out.normal = normal;
  out.normal_by_position.setZero();
  out.slip_by_position.setZero();
  out.approach = v;
  out.slip = v;
  return true;
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
  const Eigen::Vector3d w = v - wheel.v_WP - wheel.w_WP.cross(d);
  const double rate = side * along.dot(w);
  const Damping c = damping_at(depth, teeth.damping_N_s_per_m, teeth.damping_depth_m);
  const double push = teeth.stiffness_N_per_m * depth + c.value * rate;
  out = {};
  const double stored_unit_J = 0.5 * teeth.stiffness_N_per_m * depth * depth;
  out.stored_J = engaged * stored_unit_J;
  // The force is tangential: it does not do the work that the energy of its depth changes by.
  const double leaving = radial.dot(w) / rho;
  const double deeper = std::sin(std::abs(angle)) * leaving + std::cos(angle) * rate;
  const double fading = engaged < 1.0 ? -leaving / teeth.pin_radius_m : 0.0;
  const double stored_W =
      engaged * teeth.stiffness_N_per_m * depth * deeper + fading * stored_unit_J;
  out.loss_W = engaged * std::max(push, 0.0) * rate - stored_W;
  if (push <= 0.0) return true;
  const Eigen::Matrix3d direction = along * along.transpose();
  out.force = -side * engaged * push * along;
  out.by_position = -engaged * (teeth.stiffness_N_per_m + c.by_depth * rate) * direction;
  out.by_velocity = -engaged * c.value * direction;
  return true;
}

}  // namespace tandem::fem::ancf

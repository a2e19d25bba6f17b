#pragma once

#include <Eigen/Core>

#include "protocol/contract/port.h"

namespace tandem::fem::ancf {

/// Constants of distributed contact, per unit of stress-free area of the band.
struct ContactParams {
  double stiffness_N_per_m3 = 0.0;         ///< k: pressure per depth
  double damping_N_s_per_m3 = 0.0;         ///< c
  double damping_depth_m = 1e-5;           ///< d₀: depth from which on damping acts in full
  double friction = 0.0;                   ///< μ
  double friction_slope_N_s_per_m3 = 0.0;  ///< v_s: traction per slip velocity below μ p / v_s
};

/// Traction on a point of the band and its derivatives.
struct Traction {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();        ///< Pa
  Eigen::Matrix3d by_position = Eigen::Matrix3d::Zero();  ///< ∂/∂r (Pa/m)
  Eigen::Matrix3d by_velocity = Eigen::Matrix3d::Zero();  ///< ∂/∂v (Pa s/m)
  Eigen::Matrix3d by_slip = Eigen::Matrix3d::Zero();      ///< ∂/∂w, w the slip (Pa s/m)
  double pressure = 0.0;                                  ///< p (Pa)
  double depth = 0.0;                                     ///< d (m)
  double stored = 0.0;                                    ///< ½ k d² (J/m²)
  double loss = 0.0;                                      ///< (p − k d) d' − t·v_t (W/m²)
};

/// Penalty pressure and trilinear Coulomb friction on a surface with the outward normal n:
///   p = max(0, k d + c d' min(1, d/d₀)),   d' = −n·u: no adhesion [(18), (21) of JC11]
///   t = −v_s v_t while v_s |v_t| ≤ μ p, else −μ p v_t/|v_t|   [(23)–(25)]
/// As printed (d₀ → 0) the pressure jumps to c d' when a point touches; an implicit step in which
/// it would have to end on that jump has no solution. d₀ makes the pressure continuous. u is the
/// velocity of the point relative to the surface's origin, w relative to its material, v_t = w − n
/// (n·w). Exact derivatives; `normal_by_position` = ∂n/∂r, `slip_by_position` = ∂w/∂r.
struct ContactPoint {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Matrix3d normal_by_position = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d slip_by_position = Eigen::Matrix3d::Zero();
  Eigen::Vector3d approach = Eigen::Vector3d::Zero();  ///< u (m/s)
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();      ///< w (m/s)
  double depth = 0.0;                                  ///< d (m)
};
/// A point that leaves so fast that p = 0 keeps its ½ k d², which the damper takes as it leaves.
/// False: no contact. Derivatives are filled when `derivatives` is set.
bool traction(const ContactParams& params, const ContactPoint& point, bool derivatives,
              Traction& out);

/// The point of a circular cylinder of radius R about the axis U through the wheel's origin; false
/// outside. `derivatives`: ∂n/∂r and ∂w/∂r too.
bool on_cylinder(double radius_m, const Eigen::Vector3d& axis, const Motion& wheel,
                 const Eigen::Vector3d& r, const Eigen::Vector3d& v, bool derivatives,
                 ContactPoint& out);
/// The point of the plane n·(r − o) = 0 at rest; false above.
bool on_plane(const Eigen::Vector3d& origin, const Eigen::Vector3d& normal,
              const Eigen::Vector3d& r, const Eigen::Vector3d& v, ContactPoint& out);

/// Seats of a sprocket for the pins of a chain [(10)–(20) of JC11, in monotone form]. A pin at the
/// angle Δ from its nearest seat, on the radius ρ, is pushed back along V = U × n by
///   F = max(0, k d + c d' min(1, d/d₀)) g(ρ),   d = ρ sin|Δ| − l_B r_pin,   d' = sign Δ V·w
///   g = clamp((R + height − ρ)/r_pin, 0, 1)
struct Teeth {
  int count = 0;
  double phase_rad = 0.0;  ///< angle of a seat from the wheel frame's z toward its x axis
  double pin_radius_m = 0.0;
  double backlash = 0.0;  ///< l_B: play over r_pin
  double height_m = 0.0;  ///< above the base circle
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
  double damping_depth_m = 1e-5;  ///< d₀
};

struct ToothForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();        ///< on the pin (N)
  Eigen::Matrix3d by_position = Eigen::Matrix3d::Zero();  ///< N/m
  Eigen::Matrix3d by_velocity = Eigen::Matrix3d::Zero();  ///< N s/m
  double stored_J = 0.0;                                  ///< U = ½ k d² g
  /// F V·w sign Δ − dU/dt: what damping takes, and what the tangential force does not do of the
  /// change of U, which depends on ρ too. A pin that leaves its seat outwards takes U with it.
  double loss_W = 0.0;
};
/// Angle of a pin from its nearest seat (rad), about the y axis of the wheel's frame.
[[nodiscard]] double seat_angle(const Teeth& teeth, const Motion& wheel, const Eigen::Vector3d& r);
/// False: the pin touches no flank. The derivatives leave out those of n, V and g.
bool tooth_force(const Teeth& teeth, double base_radius_m, const Motion& wheel,
                 const Eigen::Vector3d& r, const Eigen::Vector3d& v, ToothForce& out);

}  // namespace tandem::fem::ancf

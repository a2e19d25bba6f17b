#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contract/sim_time.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/law.h"

namespace tandem::mbs {

/// The name that stands for the immovable frame W wherever a second body may be named.
inline constexpr const char* kWorld = "world";

/// A rigid body and its motion at t = 0. Its frame B has its origin Bo at the centre of mass.
struct BodyParams {
  std::string name;
  /// A junction: no mass, no weight, no energy of its own. Mass and inertia are those that stand in
  /// while a step is made (see StandInInertia); the inertia is the same about all axes.
  bool massless = false;
  double mass_kg = 1.0;
  /// Elements of the inertia tensor about Bo in the axes of B: Ixx, Iyy, Izz, Ixy, Ixz, Iyz
  /// (kg m²). The last three are the tensor's own off-diagonal elements (Ixy = −∫ x y dm).
  std::array<double, 6> inertia_kg_m2{1.0, 1.0, 1.0, 0.0, 0.0, 0.0};
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();            ///< centre of mass (m)
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();  ///< x_W = R(q_WB) x_B
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();            ///< m/s
  Eigen::Vector3d w_WB = Eigen::Vector3d::Zero();            ///< rad/s, axes of W
  [[nodiscard]] Eigen::Matrix3d inertia_B() const;           ///< 3×3, axes of B
};

/// Free coordinates of each kind; axis 1 stays fixed in body1, axis 2 in body2.
enum class JointKind {
  Ball,       ///< a common point; no coordinate
  Hinge,      ///< turns about axis: 1 angle
  Slider,     ///< slides along axis: 1 length
  Universal,  ///< axis ⟂ axis2: 2 angles
  Fixed,      ///< one rigid body; no coordinate
  Hinge2      ///< steering axis, wheel axis2: 2 angles
};

/// Number of coordinates that limits and motors may refer to: 0, 1 or 2.
[[nodiscard]] int coordinate_count(JointKind kind);
[[nodiscard]] std::string name_of(JointKind kind);

/// lower ≤ coordinate ≤ upper in rad, counted through full turns, or m for a slider. A limit acts
/// when it has been passed, so a coordinate overshoots by up to |rate| h and is pushed back by the
/// fraction erp per step; a body that nothing holds there leaves with that speed, erp of its rate
/// at most.
struct LimitParams {
  int axis = 1;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

/// A prescribed rate of one coordinate θ, with the torque (N·m; slider: force, N) it may use:
///   Speed:     θ̇(t + h) = (1/h) ∫ law dt over [t, t + h]: θ follows ∫ law dt exactly.
///              Verlet's θ does, too, and its rate at the end of the step is law(t + h),
///   Position:  θ̇(t + h) = [target(t + h) − target(t) − erp (θ(t) − target(t))] / h,
///              target(t) = law(t) − law(0),
/// so the pose at t = 0 belongs to the law's value at t = 0, and drift decays by (1 − erp) a step.
/// A motor beside limits of its axis needs a largest effort, with which it pushes against a stop.
struct MotorParams {
  enum class Kind { Speed, Position };
  Kind kind = Kind::Speed;
  Law law;
  int axis = 1;
  double max_effort = std::numeric_limits<double>::infinity();  ///< N·m, slider: N
};

/// A joint between body1 and body2 (another body or kWorld). Coordinates are zero at t = 0 and
/// count the motion of body1 relative to body2, right-handed about (along) the axis.
struct JointParams {
  std::string name;
  JointKind kind = JointKind::Ball;
  std::string body1;
  std::string body2 = kWorld;
  Eigen::Vector3d p_WA = Eigen::Vector3d::Zero();    ///< anchor at t = 0 (m); slider, fixed: unused
  Eigen::Vector3d axis_W = Eigen::Vector3d::Zero();  ///< at t = 0, any length but 0
  Eigen::Vector3d axis2_W = Eigen::Vector3d::Zero();  ///< universal, hinge2
  std::vector<LimitParams> limits;                    ///< at most one per axis
  std::optional<MotorParams> motor;
};

/// Spring-damper between a point of body1 and a point of body2 (or kWorld), both given in W at
/// t = 0. With d = p2 − p1, l = |d|, u = d / l the force on body1 is
///   f = [k (l − l0) + c l̇] u.
struct SpringParams {
  std::string name;
  std::string body1;
  std::string body2 = kWorld;
  Eigen::Vector3d p1_W = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d p2_W = Eigen::Vector3d::Zero();  ///< m
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
  std::optional<double> rest_length_m = std::nullopt;  ///< none = the length at t = 0
};

/// Spring-damper on the coordinate θ of a hinge or slider: effort on body1 = −k (θ − θ0) − c θ̇.
struct JointSpringParams {
  std::string name;
  std::string joint;
  double stiffness = 0.0;  ///< N·m/rad, slider: N/m
  double damping = 0.0;    ///< N·m·s/rad, slider: N·s/m
  double rest = 0.0;       ///< θ0 in rad, slider: m
};

/// A force at a point of a body, or a torque, along a direction fixed in W: law(t) times it.
struct ForceParams {
  enum class Kind { Force, Torque };
  std::string name;
  std::string body;
  Kind kind = Kind::Force;
  Eigen::Vector3d p_BF = Eigen::Vector3d::Zero();  ///< point, axes of B from Bo (m); force only
  Eigen::Vector3d direction_W = Eigen::Vector3d::Zero();  ///< made a unit vector
  Law law;                                                ///< N or N·m
};

/// How a micro step is made of ODE's steps; see RigidWorld.
enum class IntegratorKind {
  Euler,            ///< semi-implicit Euler, ODE's own: one dWorldStep, first order
  Verlet,           ///< velocity Verlet with constrained velocities: two dWorldSteps, second order
  GeneralisedAlpha  ///< the same with damped port wrenches, see WrenchRule
};

/// Everything that a RigidWorld is made of.
struct Params {
  Eigen::Vector3d gravity_m_per_s2 = Eigen::Vector3d(0.0, 0.0, -9.81);
  SimTime macro_step{};  ///< nominal H; what info() reports when no micro step is given
  std::optional<SimTime> micro_step;  ///< h; none = one step of ODE per macro step
  IntegratorKind integrator = IntegratorKind::Euler;
  double newmark_beta = 0.25;  ///< of Verlet: how the new wrench acts on the pose, 0 to 1/4
  double rho_infinity = 0.8;   ///< of GeneralisedAlpha: what a step keeps of infinitely fast motion
  double erp = 0.2;            ///< share of a joint's position error removed in one step
  double cfm = 1e-10;          ///< constraint force mixing (m/s per N), see whole_step()
  std::vector<BodyParams> bodies;
  std::vector<JointParams> joints;
  std::vector<SpringParams> springs;
  std::vector<JointSpringParams> joint_springs;
  std::vector<ForceParams> forces;
  std::vector<scenario::PortParams> ports;
};

/// What is wrong with one element, and at which of its scenario keys.
struct Defect {
  std::string key;
  std::string text;
};

/// First defect of an element, in itself and against the rest of `params`; none = sound.
[[nodiscard]] std::optional<Defect> find_defect(const BodyParams& body);
/// Of a junction against the ports and the integrator; none for bodies with mass.
[[nodiscard]] std::optional<Defect> bad_junction(const BodyParams& body, const Params& params);
[[nodiscard]] std::optional<Defect> find_defect(const JointParams& joint, const Params& params);
[[nodiscard]] std::optional<Defect> find_defect(const SpringParams& spring, const Params& params);
[[nodiscard]] std::optional<Defect> find_defect(const JointSpringParams& spring,
                                                const Params& params);
[[nodiscard]] std::optional<Defect> find_defect(const ForceParams& force, const Params& params);
[[nodiscard]] std::optional<Defect> find_defect(const scenario::PortParams& port,
                                                const Params& params);

/// Throws a Usage error that names the first defective element, the key and the remedy.
void check(const Params& params);

/// Position of `name` in params.bodies; none for kWorld. Throws std::out_of_range for others.
[[nodiscard]] std::optional<std::size_t> body_index(const Params& params, const std::string& name);

/// Number of the port that stands at the origin of a junction's frame, where the stand-in inertia
/// is taken away again; none: no port does.
[[nodiscard]] std::optional<std::size_t> port_at(const Params& params, const BodyParams& junction);

}  // namespace tandem::mbs

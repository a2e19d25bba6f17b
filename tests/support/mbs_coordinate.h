#pragma once

#include <string>

#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {

/// One coordinate of one kind of joint.
struct Coordinate {
  JointKind kind;
  int axis;
};
inline constexpr Coordinate kCoordinates[] = {{JointKind::Hinge, 1},     {JointKind::Slider, 1},
                                              {JointKind::Universal, 1}, {JointKind::Universal, 2},
                                              {JointKind::Hinge2, 1},    {JointKind::Hinge2, 2}};
inline constexpr IntegratorKind kIntegrators[] = {IntegratorKind::Euler, IntegratorKind::Verlet};

inline std::string text_of(const Coordinate& tested, IntegratorKind integrator) {
  return name_of(tested.kind) + " axis " + std::to_string(tested.axis) +
         (integrator == IntegratorKind::Verlet ? ", verlet" : ", euler");
}

/// A body "a" of 1 kg and 1 kg m² about every axis through its centre, at rest, whose joint lets it
/// turn about (slide along) z by axis 1 and x by axis 2; a port on it. Joints are exact.
inline Params body_on(const Coordinate& tested, IntegratorKind integrator, SimTime h) {
  Params params = params_with_step(h);
  params.integrator = integrator;
  params.bodies = {body_at("a", 1.0, Eigen::Vector3d::Zero())};
  std::string other = kWorld;
  if (tested.kind == JointKind::Hinge2) {  // needs two bodies
    other = "b";
    params.bodies.push_back(body_at(other, 1.0, Eigen::Vector3d::Zero()));
  }
  const bool two_axes = tested.kind == JointKind::Universal || tested.kind == JointKind::Hinge2;
  params.joints = {joint_between(
      "joint", tested.kind, "a", other, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(),
      two_axes ? Eigen::Vector3d::UnitX().eval() : Eigen::Vector3d::Zero().eval())};
  if (other != kWorld) {
    params.joints.push_back(
        joint_between("ground", JointKind::Fixed, other, kWorld, Eigen::Vector3d::Zero()));
  }
  params.ports = {port_on("port", "a")};
  return params;
}

/// An effort (N·m, slider: N) on the coordinate: its generalised inertia is 1.
inline WrenchSet effort_on(const Coordinate& tested, double effort) {
  WrenchSet wrenches(1);
  const Eigen::Vector3d axis =
      tested.axis == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  (tested.kind == JointKind::Slider ? wrenches[0].f_P_W : wrenches[0].t_P_W) = effort * axis;
  return wrenches;
}

inline double coordinate_of(const RigidWorld& world, const Coordinate& tested) {
  return world.state().joint_coordinates[0][static_cast<std::size_t>(tested.axis - 1)];
}

/// Its rate, of a body that moves by nothing else.
inline double rate_of(const RigidWorld& world, const Coordinate& tested) {
  const BodyState& a = world.state().bodies[0];
  if (tested.kind == JointKind::Slider) return a.v_WB.z();
  return tested.axis == 1 ? a.w_WB.z() : a.w_WB.x();
}

}  // namespace tandem::mbs::testing

#pragma once

#include <string>

#include "mbs_process/params.h"
#include "mbs_process/rigid_world.h"
#include "protocol/contract/error.h"
#include "protocol/contract/port.h"

namespace tandem::mbs::testing {

inline constexpr SimTime kMillisecond{1'000'000};

/// "b3" of "b" and 3.
inline std::string numbered(std::string prefix, std::size_t number) {
  prefix += std::to_string(number);
  return prefix;
}

/// A body at rest with principal moments I (kg m²).
inline BodyParams body_at(const std::string& name, double mass_kg, const Eigen::Vector3d& p_WB,
                          const Eigen::Vector3d& I = {1.0, 1.0, 1.0}) {
  BodyParams body;
  body.name = name;
  body.mass_kg = mass_kg;
  body.inertia_kg_m2 = {I.x(), I.y(), I.z(), 0.0, 0.0, 0.0};
  body.p_WB = p_WB;
  return body;
}

inline JointParams joint_between(const std::string& name, JointKind kind, const std::string& body1,
                                 const std::string& body2, const Eigen::Vector3d& p_WA,
                                 const Eigen::Vector3d& axis_W = Eigen::Vector3d::Zero(),
                                 const Eigen::Vector3d& axis2_W = Eigen::Vector3d::Zero()) {
  JointParams joint;
  joint.name = name;
  joint.kind = kind;
  joint.body1 = body1;
  joint.body2 = body2;
  joint.p_WA = p_WA;
  joint.axis_W = axis_W;
  joint.axis2_W = axis2_W;
  return joint;
}

inline scenario::PortParams port_on(const std::string& name, const std::string& body) {
  scenario::PortParams port;
  port.name = name;
  port.body = body;
  return port;
}

inline scenario::PortParams port_at(
    const std::string& name, const std::string& body, const Eigen::Vector3d& p_WP,
    const Eigen::Quaterniond& q_WP = Eigen::Quaterniond::Identity()) {
  scenario::PortParams port = port_on(name, body);
  port.at_body_frame = false;
  port.p_WP = p_WP;
  port.q_WP = q_WP;
  return port;
}

/// Parameters with macro step H, no gravity and exact joints: cfm = 0 leaves no compliance.
inline Params params_with_step(SimTime macro_step) {
  Params params;
  params.macro_step = macro_step;
  params.gravity_m_per_s2.setZero();
  params.cfm = 0.0;
  return params;
}

inline StepRequest<WrenchSet> step_of(SimTime macro_step, const WrenchSet& begin,
                                      const WrenchSet& end) {
  StepRequest<WrenchSet> request;
  request.step = macro_step;
  request.input = {begin, end};
  return request;
}

/// Advances n steps of H with constant wrenches; fails loudly when a step is not Done.
inline void run(RigidWorld& world, SimTime macro_step, int n, const WrenchSet& wrenches = {}) {
  for (int i = 0; i < n; ++i) {
    const auto result = world.advance(step_of(macro_step, wrenches, wrenches));
    if (result.outcome != Outcome::Done) throw Error(ErrorKind::NotSolved, result.message);
  }
}

inline Law constant(double value) { return Law(ConstantLaw{value}); }

}  // namespace tandem::mbs::testing

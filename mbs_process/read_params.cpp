// Reading of the `mbs` section into Params; the table itself is in mbs_keys.cpp.
#include <fmt/format.h>

#include <algorithm>

#include "mbs_process/mbs_keys.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/law.h"

namespace tandem::mbs {
namespace {

using scenario::Node;

std::vector<Node> list_or_none(const Node& node, std::string_view key) {
  return node.has(key) ? node.list(key) : std::vector<Node>{};
}

Eigen::Vector3d vector_or_zero(const Node& node, std::string_view key) {
  return node.has(key) ? node.vector3(key) : Eigen::Vector3d::Zero();
}

double real_or(const Node& node, std::string_view key, double otherwise) {
  return node.has(key) ? node.real(key) : otherwise;
}

JointKind joint_kind(const std::string& text) {
  for (JointKind kind : {JointKind::Ball, JointKind::Hinge, JointKind::Slider, JointKind::Universal,
                         JointKind::Fixed}) {
    if (text == name_of(kind)) return kind;
  }
  return JointKind::Hinge2;
}

void read_motion(const Node& node, BodyParams& body) {
  body.p_WB = node.vector3("position_m");
  body.q_WB = node.quaternion_wxyz("orientation_wxyz");
  body.v_WB = node.vector3("velocity_m_per_s");
  body.w_WB = node.vector3("angular_velocity_rad_per_s");
}

BodyParams read_body(const Node& node) {
  BodyParams body;
  body.name = node.text("name");
  body.mass_kg = node.real("mass_kg");
  const std::vector<double> inertia = node.reals("inertia_kg_m2");
  if (inertia.size() != 3 && inertia.size() != 6) {
    node.fail("inertia_kg_m2", "needs 3 or 6 numbers, not " + std::to_string(inertia.size()) +
                                   ": [Ixx, Iyy, Izz] or [Ixx, Iyy, Izz, Ixy, Ixz, Iyz].");
  }
  body.inertia_kg_m2.fill(0.0);
  std::copy(inertia.begin(), inertia.end(), body.inertia_kg_m2.begin());
  read_motion(node, body);
  return body;
}

BodyParams read_junction(const Node& node) {
  BodyParams junction;
  junction.name = node.text("name");
  junction.massless = true;
  junction.mass_kg = node.real("stand_in_mass_kg");
  const double inertia = node.real("stand_in_inertia_kg_m2");
  junction.inertia_kg_m2 = {inertia, inertia, inertia, 0.0, 0.0, 0.0};
  read_motion(node, junction);
  return junction;
}

/// Refuses keys of the wrong unit: `_m` and `_N` belong to sliders, `_rad` and `_Nm` to the rest.
void refuse_other_unit(const Node& node, bool slider, const std::vector<std::string>& linear,
                       const std::vector<std::string>& angular) {
  for (const std::string& key : slider ? angular : linear) {
    if (!node.has(key)) continue;
    node.fail(key, slider ? "a slider's coordinate is a length; use the key in m or N."
                          : "this joint's coordinate is an angle; use the key in rad or N·m.");
  }
}

LimitParams read_limit(const Node& node, bool slider) {
  refuse_other_unit(node, slider, {"lower_m", "upper_m"}, {"lower_rad", "upper_rad"});
  LimitParams limit;
  limit.axis = static_cast<int>(node.integer("axis"));
  limit.lower = real_or(node, slider ? "lower_m" : "lower_rad", limit.lower);
  limit.upper = real_or(node, slider ? "upper_m" : "upper_rad", limit.upper);
  return limit;
}

MotorParams read_motor(const Node& node, bool slider) {
  refuse_other_unit(node, slider, {"max_force_N"}, {"max_torque_Nm"});
  MotorParams motor;
  motor.kind =
      node.text("kind") == "speed" ? MotorParams::Kind::Speed : MotorParams::Kind::Position;
  motor.law = scenario::read_law(node.section("law"));
  motor.axis = static_cast<int>(node.integer("axis"));
  motor.max_effort = real_or(node, slider ? "max_force_N" : "max_torque_Nm", motor.max_effort);
  return motor;
}

JointParams read_joint(const Node& node) {
  JointParams joint;
  joint.name = node.text("name");
  joint.kind = joint_kind(node.text("kind"));
  joint.body1 = node.text("body1");
  joint.body2 = node.text("body2");
  joint.p_WA = vector_or_zero(node, "anchor_m");
  joint.axis_W = vector_or_zero(node, "axis");
  joint.axis2_W = vector_or_zero(node, "axis2");
  const bool slider = joint.kind == JointKind::Slider;
  for (const Node& limit : list_or_none(node, "limits")) {
    joint.limits.push_back(read_limit(limit, slider));
  }
  if (node.has("motor")) joint.motor = read_motor(node.section("motor"), slider);
  return joint;
}

SpringParams read_spring(const Node& node) {
  SpringParams spring;
  spring.name = node.text("name");
  spring.body1 = node.text("body1");
  spring.body2 = node.text("body2");
  spring.p1_W = node.vector3("point1_m");
  spring.p2_W = node.vector3("point2_m");
  spring.stiffness_N_per_m = node.real("stiffness_N_per_m");
  spring.damping_N_s_per_m = node.real("damping_N_s_per_m");
  if (node.has("rest_length_m")) spring.rest_length_m = node.real("rest_length_m");
  return spring;
}

JointSpringParams read_joint_spring(const Node& node, const Params& params) {
  const bool axial = node.text("kind") == "axial";
  JointSpringParams spring;
  spring.name = node.text("name");
  spring.joint = node.text("joint");
  spring.stiffness = node.real(axial ? "stiffness_N_per_m" : "stiffness_Nm_per_rad");
  spring.damping = node.real(axial ? "damping_N_s_per_m" : "damping_Nm_s_per_rad");
  spring.rest = node.real(axial ? "rest_m" : "rest_rad");
  for (const JointParams& joint : params.joints) {
    if (joint.name != spring.joint) continue;
    if (joint.kind == JointKind::Slider && !axial) {
      node.fail("kind", "joint '" + joint.name + "' is a slider. Use kind: axial.");
    }
    if (joint.kind == JointKind::Hinge && axial) {
      node.fail("kind", "joint '" + joint.name + "' is a hinge. Use kind: torsional.");
    }
  }
  return spring;
}

ForceParams read_force(const Node& node) {
  ForceParams force;
  force.name = node.text("name");
  force.body = node.text("body");
  force.kind = node.text("kind") == "torque" ? ForceParams::Kind::Torque : ForceParams::Kind::Force;
  force.p_BF = vector_or_zero(node, "point_B_m");
  force.direction_W = node.vector3("direction");
  force.law = scenario::read_law(node.section("law"));
  return force;
}

/// Reports a defect where it stands in the file.
void refuse(const Node& node, const std::optional<Defect>& defect) {
  if (defect) node.fail(defect->key, defect->text);
}

/// Of several worlds, an end may be a body of another one: refuse_links() says so by name.
bool ends_elsewhere(const Node& mbs, const Node& link, const std::vector<std::string>& ends,
                    const Params& params) {
  if (mbs.path_name() == "mbs") return false;
  return std::any_of(ends.begin(), ends.end(), [&](const std::string& end) {
    const std::string body = link.text(end);
    return body != kWorld &&
           std::none_of(params.bodies.begin(), params.bodies.end(),
                        [&](const BodyParams& known) { return known.name == body; });
  });
}

SimTime read_micro_step(const Node& mbs, SimTime macro_step) {
  SimTime h{};
  try {
    h = sim_time_from_seconds(mbs.real("micro_step_s"));
  } catch (const Error& error) {
    mbs.fail("micro_step_s", error.what());
  }
  if (h.count() == 0) mbs.fail("micro_step_s", "is below 1 ns. Raise it.");
  if (macro_step % h != SimTime{}) {
    mbs.fail("micro_step_s", fmt::format("run.macro_step_s = {:g} is no whole multiple of {:g} s.",
                                         to_seconds(macro_step), to_seconds(h)));
  }
  return h;
}

}  // namespace

Params read_mechanism(const Node& mbs) {
  Params params;
  params.gravity_m_per_s2 = mbs.vector3("gravity_m_per_s2");
  const std::string integrator = mbs.text("integrator");
  params.integrator = integrator == "verlet"              ? IntegratorKind::Verlet
                      : integrator == "generalised_alpha" ? IntegratorKind::GeneralisedAlpha
                                                          : IntegratorKind::Euler;
  if (params.integrator == IntegratorKind::GeneralisedAlpha) {
    params.rho_infinity = mbs.real("rho_infinity");
  }
  if (params.integrator == IntegratorKind::Verlet) params.newmark_beta = mbs.real("newmark_beta");
  params.erp = mbs.real("erp");
  params.cfm = mbs.real("cfm");
  for (const Node& node : list_or_none(mbs, "bodies")) {
    params.bodies.push_back(read_body(node));
    refuse(node, find_defect(params.bodies.back()));
  }
  for (const Node& node : list_or_none(mbs, "junctions")) {
    BodyParams junction = read_junction(node);
    refuse(node, find_defect(junction));
    for (const BodyParams& body : params.bodies) {
      if (body.name == junction.name) node.fail("name", "'" + body.name + "' is taken by a body.");
    }
    params.bodies.push_back(std::move(junction));
  }
  if (params.bodies.empty()) mbs.fail("bodies", "is missing: name a body or a junction.");
  for (const Node& node : list_or_none(mbs, "joints")) {
    params.joints.push_back(read_joint(node));
    if (ends_elsewhere(mbs, node, {"body1", "body2"}, params)) continue;
    refuse(node, find_defect(params.joints.back(), params));
  }
  for (const Node& node : list_or_none(mbs, "springs")) {
    params.springs.push_back(read_spring(node));
    if (ends_elsewhere(mbs, node, {"body1", "body2"}, params)) continue;
    refuse(node, find_defect(params.springs.back(), params));
  }
  for (const Node& node : list_or_none(mbs, "joint_springs")) {
    params.joint_springs.push_back(read_joint_spring(node, params));
    refuse(node, find_defect(params.joint_springs.back(), params));
  }
  for (const Node& node : list_or_none(mbs, "forces")) {
    params.forces.push_back(read_force(node));
    if (ends_elsewhere(mbs, node, {"body"}, params)) continue;
    refuse(node, find_defect(params.forces.back(), params));
  }
  return params;
}

Params read_params(const Node& root) {
  const Node mbs = root.section("mbs");
  Params params = read_mechanism(mbs);
  params.macro_step = scenario::read_run(root).macro_step;
  if (mbs.has("micro_step_s")) params.micro_step = read_micro_step(mbs, params.macro_step);
  params.ports = scenario::read_ports(root);
  const std::vector<Node> ports = root.list("ports");
  for (std::size_t i = 0; i < ports.size(); ++i) {
    refuse(ports[i], find_defect(params.ports[i], params));
  }
  const std::vector<Node> junctions = list_or_none(mbs, "junctions");
  const std::size_t first = params.bodies.size() - junctions.size();
  for (std::size_t i = 0; i < junctions.size(); ++i) {
    refuse(junctions[i], bad_junction(params.bodies[first + i], params));
  }
  return params;
}

}  // namespace tandem::mbs

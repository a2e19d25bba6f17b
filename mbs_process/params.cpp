#include "mbs_process/params.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include "protocol/contract/error.h"
#include "protocol/scenario/node.h"

namespace tandem::mbs {
namespace {

std::string text_of(double x) { return fmt::format("{:.6g}", x); }

bool finite(double x) { return std::isfinite(x); }

std::vector<std::string> body_names(const Params& params) {
  std::vector<std::string> names;
  for (const BodyParams& body : params.bodies) names.push_back(body.name);
  return names;
}

std::optional<Defect> unknown_body(const std::string& key, const std::string& name,
                                   const Params& params, bool world_allowed) {
  std::vector<std::string> known = body_names(params);
  if (world_allowed) known.emplace_back(kWorld);
  for (const std::string& candidate : known) {
    if (candidate == name) return std::nullopt;
  }
  return Defect{key, "there is no body '" + name + "'." + scenario::did_you_mean(name, known)};
}

/// Both ends of a joint or spring: body1 moves, body2 may be the world.
std::optional<Defect> bad_ends(const std::string& body1, const std::string& body2,
                               const Params& params) {
  if (body1 == kWorld) {
    return Defect{"body1", "the world cannot be body1. Name the moving body first, world second."};
  }
  if (auto defect = unknown_body("body1", body1, params, false)) return defect;
  if (auto defect = unknown_body("body2", body2, params, true)) return defect;
  if (body1 == body2) {
    return Defect{
        "body2",
        "'" + body1 + "' cannot be connected with itself. Name another body or " + kWorld + "."};
  }
  return std::nullopt;
}

std::optional<Defect> bad_inertia(const BodyParams& body) {
  for (double element : body.inertia_kg_m2) {
    if (!finite(element)) return Defect{"inertia_kg_m2", "every element must be finite."};
  }
  const Eigen::Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.inertia_B(), Eigen::EigenvaluesOnly)
          .eigenvalues();
  const std::string list = "principal moments are " + text_of(principal[0]) + ", " +
                           text_of(principal[1]) + ", " + text_of(principal[2]) + " kg m²";
  if (!(principal[0] > 0.0)) {
    return Defect{"inertia_kg_m2", list +
                                       "; all must be positive (positive definite tensor). "
                                       "Give [Ixx, Iyy, Izz] or [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]."};
  }
  // I1 + I2 ≥ I3 for every distribution of mass, with equality for a flat one (hence the ulps).
  if (principal[0] + principal[1] < principal[2] * (1.0 - 1e-9)) {
    return Defect{"inertia_kg_m2", list +
                                       "; the largest exceeds the sum of the others, which no "
                                       "distribution of mass has (triangle inequality)."};
  }
  return std::nullopt;
}

std::string ports_on(const BodyParams& body, const Params& params) {
  std::string names;
  for (const scenario::PortParams& port : params.ports) {
    if (port.body == body.name) names += (names.empty() ? "" : ", ") + port.name;
  }
  return names;
}

bool needs_axis2(JointKind kind) {
  return kind == JointKind::Universal || kind == JointKind::Hinge2;
}

std::optional<Defect> bad_axes(const JointParams& joint) {
  const std::string kind = name_of(joint.kind);
  const bool has1 = joint.axis_W.norm() > 0.0;
  const bool has2 = joint.axis2_W.norm() > 0.0;
  if (!joint.axis_W.allFinite()) return Defect{"axis", "must be finite."};
  if (!joint.axis2_W.allFinite()) return Defect{"axis2", "must be finite."};
  if (!joint.p_WA.allFinite()) return Defect{"anchor_m", "must be finite."};
  if (coordinate_count(joint.kind) > 0 && !has1) {
    return Defect{"axis",
                  fmt::format("a {} joint needs an axis that is not zero, e.g. [0, 0, 1].", kind)};
  }
  if (coordinate_count(joint.kind) == 0 && has1) {
    return Defect{"axis", fmt::format("a {} joint has no axis. Leave it out.", kind)};
  }
  if (!needs_axis2(joint.kind)) {
    if (has2) return Defect{"axis2", fmt::format("a {} joint has no axis2. Leave it out.", kind)};
    return std::nullopt;
  }
  if (!has2)
    return Defect{"axis2", fmt::format("a {} joint needs an axis2 that is not zero.", kind)};
  const double cosine = joint.axis_W.normalized().dot(joint.axis2_W.normalized());
  if (std::abs(cosine) > 1.0 - 1e-6) {
    return Defect{"axis2", "is parallel to axis; a " + kind + " joint needs two directions."};
  }
  // ODE's universal joint keeps its axes perpendicular and would jerk others into place.
  if (joint.kind == JointKind::Universal && std::abs(cosine) > 1e-6) {
    return Defect{"axis2",
                  "must be perpendicular to axis; the cosine of the angle between them is " +
                      text_of(cosine) + "."};
  }
  return std::nullopt;
}

std::optional<Defect> bad_axis_number(const JointParams& joint, int axis, const std::string& key) {
  const int count = coordinate_count(joint.kind);
  if (count == 0) {
    return Defect{key, "a " + name_of(joint.kind) +
                           " joint has no axis to act on; only hinge, slider, universal and hinge2 "
                           "have one."};
  }
  if (axis < 1 || axis > count) {
    return Defect{key, "axis " + std::to_string(axis) + " does not exist; a " +
                           name_of(joint.kind) + " joint has " + std::to_string(count) + "."};
  }
  return std::nullopt;
}

std::optional<Defect> bad_limit(const JointParams& joint, const LimitParams& limit) {
  if (auto defect = bad_axis_number(joint, limit.axis, "limits")) return defect;
  const std::string range = fmt::format("[{:.6g}, {:.6g}]", limit.lower, limit.upper);
  if (!(limit.lower <= limit.upper)) {
    return Defect{"limits", "range " + range + " is reversed. Swap lower and upper."};
  }
  if (!(limit.lower <= 0.0 && limit.upper >= 0.0)) {
    return Defect{"limits", "range " + range +
                                " excludes 0, which is the coordinate at t = 0. Count limits from "
                                "the pose at t = 0."};
  }
  if (joint.kind == JointKind::Hinge2 && limit.axis == 2) {
    return Defect{"limits", "axis 2 of a hinge2 joint turns freely. Limit axis 1 alone."};
  }
  return std::nullopt;
}

std::optional<Defect> bad_motor(const JointParams& joint) {
  if (!joint.motor) return std::nullopt;
  const MotorParams& motor = *joint.motor;
  if (auto defect = bad_axis_number(joint, motor.axis, "motor")) return defect;
  if (!(motor.max_effort > 0.0)) {
    return Defect{"motor",
                  "the largest effort must be positive, not " + text_of(motor.max_effort) + "."};
  }
  for (const LimitParams& limit : joint.limits) {
    if (limit.axis == motor.axis && !finite(motor.max_effort)) {
      return Defect{"motor",
                    fmt::format("axis {} has limits, and a motor that never yields would push "
                                "through them. Give it {}, or bound the law in place of the axis.",
                                limit.axis,
                                joint.kind == JointKind::Slider ? "max_force_N" : "max_torque_Nm")};
    }
  }
  return std::nullopt;
}

Eigen::Vector3d initial_point(const SpringParams& spring, bool first) {
  return first ? spring.p1_W : spring.p2_W;
}

template <class Elements, class Finder>
void check_each(const Elements& elements, const std::string& what, const Finder& finder) {
  std::set<std::string> seen;
  for (const auto& element : elements) {
    const std::string who = "mbs: " + what + " '" + element.name + "'";
    require(!element.name.empty(), "mbs: a " + what + " has no name. Give it one.");
    require(seen.insert(element.name).second, who + ": name is used twice. Rename one of them.");
    if (const std::optional<Defect> defect = finder(element)) {
      throw Error(ErrorKind::Usage, who + ": " + defect->key + ": " + defect->text);
    }
  }
}

}  // namespace

Eigen::Matrix3d BodyParams::inertia_B() const {
  const auto& I = inertia_kg_m2;
  Eigen::Matrix3d tensor;
  tensor << I[0], I[3], I[4],  //
      I[3], I[1], I[5],        //
      I[4], I[5], I[2];
  return tensor;
}

int coordinate_count(JointKind kind) {
  switch (kind) {
    case JointKind::Ball:
    case JointKind::Fixed:
      return 0;
    case JointKind::Hinge:
    case JointKind::Slider:
      return 1;
    case JointKind::Universal:
    case JointKind::Hinge2:
      return 2;
  }
  return 0;
}

std::string name_of(JointKind kind) {
  switch (kind) {
    case JointKind::Ball:
      return "ball";
    case JointKind::Hinge:
      return "hinge";
    case JointKind::Slider:
      return "slider";
    case JointKind::Universal:
      return "universal";
    case JointKind::Fixed:
      return "fixed";
    case JointKind::Hinge2:
      return "hinge2";
  }
  return "unknown";
}

std::optional<Defect> find_defect(const BodyParams& body) {
  if (body.name == kWorld)
    return Defect{"name", "'world' is the fixed frame. Choose another name."};
  if (!(finite(body.mass_kg) && body.mass_kg > 0.0)) {
    return Defect{"mass_kg", "must be positive and finite, not " + text_of(body.mass_kg) + "."};
  }
  if (auto defect = bad_inertia(body)) return defect;
  if (!body.p_WB.allFinite()) return Defect{"position_m", "must be finite."};
  if (!(std::abs(body.q_WB.norm() - 1.0) <= 1e-6)) {
    return Defect{"orientation_wxyz", "the quaternion's norm is " + text_of(body.q_WB.norm()) +
                                          ", not 1. Normalise it."};
  }
  if (!body.v_WB.allFinite()) return Defect{"velocity_m_per_s", "must be finite."};
  if (!body.w_WB.allFinite()) return Defect{"angular_velocity_rad_per_s", "must be finite."};
  return std::nullopt;
}

std::optional<Defect> find_defect(const JointParams& joint, const Params& params) {
  if (auto defect = bad_ends(joint.body1, joint.body2, params)) return defect;
  if (joint.kind == JointKind::Hinge2 && joint.body2 == kWorld) {
    return Defect{"body2",
                  "a hinge2 joint connects two bodies. Use a universal joint to the world."};
  }
  if (auto defect = bad_axes(joint)) return defect;
  std::set<int> limited;
  for (const LimitParams& limit : joint.limits) {
    if (auto defect = bad_limit(joint, limit)) return defect;
    if (!limited.insert(limit.axis).second) {
      return Defect{"limits", "axis " + std::to_string(limit.axis) + " is limited twice."};
    }
  }
  return bad_motor(joint);
}

std::optional<Defect> find_defect(const SpringParams& spring, const Params& params) {
  if (auto defect = bad_ends(spring.body1, spring.body2, params)) return defect;
  if (!spring.p1_W.allFinite()) return Defect{"point1_m", "must be finite."};
  if (!spring.p2_W.allFinite()) return Defect{"point2_m", "must be finite."};
  if (!(spring.stiffness_N_per_m >= 0.0 && finite(spring.stiffness_N_per_m))) {
    return Defect{"stiffness_N_per_m", "must be finite and not negative."};
  }
  if (!(spring.damping_N_s_per_m >= 0.0 && finite(spring.damping_N_s_per_m))) {
    return Defect{"damping_N_s_per_m", "must be finite and not negative."};
  }
  const double length = (initial_point(spring, false) - initial_point(spring, true)).norm();
  const double rest = spring.rest_length_m.value_or(length);
  if (!(rest >= 0.0 && finite(rest))) {
    return Defect{"rest_length_m", "must be finite and not negative."};
  }
  if (length == 0.0 && rest > 0.0) {
    return Defect{"point2_m", "both ends coincide at t = 0, so a spring of rest length " +
                                  text_of(rest) + " m has no direction. Move one of them."};
  }
  return std::nullopt;
}

std::optional<Defect> find_defect(const JointSpringParams& spring, const Params& params) {
  std::vector<std::string> known;
  for (const JointParams& joint : params.joints) {
    if (joint.kind != JointKind::Hinge && joint.kind != JointKind::Slider) continue;
    known.push_back(joint.name);
    if (joint.name != spring.joint) continue;
    if (!(spring.stiffness >= 0.0 && finite(spring.stiffness))) {
      return Defect{"stiffness", "must be finite and not negative."};
    }
    if (!(spring.damping >= 0.0 && finite(spring.damping))) {
      return Defect{"damping", "must be finite and not negative."};
    }
    if (!finite(spring.rest)) return Defect{"rest", "must be finite."};
    return std::nullopt;
  }
  return Defect{"joint", "there is no hinge or slider '" + spring.joint + "'." +
                             scenario::did_you_mean(spring.joint, known)};
}

std::optional<Defect> find_defect(const ForceParams& force, const Params& params) {
  if (auto defect = unknown_body("body", force.body, params, false)) return defect;
  if (!(force.direction_W.allFinite() && force.direction_W.norm() > 0.0)) {
    return Defect{"direction", "must be a finite direction that is not zero, e.g. [1, 0, 0]."};
  }
  if (!force.p_BF.allFinite()) return Defect{"point_B_m", "must be finite."};
  if (force.kind == ForceParams::Kind::Torque && force.p_BF.norm() > 0.0) {
    return Defect{"point_B_m", "a torque has no point of action. Leave it out."};
  }
  return std::nullopt;
}

std::optional<Defect> find_defect(const scenario::PortParams& port, const Params& params) {
  if (auto defect = unknown_body("body", port.body, params, false)) return defect;
  if (port.at_body_frame) return std::nullopt;
  if (!port.p_WP.allFinite()) return Defect{"position_m", "must be finite."};
  if (!(std::abs(port.q_WP.norm() - 1.0) <= 1e-6)) {
    return Defect{"orientation_wxyz", "the quaternion's norm is " + text_of(port.q_WP.norm()) +
                                          ", not 1. Normalise it."};
  }
  return std::nullopt;
}

void check(const Params& params) {
  require(params.gravity_m_per_s2.allFinite(), "mbs: gravity_m_per_s2: must be finite.");
  require(params.erp >= 0.0 && params.erp <= 1.0,
          "mbs: erp: must lie in [0, 1], not " + text_of(params.erp) + ".");
  require(params.cfm >= 0.0 && finite(params.cfm),
          "mbs: cfm: must be finite and not negative, not " + text_of(params.cfm) + ".");
  require(!params.micro_step || params.micro_step->count() > 0,
          "mbs: micro_step_s: must be positive.");
  check_each(params.bodies, "body", [](const BodyParams& body) { return find_defect(body); });
  const auto against_params = [&params](const auto& element) {
    return find_defect(element, params);
  };
  check_each(params.joints, "joint", against_params);
  check_each(params.springs, "spring", against_params);
  check_each(params.joint_springs, "joint spring", against_params);
  check_each(params.forces, "force", against_params);
  check_each(params.ports, "port", against_params);
  check_each(params.bodies, "junction",
             [&params](const BodyParams& body) { return bad_junction(body, params); });
}

std::optional<std::size_t> port_at(const Params& params, const BodyParams& junction) {
  for (std::size_t p = 0; p < params.ports.size(); ++p) {
    const scenario::PortParams& port = params.ports[p];
    if (port.body == junction.name && (port.at_body_frame || port.p_WP == junction.p_WB)) return p;
  }
  return std::nullopt;
}

std::optional<Defect> bad_junction(const BodyParams& body, const Params& params) {
  if (!body.massless) return std::nullopt;
  const std::string ports = ports_on(body, params);
  if (ports.empty()) {
    return Defect{"name",
                  "no port is on it, and without mass nothing says how it moves. Name it as the "
                  "body of a port, or remove it."};
  }
  if (params.micro_step && *params.micro_step != params.macro_step) {
    return Defect{"name",
                  "junctions and mbs.micro_step_s do not go together: what has no mass is balanced "
                  "over macro steps alone. Leave the micro step out and shorten "
                  "run.macro_step_s."};
  }
  if (port_at(params, body)) return std::nullopt;
  return Defect{"position_m",
                "none of its ports (" + ports + ") stands there. Set it to the position_m of one."};
}

std::optional<std::size_t> body_index(const Params& params, const std::string& name) {
  if (name == kWorld) return std::nullopt;
  for (std::size_t i = 0; i < params.bodies.size(); ++i) {
    if (params.bodies[i].name == name) return i;
  }
  throw std::out_of_range("no body '" + name + "'");
}

}  // namespace tandem::mbs

#include "mbs_process/loads.h"

namespace tandem::mbs {
namespace {

Anchor anchor_at(const Params& params, const std::string& body, const Eigen::Vector3d& p_W) {
  const auto index = body_index(params, body);
  if (!index) return {std::nullopt, p_W};
  const BodyParams& owner = params.bodies[*index];
  return {index, owner.q_WB.conjugate() * (p_W - owner.p_WB)};
}

/// Where an anchor is, how fast it moves, and its lever arm from the centre of mass.
struct AnchorMotion {
  Eigen::Vector3d p_WA, v_WA, r_BA_W;
};

AnchorMotion motion_of(const Anchor& anchor, const State& state) {
  if (!anchor.body) return {anchor.p_BA, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  const BodyState& body = state.bodies[*anchor.body];
  const Eigen::Vector3d r = body.q_WB * anchor.p_BA;
  return {body.p_WB + r, body.v_WB + body.w_WB.cross(r), r};
}

/// f on end 1 and −f on end 2.
void add_pair(const Anchor& end1, const AnchorMotion& m1, const Anchor& end2,
              const AnchorMotion& m2, const Eigen::Vector3d& f, std::vector<BodyWrench>& to) {
  if (end1.body) to[*end1.body].add_at(m1.r_BA_W, f);
  if (end2.body) to[*end2.body].add_at(m2.r_BA_W, -f);
}

/// Unit vector along d; zero when d is, so that ends that meet exert nothing on each other.
Eigen::Vector3d direction_of(const Eigen::Vector3d& d, double length) {
  return length > 0.0 ? Eigen::Vector3d(d / length) : Eigen::Vector3d::Zero();
}

}  // namespace

Loads::Loads(const Params& params) {
  for (const SpringParams& spring : params.springs) {
    const double length = (spring.p2_W - spring.p1_W).norm();
    springs_.push_back({.end1 = anchor_at(params, spring.body1, spring.p1_W),
                        .end2 = anchor_at(params, spring.body2, spring.p2_W),
                        .stiffness_N_per_m = spring.stiffness_N_per_m,
                        .damping_N_s_per_m = spring.damping_N_s_per_m,
                        .rest_length_m = spring.rest_length_m.value_or(length)});
    data_.push_back({.name = spring.name,
                     .stiffness = spring.stiffness_N_per_m,
                     .damping = spring.damping_N_s_per_m,
                     .body1 = body_index(params, spring.body1).value()});
  }
  for (const JointSpringParams& spring : params.joint_springs) {
    for (std::size_t j = 0; j < params.joints.size(); ++j) {
      const JointParams& joint = params.joints[j];
      if (joint.name != spring.joint) continue;
      const std::size_t body1 = body_index(params, joint.body1).value();
      joint_springs_.push_back(
          {.joint = j,
           .body1 = body1,
           .body2 = body_index(params, joint.body2),
           .axis_B1 = params.bodies[body1].q_WB.conjugate() * joint.axis_W.normalized(),
           .slider = joint.kind == JointKind::Slider,
           .stiffness = spring.stiffness,
           .damping = spring.damping,
           .rest = spring.rest});
      data_.push_back({.name = spring.name,
                       .stiffness = spring.stiffness,
                       .damping = spring.damping,
                       .body1 = body1,
                       .turns = joint.kind != JointKind::Slider});
    }
  }
  for (const ForceParams& force : params.forces) {
    forces_.push_back({.body = body_index(params, force.body).value(),
                       .torque = force.kind == ForceParams::Kind::Torque,
                       .p_BF = force.p_BF,
                       .direction_W = force.direction_W.normalized(),
                       .law = force.law});
  }
}

void Loads::add_to(const State& state, double t_end_s, std::vector<BodyWrench>& applied,
                   SortedWrenches& sorted) const {
  for (const Spring& spring : springs_) add_spring(spring, state, applied, sorted);
  for (const JointSpring& spring : joint_springs_) add_joint_spring(spring, state, applied, sorted);
  for (const Force& force : forces_) {
    const Eigen::Vector3d value = force.law(t_end_s) * force.direction_W;
    for (std::vector<BodyWrench>* to : {&applied, &sorted.driven}) {
      if (force.torque) {
        (*to)[force.body].t_B_W += value;
      } else {
        (*to)[force.body].add_at(state.bodies[force.body].q_WB * force.p_BF, value);
      }
    }
  }
}

void Loads::add_spring(const Spring& spring, const State& state, std::vector<BodyWrench>& applied,
                       SortedWrenches& sorted) const {
  const AnchorMotion m1 = motion_of(spring.end1, state);
  const AnchorMotion m2 = motion_of(spring.end2, state);
  const Eigen::Vector3d d = m2.p_WA - m1.p_WA;
  const double length = d.norm();
  const Eigen::Vector3d u = direction_of(d, length);
  // f = [k (l − l0) + c l̇] u on end 1
  const double rate = u.dot(m2.v_WA - m1.v_WA);
  const Eigen::Vector3d elastic = spring.stiffness_N_per_m * (length - spring.rest_length_m) * u;
  const Eigen::Vector3d viscous = spring.damping_N_s_per_m * rate * u;
  add_pair(spring.end1, m1, spring.end2, m2, elastic + viscous, applied);
  add_pair(spring.end1, m1, spring.end2, m2, elastic, sorted.elastic);
  add_pair(spring.end1, m1, spring.end2, m2, viscous, sorted.viscous);
}

double Loads::rate_of(const JointSpring& spring, const State& state) {
  const BodyState& body1 = state.bodies[spring.body1];
  const BodyState other = spring.body2 ? state.bodies[*spring.body2] : BodyState{};
  const Eigen::Vector3d axis = body1.q_WB * spring.axis_B1;
  // A slider's pair meets at the centre of body1: it lets no other relative motion pass.
  const Eigen::Vector3d r2 = body1.p_WB - other.p_WB;
  return axis.dot(spring.slider ? Eigen::Vector3d(body1.v_WB - other.v_WB - other.w_WB.cross(r2))
                                : Eigen::Vector3d(body1.w_WB - other.w_WB));
}

void Loads::add_effort_on_body1(const JointSpring& spring, double effort, const State& state,
                                std::vector<BodyWrench>& to) {
  const BodyState& body1 = state.bodies[spring.body1];
  const Eigen::Vector3d axis = body1.q_WB * spring.axis_B1;
  if (spring.slider) {
    to[spring.body1].f_B_W += effort * axis;
    if (!spring.body2) return;
    to[*spring.body2].add_at(body1.p_WB - state.bodies[*spring.body2].p_WB, -effort * axis);
  } else {
    to[spring.body1].t_B_W += effort * axis;
    if (spring.body2) to[*spring.body2].t_B_W -= effort * axis;
  }
}

void Loads::add_joint_spring(const JointSpring& spring, const State& state,
                             std::vector<BodyWrench>& applied, SortedWrenches& sorted) const {
  const double viscous = -spring.damping * rate_of(spring, state);
  const double elastic =
      -spring.stiffness * (state.joint_coordinates[spring.joint][0] - spring.rest);
  add_effort_on_body1(spring, elastic + viscous, state, applied);
  add_effort_on_body1(spring, elastic, state, sorted.elastic);
  add_effort_on_body1(spring, viscous, state, sorted.viscous);
}

void Loads::add_effort(std::size_t i, double effort, const State& state,
                       std::vector<BodyWrench>& applied) const {
  if (i >= springs_.size()) {
    add_effort_on_body1(joint_springs_[i - springs_.size()], -effort, state, applied);
    return;
  }
  const Spring& spring = springs_[i];
  const AnchorMotion m1 = motion_of(spring.end1, state);
  const AnchorMotion m2 = motion_of(spring.end2, state);
  const Eigen::Vector3d d = m2.p_WA - m1.p_WA;
  add_pair(spring.end1, m1, spring.end2, m2, effort * direction_of(d, d.norm()), applied);
}

double Loads::rate(std::size_t i, const State& state) const {
  if (i >= springs_.size()) return rate_of(joint_springs_[i - springs_.size()], state);
  const AnchorMotion m1 = motion_of(springs_[i].end1, state);
  const AnchorMotion m2 = motion_of(springs_[i].end2, state);
  const Eigen::Vector3d d = m2.p_WA - m1.p_WA;
  return direction_of(d, d.norm()).dot(m2.v_WA - m1.v_WA);
}

double Loads::spring_energy_J(const State& state) const {
  double energy = 0.0;
  for (const Spring& spring : springs_) {
    const double length =
        (motion_of(spring.end2, state).p_WA - motion_of(spring.end1, state).p_WA).norm();
    const double stretch = length - spring.rest_length_m;
    energy += 0.5 * spring.stiffness_N_per_m * stretch * stretch;
  }
  for (const JointSpring& spring : joint_springs_) {
    const double stretch = state.joint_coordinates[spring.joint][0] - spring.rest;
    energy += 0.5 * spring.stiffness * stretch * stretch;
  }
  return energy;
}

}  // namespace tandem::mbs

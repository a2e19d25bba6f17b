#include "fem_process/turning/carry.h"

#include <Eigen/Dense>

#include "fem_process/kernels/turn.h"
#include "fem_process/turning/end_carry.h"
#include "fem_process/turning/middle_carry.h"

namespace tandem::fem {

Carry::Carry(const Model& model, const LoosePorts& loose)
    : model_(model),
      loose_(loose),
      parts_(body_parts(model)),
      part_of_port_(model.ports.size(), 0),
      rotates_(model.params.formulation != FormulationKind::Linear && model.integrator->inertia()) {
  for (std::size_t s = parts_.size(); s-- > 0;) {
    for (int holder : parts_[s].holders) {
      if (holder != BodyPart::kGround) part_of_port_[static_cast<std::size_t>(holder)] = s;
    }
  }
}

double Carry::mass(const BodyPart& part) const {
  double sum = 0.0;
  for (int node : part.nodes) sum += model_.nodal_mass[static_cast<std::size_t>(node)];
  return sum;
}

Eigen::Vector3d Carry::mean(const BodyPart& part, const Eigen::VectorXd& field) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int node : part.nodes) {
    sum += model_.nodal_mass[static_cast<std::size_t>(node)] * field.segment<3>(3 * node);
  }
  return sum / mass(part);
}

/// ω of the angular momentum about the mass centre: J ω = Σ m r × (v − V), J = Σ m (|r|² 1 − r rᵀ).
Carry::OwnMotion Carry::own_motion(const BodyPart& part, const Eigen::VectorXd& x,
                                   const Eigen::VectorXd& v) const {
  OwnMotion own{
      .centre = mean(part, x), .velocity = mean(part, v), .omega = Eigen::Vector3d::Zero()};
  if (!rotates_) return own;
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  Eigen::Vector3d L = Eigen::Vector3d::Zero();
  for (int node : part.nodes) {
    const double m = model_.nodal_mass[static_cast<std::size_t>(node)];
    const Eigen::Vector3d r = x.segment<3>(3 * node) - own.centre;
    J += m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    L += m * r.cross(v.segment<3>(3 * node) - own.velocity);
  }
  own.omega = J.ldlt().solve(L);
  return own;
}

void Carry::turn(const Eigen::Vector3d& omega, double h_s, Carried::Turn& turn) const {
  turn.omega = omega;
  turn.Q = turned_by(h_s * omega);
  turn.half = turned_by(0.5 * h_s * omega);
  turn.mean = mean_over(h_s * omega);
}

MotionSet Carry::turned_by_half(const Carried& carried) const {
  MotionSet motions = carried.ports;
  for (std::size_t p = 0; p < motions.size(); ++p) {
    const Carried::Turn& turn = carried.turns[part_of_port_[p]];
    motions[p].p_WP = turn.about + turn.half * (motions[p].p_WP - turn.about);
    motions[p].q_WP = Eigen::Quaterniond(turn.half) * motions[p].q_WP;
  }
  return motions;
}

Eigen::Vector3d Carry::ground(const BodyPart& part, const Eigen::VectorXd& x) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (int node : model_.fixed) {
    if (!std::binary_search(part.nodes.begin(), part.nodes.end(), node)) continue;
    sum += x.segment<3>(3 * node);
    count += 1.0;
  }
  return sum / count;
}

Eigen::VectorXd Carry::reference(const State& begin, const Carried& carried, const MotionSet& end,
                                 const Eigen::VectorXd& f_ext) const {
  Eigen::VectorXd v(begin.x.size());
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    const BodyPart& part = parts_[s];
    if (!part.holders.empty()) {
      refer(s, begin, carried, end, v);
      continue;
    }
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    for (int node : part.nodes) force += f_ext.segment<3>(3 * node);
    const Eigen::Vector3d centre = mean(part, carried.begin.v) + carried.h_s / mass(part) * force;
    for (int node : part.nodes) v.segment<3>(3 * node) = centre;
  }
  if (carried.lag.size() > 0) v += carried.lag;
  return v;
}

Eigen::VectorXd Carry::reference_at(const State& state, const MotionSet& motions) const {
  Eigen::VectorXd v = Eigen::VectorXd::Zero(state.x.size());
  for (const BodyPart& part : parts_) {
    if (part.holders.empty()) {
      const OwnMotion own = own_motion(part, state.x, state.v);
      for (int node : part.nodes) {
        v.segment<3>(3 * node) =
            own.velocity +
            own.omega.cross(Eigen::Vector3d(state.x.segment<3>(3 * node) - own.centre));
      }
    }
    if (part.holders.empty()) continue;
    const double share = 1.0 / static_cast<double>(part.holders.size());
    Motion rigid;
    for (int holder : part.holders) {
      if (holder == BodyPart::kGround) {
        rigid.p_WP += share * ground(part, state.x);
        continue;
      }
      const Motion& motion = motions[static_cast<std::size_t>(holder)];
      rigid.p_WP += share * motion.p_WP;
      rigid.v_WP += share * motion.v_WP;
      rigid.w_WP += share * motion.w_WP;
    }
    for (int node : part.nodes) {
      const Eigen::Vector3d arm = state.x.segment<3>(3 * node) - rigid.p_WP;
      v.segment<3>(3 * node) = rigid.v_WP + rigid.w_WP.cross(arm);
    }
  }
  return v;
}

std::unique_ptr<const Carry> make_carry(const Model& model, const LoosePorts& loose) {
  if (model.integrator->keeps_history()) return std::make_unique<EndCarry>(model, loose);
  return std::make_unique<MiddleCarry>(model, loose);
}

}  // namespace tandem::fem

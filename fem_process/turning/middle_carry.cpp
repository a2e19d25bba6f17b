#include "fem_process/turning/middle_carry.h"

#include <utility>

namespace tandem::fem {

Carried MiddleCarry::begin(const State& state, double h_s) const {
  Carried carried;
  carried.h_s = h_s;
  carried.ports = state.port_motions;
  carried.back.assign(loose_.ports().size(), Eigen::Matrix3d::Identity());
  carried.begin.x = state.x;
  carried.begin.v = state.v;
  carried.turns.resize(parts_.size());
  carried.velocity = Eigen::VectorXd::Zero(state.x.size());
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    const OwnMotion own = own_motion(parts_[s], state.x, state.v);
    Carried::Turn& turn = carried.turns[s];
    this->turn(own.omega, h_s, turn);
    turn.about = own.centre;
    if (own.omega.isZero(0.0)) continue;
    carried.turning = true;
    for (int node : parts_[s].nodes) {
      const Eigen::Vector3d half = turn.half * (state.x.segment<3>(3 * node) - own.centre);
      carried.begin.x.segment<3>(3 * node) = own.centre + half;
      const Eigen::Vector3d velocity = own.omega.cross(Eigen::Vector3d(turn.half * half));
      carried.velocity.segment<3>(3 * node) = velocity;
      carried.begin.v.segment<3>(3 * node) -= velocity;
    }
  }
  carried.drag = carried.velocity;
  carried.map = model_.integrator->map(carried.begin, h_s);
  return carried;
}

Motion MiddleCarry::seen_ground(const Carried::Turn& turn, const Eigen::Vector3d& at) const {
  Motion motion;
  motion.v_WP = -turn.omega.cross(Eigen::Vector3d(turn.Q * (at - turn.about)));
  motion.w_WP = -turn.omega;
  return motion;
}

MotionSet MiddleCarry::seen(const Carried& carried, const MotionSet& end) const {
  MotionSet motions = end;
  if (!model_.integrator->inertia()) return motions;
  for (std::size_t p = 0; p < end.size(); ++p) {
    const Carried::Turn& turn = carried.turns[part_of_port_[p]];
    const Eigen::Vector3d at = carried.ports[p].p_WP;
    const Motion still = seen_ground(turn, at);
    motions[p].v_WP += still.v_WP;
    motions[p].w_WP += still.w_WP;
    motions[p].p_WP = turn.about + turn.half * (at - turn.about) + carried.h_s * motions[p].v_WP;
    motions[p].q_WP = Eigen::Quaterniond(Eigen::Matrix3d(turn.half.transpose())) * end[p].q_WP;
  }
  return motions;
}

Eigen::VectorXd port_chords(const MotionSet& begin, const MotionSet& end, double h_s) {
  Eigen::VectorXd chords(static_cast<Eigen::Index>(end.size()));
  for (std::size_t p = 0; p < end.size(); ++p) {
    const Eigen::Vector3d way = end[p].p_WP - begin[p].p_WP;
    const Eigen::Vector3d mean = 0.5 * (begin[p].v_WP + end[p].v_WP);
    const bool by_end = (way - h_s * end[p].v_WP).norm() <= (way - h_s * mean).norm();
    chords[static_cast<Eigen::Index>(p)] = by_end ? 1.0 : 0.0;
  }
  return chords;
}

namespace {

/// ω × Q r − (Q − 1) r / h, r from the centre of the turn to `at` (m/s).
Eigen::Vector3d chord_lag(const Carried::Turn& turn, const Eigen::Vector3d& at, double h_s) {
  const Eigen::Vector3d r = at - turn.about;
  const Eigen::Vector3d chord = (turn.Q - Eigen::Matrix3d::Identity()) * r;
  return turn.omega.cross(Eigen::Vector3d(turn.Q * r)) - chord / h_s;
}

}  // namespace

void MiddleCarry::refer(std::size_t s, const State& begin, const Carried& carried,
                        const MotionSet& end, Eigen::VectorXd& v) const {
  const MotionSet ports = seen(carried, end);
  const BodyPart& part = parts_[s];
  const Carried::Turn& turn = carried.turns[s];
  const double share = 1.0 / static_cast<double>(part.holders.size());
  Motion rigid;  // mean of the holders
  // e_k / h of conclude() on a circle: a port that steps by h times the velocity at its end takes a
  // tangent for the chord, and is led away from the circle by ω² h/2 of its radius, which is no
  // strain of the body. Of the beginning of the step alone, so that forces depend on velocities as
  // ever.
  std::vector<Eigen::Vector3d> astray;
  for (int holder : part.holders) {
    const bool fixed = holder == BodyPart::kGround;
    const auto p = static_cast<std::size_t>(holder);
    const Eigen::Vector3d at = fixed ? ground(part, begin.x) : carried.ports[p].p_WP;
    const Motion motion = fixed ? seen_ground(turn, at) : ports[p];
    const bool by_chord = !fixed && begin.port_chords.size() > 0 && begin.port_chords[holder] > 0.5;
    astray.push_back(by_chord ? chord_lag(turn, at, carried.h_s) : Eigen::Vector3d::Zero().eval());
    rigid.p_WP += share * (turn.about + turn.half * (at - turn.about));
    rigid.v_WP += share * (motion.v_WP + astray.back());
    rigid.w_WP += share * motion.w_WP;
  }
  for (std::size_t i = 0; i < part.nodes.size(); ++i) {
    const Eigen::Index row = 3 * part.nodes[i];
    const Eigen::Vector3d arm = carried.map.x_tilde.segment<3>(row) - rigid.p_WP;
    Eigen::Vector3d velocity = rigid.v_WP + rigid.w_WP.cross(arm);
    for (std::size_t k = 0; k < astray.size(); ++k) {
      velocity -=
          part.shares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) * astray[k];
    }
    v.segment<3>(row) = velocity;
  }
}

void MiddleCarry::see_prescribed(const Carried& carried, Eigen::VectorXd& v) const {
  for (int node : model_.prescribed)
    v.segment<3>(3 * node) -= carried.velocity.segment<3>(3 * node);
}

void MiddleCarry::take_mean(const Carried& carried, Eigen::VectorXd& f) const {
  if (!carried.turning) return;
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    const Eigen::Matrix3d& T = carried.turns[s].mean;
    for (int node : parts_[s].nodes) f.segment<3>(3 * node) = (T * f.segment<3>(3 * node)).eval();
  }
}

void MiddleCarry::conclude(const State& begin, const Carried& carried, Made made,
                           State& after) const {
  after.port_motions = made.end;
  const double h = carried.h_s;
  Eigen::VectorXd x = made.x;
  if (model_.integrator->inertia()) {
    for (std::size_t s = 0; s < parts_.size(); ++s) {
      const BodyPart& part = parts_[s];
      const Carried::Turn& turn = carried.turns[s];
      const Eigen::Vector3d along = h * mean(part, made.v);
      // Small terms first: the rounding of positions enters forces with the stiffness.
      const Eigen::Matrix3d turned = turn.Q - Eigen::Matrix3d::Identity();
      const auto place = [&](const Eigen::Vector3d& at, const Eigen::Vector3d& d) {
        return Eigen::Vector3d(at +
                               (turned * (at - turn.about) + (along + turn.half * (d - along))));
      };
      for (int node : part.nodes) {
        const Eigen::Index row = 3 * node;
        x.segment<3>(row) = place(begin.x.segment<3>(row),
                                  made.x.segment<3>(row) - carried.begin.x.segment<3>(row));
      }
      for (std::size_t k = 0; k < part.holders.size(); ++k) {
        const int holder = part.holders[k];
        const bool fixed = holder == BodyPart::kGround;
        const auto p = static_cast<std::size_t>(holder);
        const Eigen::Vector3d at = fixed ? ground(part, begin.x) : carried.ports[p].p_WP;
        const Eigen::Vector3d to = fixed ? at : made.end[p].p_WP;
        const Eigen::Vector3d rate = seen_ground(turn, at).v_WP +
                                     (fixed ? Eigen::Vector3d::Zero().eval() : made.end[p].v_WP);
        const Eigen::Vector3d e = to - place(at, h * rate);
        for (std::size_t i = 0; i < part.nodes.size(); ++i) {
          x.segment<3>(3 * part.nodes[i]) +=
              part.shares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) * e;
        }
      }
    }
    // Nodes with prescribed motion are where that says.
    for (int node : model_.prescribed) x.segment<3>(3 * node) = made.x.segment<3>(3 * node);
  }
  after.x = std::move(x);
  after.v = made.v + carried.velocity;
}

}  // namespace tandem::fem

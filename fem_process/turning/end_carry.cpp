#include "fem_process/turning/end_carry.h"

#include <algorithm>
#include <utility>

#include "fem_process/kernels/turn.h"
#include "fem_process/matrix/node_vectors.h"

namespace tandem::fem {
namespace {

/// ω × (ω × r).
Eigen::Vector3d centripetal(const Eigen::Vector3d& omega, const Eigen::Vector3d& r) {
  return omega.cross(Eigen::Vector3d(omega.cross(r)));
}

/// What the difference formula for the accelerations of prescribed nodes,
///   q⁺ = (3/2 (v⁺ − v) − 1/2 (v − v⁻))/h,
/// lacks for a point that turns with its port at r, at the rate w.
Eigen::Vector3d lacking(const Eigen::Vector3d& w, const Eigen::Vector3d& r, double h_s) {
  const Eigen::Matrix3d Q = turned_by(h_s * w);
  const Eigen::Vector3d before = w.cross(Eigen::Vector3d(Q.transpose() * r));
  const Eigen::Vector3d now = w.cross(r);
  const Eigen::Vector3d end = Q * r;
  const Eigen::Vector3d found = (1.5 * (w.cross(end) - now) - 0.5 * (now - before)) / h_s;
  return centripetal(w, end) - found;
}

/// The ports' origins as nodes.
State holder_state(const State& state) {
  State holder;
  holder.x.resize(3 * static_cast<Eigen::Index>(state.port_motions.size()));
  holder.v.resize(holder.x.size());
  for (std::size_t p = 0; p < state.port_motions.size(); ++p) {
    holder.x.segment<3>(3 * static_cast<Eigen::Index>(p)) = state.port_motions[p].p_WP;
    holder.v.segment<3>(3 * static_cast<Eigen::Index>(p)) = state.port_motions[p].v_WP;
  }
  holder.a = state.port_rates.a;
  holder.acceleration = state.port_rates.acceleration;
  holder.a_mean = state.port_rates.a_mean;
  return holder;
}

/// Rows of a port among those of the loose ports: its arm (origin: true) and axes at a pose.
Vector12 arms_of(const LoosePorts::Port& port, const Motion& motion) {
  Vector12 arms = rigid_coordinates(port.average, motion);
  arms.head<3>() -= motion.p_WP;
  return arms;
}

}  // namespace

/// A light body on a bushing swings against the part, which its rate would then shake.
bool EndCarry::turns_by_itself(const BodyPart& part) const {
  return part.holders.empty() ||
         std::any_of(part.holders.begin(), part.holders.end(), [this](int holder) {
           return holder != BodyPart::kGround &&
                  model_.ports[static_cast<std::size_t>(holder)].attachment.kind ==
                      scenario::AttachmentKind::Bushing;
         });
}

Eigen::Vector3d EndCarry::holders_rate(const BodyPart& part, const MotionSet& ports) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int holder : part.holders) {
    if (holder != BodyPart::kGround) sum += ports[static_cast<std::size_t>(holder)].w_WP;
  }
  return sum / static_cast<double>(part.holders.size());
}

/// Per node of a part, in their order.
std::vector<EndCarry::Origin> EndCarry::origins(const BodyPart& part, const State& state) const {
  if (part.holders.empty()) {
    const Origin own{.p = mean(part, state.x),
                     .v = mean(part, state.v),
                     .a = mean(part, state.a),
                     .q = mean(part, state.acceleration)};
    return std::vector<Origin>(part.nodes.size(), own);
  }
  std::vector<Origin> origins(part.nodes.size());
  for (std::size_t k = 0; k < part.holders.size(); ++k) {
    Origin holder;
    if (part.holders[k] == BodyPart::kGround) {
      holder.p = ground(part, state.x);
    } else {
      const Motion& motion = state.port_motions[static_cast<std::size_t>(part.holders[k])];
      const Eigen::Index row = 3 * part.holders[k];
      holder = {.p = motion.p_WP,
                .v = motion.v_WP,
                .a = at(state.port_rates.a, row),
                .q = at(state.port_rates.acceleration, row)};
    }
    for (std::size_t i = 0; i < part.nodes.size(); ++i) {
      const double share = part.shares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      origins[i].p += share * holder.p;
      origins[i].v += share * holder.v;
      origins[i].a += share * holder.a;
      origins[i].q += share * holder.q;
    }
  }
  return origins;
}

void EndCarry::see(const BodyPart& part, const State& state, const Carried::Turn& turn,
                   Carried& carried, Eigen::VectorXd& x_tilde,
                   Eigen::VectorXd& centripetal_a) const {
  const std::vector<Origin> origins = this->origins(part, state);
  const Eigen::Matrix3d& Q = turn.Q;
  for (std::size_t i = 0; i < part.nodes.size(); ++i) {
    const Eigen::Index row = 3 * part.nodes[i];
    const Origin& o = origins[i];
    const Eigen::Vector3d r = at(state.x, row) - o.p;
    const Eigen::Vector3d inward = centripetal(turn.omega, r);
    const Eigen::Vector3d v = at(state.v, row) - turn.omega.cross(r);
    carried.begin.x.segment<3>(row) = o.p + Q * r;
    carried.begin.v.segment<3>(row) = v;
    carried.begin.a.segment<3>(row) = o.a + Q * (at(state.a, row) - o.a - inward);
    carried.begin.acceleration.segment<3>(row) =
        o.q + Q * (at(state.acceleration, row) - o.q - inward);
    carried.lag.segment<3>(row) = (v - o.v) - Q.transpose() * (v - o.v);
    const Eigen::Vector3d relative = state.relative_velocity.size() > 0
                                         ? Eigen::Vector3d(Q * at(state.relative_velocity, row))
                                         : Eigen::Vector3d(v - o.v);
    x_tilde.segment<3>(row) = carried.begin.x.segment<3>(row) + carried.h_s * (o.v + relative);
    const Eigen::Vector3d arm = Q * r + carried.h_s * relative;
    centripetal_a.segment<3>(row) = centripetal(turn.omega, arm);
    carried.drag.segment<3>(row) = turn.omega.cross(arm) - at(carried.lag, row);
  }
}

/// The rigid parts of averaging ports' nodes and of bushings, as their nodes.
void EndCarry::see_rigid(const State& state, Carried& carried) const {
  State& begin = carried.begin;
  begin.rigid = state.rigid;
  Eigen::VectorXd lacking_a(loose_.size());
  Eigen::VectorXd centripetal_a(loose_.size());
  for (std::size_t k = 0; k < loose_.ports().size(); ++k) {
    const LoosePorts::Port& port = loose_.ports()[k];
    const Motion& motion = state.port_motions[port.index];
    const Carried::Turn& turn = carried.turns[part_of_port_[port.index]];
    const Vector12 arms = arms_of(port, motion);
    carried.back.push_back(turn.Q.transpose());
    for (int j = 0; j < 12; j += 3) {
      const Eigen::Index row = 12 * static_cast<Eigen::Index>(k) + j;
      const Eigen::Index origin = 3 * static_cast<Eigen::Index>(port.index);
      const Eigen::Vector3d a = j == 0 ? at(state.port_rates.a, origin) : Eigen::Vector3d::Zero();
      const Eigen::Vector3d q =
          j == 0 ? at(state.port_rates.acceleration, origin) : Eigen::Vector3d::Zero();
      const Eigen::Vector3d r = arms.segment<3>(j);
      const Eigen::Vector3d inward = centripetal(turn.omega, r);
      begin.rigid.v.segment<3>(row) -= turn.omega.cross(r);
      begin.rigid.a.segment<3>(row) = a + turn.Q * (at(state.rigid.a, row) - a - inward);
      if (state.rigid.acceleration.size() > 0) {
        begin.rigid.acceleration.segment<3>(row) =
            q + turn.Q * (at(state.rigid.acceleration, row) - q - inward);
      }
      lacking_a.segment<3>(row) = lacking(motion.w_WP, r, carried.h_s);
      centripetal_a.segment<3>(row) =
          centripetal(turn.omega, turned_by(carried.h_s * motion.w_WP) * r);
    }
  }
  carried.rigid = loose_.rigid_step(*model_.integrator, begin, carried.h_s);
  carried.rigid.map.a_hat += centripetal_a;
  // Accelerations of prescribed motions follow from velocities in W.
  State in_world;
  in_world.x = Eigen::VectorXd::Zero(loose_.size());
  in_world.v = state.rigid.v;
  in_world.a = state.rigid.a;
  in_world.acceleration = state.rigid.acceleration;
  in_world.a_mean = state.rigid.a_mean;
  carried.rigid.map.a_hat_prescribed =
      model_.integrator->map(in_world, carried.h_s).a_hat_prescribed + lacking_a;
}

void EndCarry::turn_prescribed(const State& state, Carried& carried) const {
  for (int node : model_.prescribed) {
    carried.begin.v.segment<3>(3 * node) = state.v.segment<3>(3 * node);
  }
  carried.begin.a_mean = state.a_mean;
}

Carried EndCarry::begin(const State& state, double h_s) const {
  Carried carried;
  carried.h_s = h_s;
  carried.ports = state.port_motions;
  carried.turns.resize(parts_.size());
  State& begin = carried.begin;
  for (Eigen::VectorXd* field : {&begin.x, &begin.v, &begin.a, &begin.acceleration}) {
    field->resize(state.x.size());
  }
  carried.lag.resize(state.x.size());
  carried.drag.resize(state.x.size());
  Eigen::VectorXd x_tilde(state.x.size());
  Eigen::VectorXd centripetal_a(state.x.size());
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    const BodyPart& part = parts_[s];
    Eigen::Vector3d omega = Eigen::Vector3d::Zero();
    if (rotates_) {
      omega = turns_by_itself(part) ? own_motion(part, state.x, state.v).omega
                                    : holders_rate(part, state.port_motions);
    }
    turn(omega, h_s, carried.turns[s]);
    lead_circles(*model_.integrator, h_s, carried.turns[s]);
    carried.turning = carried.turning || !omega.isZero(0.0);
    see(part, state, carried.turns[s], carried, x_tilde, centripetal_a);
  }
  turn_prescribed(state, carried);
  carried.map = model_.integrator->map(begin, h_s);
  carried.map.a_hat += centripetal_a;
  carried.map.d_hat += carried.map.x_tilde - x_tilde;
  carried.map.x_tilde = std::move(x_tilde);
  for (std::size_t p = 0; p < model_.ports.size(); ++p) {
    if (model_.ports[p].attachment.loose()) continue;
    const Motion& motion = state.port_motions[p];
    for (int node : model_.ports[p].nodes) {
      carried.map.a_hat_prescribed.segment<3>(3 * node) +=
          lacking(motion.w_WP, at(state.x, 3 * node) - motion.p_WP, h_s);
    }
  }
  carried.holder = holder_state(state);
  carried.holder_map = model_.integrator->map(carried.holder, h_s);
  see_rigid(state, carried);
  return carried;
}

namespace {

/// Rigid velocities with the mean motion of what holds a part.
Motion mean_of(const std::vector<Motion>& holders) {
  const double share = 1.0 / static_cast<double>(holders.size());
  Motion mean;
  for (const Motion& holder : holders) {
    mean.p_WP += share * holder.p_WP;
    mean.v_WP += share * holder.v_WP;
    mean.w_WP += share * holder.w_WP;
  }
  return mean;
}

}  // namespace

/// y = v_o + Q (u − v_o − ω × (x̃ − p_o)) of the rigid velocities u with the mean motion of the
/// holders, (p_o, v_o) what carries the node at the end of the step. Carried::lag takes all of a
/// node's velocity beyond what carries it for damped; of u − v_o − ω × r at the beginning, where
/// holders move against each other, it is taken back.
void EndCarry::refer(std::size_t s, const State& begin, const Carried& carried,
                     const MotionSet& end, Eigen::VectorXd& v) const {
  const BodyPart& part = parts_[s];
  const Carried::Turn& turn = carried.turns[s];
  const auto holders_of = [&](const MotionSet& ports) {
    std::vector<Motion> holders;
    for (int holder : part.holders) {
      Motion& motion = holders.emplace_back();
      if (holder == BodyPart::kGround) {
        motion.p_WP = ground(part, begin.x);
      } else {
        motion = ports[static_cast<std::size_t>(holder)];
      }
    }
    return holders;
  };
  const std::vector<Motion> holders = holders_of(end), before = holders_of(carried.ports);
  const Motion rigid = mean_of(holders), rigid_before = mean_of(before);
  for (std::size_t i = 0; i < part.nodes.size(); ++i) {
    const Eigen::Index row = 3 * part.nodes[i];
    const Eigen::Vector3d x = at(carried.map.x_tilde, row);
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_o = Eigen::Vector3d::Zero();
    Eigen::Vector3d p_before = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_before = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < holders.size(); ++k) {
      const double phi = part.shares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      p += phi * holders[k].p_WP;
      v_o += phi * holders[k].v_WP;
      p_before += phi * before[k].p_WP;
      v_before += phi * before[k].v_WP;
    }
    const Eigen::Vector3d x_before = at(begin.x, row);
    const Eigen::Vector3d apart =
        rigid_before.v_WP + rigid_before.w_WP.cross(Eigen::Vector3d(x_before - rigid_before.p_WP)) -
        v_before - turn.omega.cross(Eigen::Vector3d(x_before - p_before));
    const Eigen::Vector3d u = rigid.v_WP + rigid.w_WP.cross(Eigen::Vector3d(x - rigid.p_WP));
    v.segment<3>(row) = v_o + turn.Q * (u - v_o - turn.omega.cross(Eigen::Vector3d(x - p))) -
                        (apart - turn.Q.transpose() * apart);
  }
}

MotionSet EndCarry::seen(const Carried& carried, const MotionSet& end) const {
  MotionSet motions = end;
  for (std::size_t p = 0; p < end.size(); ++p) {
    const Carried::Turn& turn = carried.turns[part_of_port_[p]];
    motions[p].w_WP = turn.Q * (end[p].w_WP - turn.omega);
  }
  return motions;
}

Eigen::VectorXd EndCarry::spread(const std::vector<Eigen::Vector3d>& of_port) const {
  Eigen::VectorXd field = Eigen::VectorXd::Zero(3 * model_.mesh.nodes());
  for (const BodyPart& part : parts_) {
    for (std::size_t k = 0; k < part.holders.size(); ++k) {
      if (part.holders[k] == BodyPart::kGround) continue;
      const Eigen::Vector3d& e = of_port[static_cast<std::size_t>(part.holders[k])];
      for (std::size_t i = 0; i < part.nodes.size(); ++i) {
        field.segment<3>(3 * part.nodes[i]) +=
            part.shares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) * e;
      }
    }
  }
  return field;
}

Eigen::VectorXd EndCarry::drift(const Carried& carried, const MotionSet& end) const {
  const StepMap& map = carried.holder_map;
  std::vector<Eigen::Vector3d> lacking(end.size());
  for (std::size_t p = 0; p < end.size(); ++p) {
    const auto row = 3 * static_cast<Eigen::Index>(p);
    lacking[p] = end[p].p_WP - at(map.x_tilde, row) - at(map.d_hat, row) - map.c_x * end[p].v_WP;
  }
  return spread(lacking);
}

/// y = v_k + Q (v − v_k − ω × (x − p_k)) for a node of port k, from v; the ground stands at a fixed
/// node itself, where y = 0.
Eigen::VectorXd EndCarry::prescribed_shift(const Carried& carried, const MotionSet& end,
                                           const Eigen::VectorXd& x,
                                           const Eigen::VectorXd& v) const {
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(x.size());
  for (std::size_t p = 0; p < model_.ports.size(); ++p) {
    if (model_.ports[p].attachment.loose()) continue;
    const Carried::Turn& turn = carried.turns[part_of_port_[p]];
    for (int node : model_.ports[p].nodes) {
      const Eigen::Vector3d relative = at(v, 3 * node) - end[p].v_WP;
      const Eigen::Vector3d arm = at(x, 3 * node) - end[p].p_WP;
      shift.segment<3>(3 * node) = turn.Q * (relative - turn.omega.cross(arm)) - relative;
    }
  }
  return shift;
}

void EndCarry::conclude_rigid(const State& begin, const Carried& carried, const Made& made,
                              State& after) const {
  LoosePorts::Rates rates = made.rates;
  const Lead lead = this->lead(carried, made.end);
  for (std::size_t k = 0; k < loose_.ports().size(); ++k) {
    rates.v.segment<3>(12 * static_cast<Eigen::Index>(k)) += lead.sigma[loose_.ports()[k].index];
  }
  after.rigid = kept_rates(*model_.integrator, carried.begin.rigid, rates, carried.h_s);
  for (std::size_t k = 0; k < loose_.ports().size(); ++k) {
    const LoosePorts::Port& port = loose_.ports()[k];
    const Motion& motion = made.end[port.index];
    const Carried::Turn& turn = carried.turns[part_of_port_[port.index]];
    const Vector12 arms = arms_of(port, motion);
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    after.rigid.v.segment<12>(row) = rigid_rates(port.average, motion);
    for (int j = 0; j < 12; j += 3) {
      after.rigid.a.segment<3>(row + j) += centripetal(turn.omega, arms.segment<3>(j));
    }
  }
  after.rigid.a_mean = (after.rigid.v - begin.rigid.v) / carried.h_s;
}

void EndCarry::conclude(const State& begin, const Carried& carried, Made made, State& after) const {
  const Integrator& integrator = *model_.integrator;
  const double h_s = carried.h_s;
  after.x = made.x;
  const Lead lead = this->lead(carried, made.end);
  integrator.keep(carried.begin, rotates_ ? made.v + spread(lead.sigma) : made.v, made.a, h_s,
                  after);
  after.port_motions = made.end;
  State holder = holder_state(after);
  const Eigen::VectorXd a_mean = (holder.v - carried.holder.v) / h_s;
  Eigen::VectorXd v_holder = holder.v;
  for (std::size_t p = 0; p < lead.sigma.size(); ++p) {
    v_holder.segment<3>(3 * static_cast<Eigen::Index>(p)) += lead.sigma[p];
  }
  const Eigen::VectorXd q = carried.holder_map.a_hat + carried.holder_map.c_a * v_holder;
  integrator.keep(carried.holder, v_holder, q, h_s, holder);
  after.port_rates = {.v = {},
                      .a = std::move(holder.a),
                      .acceleration = std::move(holder.acceleration),
                      .a_mean = a_mean};

  after.v = made.v;
  after.relative_velocity.resize(made.x.size());
  for (std::size_t s = 0; s < parts_.size(); ++s) {
    const BodyPart& part = parts_[s];
    const Carried::Turn& turn = carried.turns[s];
    State seen;  // for the origins of a free part: means of what was solved for
    if (part.holders.empty()) {
      seen.x = made.x;
      seen.v = made.v;
      seen.a = seen.acceleration = made.a;
    }
    const std::vector<Origin> ends = origins(part, part.holders.empty() ? seen : after);
    const std::vector<Origin> begins = origins(part, begin);
    for (std::size_t i = 0; i < part.nodes.size(); ++i) {
      const Eigen::Index row = 3 * part.nodes[i];
      const Origin& o = ends[i];
      const Eigen::Vector3d r = at(made.x, row) - o.p;
      after.v.segment<3>(row) =
          o.v + turn.omega.cross(r) + turn.Q.transpose() * (at(made.v, row) - o.v);
      after.a.segment<3>(row) += centripetal(turn.omega, r);
      after.relative_velocity.segment<3>(row) =
          (r - turn.Q * (at(begin.x, row) - begins[i].p)) / h_s;
    }
  }
  // Prescribed nodes move, and are accelerated, as their motion says.
  for (int node : model_.prescribed) {
    after.v.segment<3>(3 * node) = made.v.segment<3>(3 * node);
    after.a.segment<3>(3 * node) = made.a.segment<3>(3 * node);
  }
  after.a_mean = (after.v - begin.v) / h_s;
  conclude_rigid(begin, carried, made, after);
}

}  // namespace tandem::fem

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "fem_process/transient/step_tangent.h"

/// The kinematics around the balance of forces, along a direction.
namespace tandem::fem {
namespace {

/// Motion with one of its 12 coordinates (see difference()) changed by
/// `amount`.
Motion nudged(Motion motion, Eigen::Index coordinate, double amount) {
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(coordinate % 3);
  switch (coordinate / 3) {
    case 0:
      motion.p_WP += amount * axis;
      break;
    case 1:
      motion.q_WP = Eigen::Quaterniond(Eigen::AngleAxisd(amount, axis)) * motion.q_WP;
      break;
    case 2:
      motion.v_WP += amount * axis;
      break;
    default:
      motion.w_WP += amount * axis;
  }
  return motion;
}

using Fields = std::vector<Eigen::VectorXd State::*>;

/// Vectors of a state that a step starts from.
const Fields& fields() {
  static const Fields all = {&State::x,       &State::v,
                             &State::a,       &State::acceleration,
                             &State::a_mean,  &State::relative_velocity,
                             &State::attached};
  return all;
}
constexpr Eigen::VectorXd RateHistory::*kRates[] = {
    &RateHistory::v, &RateHistory::a, &RateHistory::acceleration, &RateHistory::a_mean};
constexpr RateHistory State::*kHistories[] = {&State::rigid, &State::port_rates};

void add(const Eigen::VectorXd& change, double amount, Eigen::VectorXd& value) {
  if (change.size() > 0) value += amount * change;
}

State shifted(State state, const State& change, double amount) {
  for (const auto field : fields()) add(change.*field, amount, state.*field);
  for (const auto history : kHistories) {
    for (const auto rate : kRates) add(change.*history.*rate, amount, state.*history.*rate);
  }
  return state;
}

State slope(const State& below, const State& above, double amount) {
  State change;
  const double scale = 0.5 / amount;
  for (const auto field : fields()) change.*field = scale * (above.*field - below.*field);
  for (const auto history : kHistories) {
    for (const auto rate : kRates) {
      change.*history.*rate = scale * (above.*history.*rate - below.*history.*rate);
    }
  }
  return change;
}

double largest(const Eigen::VectorXd& x) { return x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0.0; }

}  // namespace

/// The interpolation is linear in p, v, w of the end (central differences are
/// exact) and smooth in the angle, where 1e-4 rad leaves about 1e-9.
MotionDerivative interpolation_derivative(const Segment<MotionSet>& input, double s, SimTime H,
                                          VelocityRule rule) {
  MotionDerivative derivative(input.end.size(), Eigen::Matrix<double, 12, 12>::Identity());
  if (s >= 1.0) return derivative;
  if (s <= 0.0) {
    for (auto& block : derivative) block.setZero();
    return derivative;
  }
  const double amount = 1e-4;
  for (std::size_t p = 0; p < input.end.size(); ++p) {
    for (Eigen::Index c = 0; c < 12; ++c) {
      const Segment<MotionSet> below{{input.begin[p]}, {nudged(input.end[p], c, -amount)}};
      const Segment<MotionSet> above{{input.begin[p]}, {nudged(input.end[p], c, amount)}};
      derivative[p].col(c) =
          difference(interpolate(below, s, H, rule), interpolate(above, s, H, rule)) /
          (2.0 * amount);
    }
  }
  return derivative;
}

StepTangent::Nudged StepTangent::nudge(const Step& step, const Direction& direction,
                                       double amount) const {
  MotionSet end = displaced(step.end.value, amount * direction.port_end);
  if (!direction.started()) return {step.begin, step.kept.carried, std::move(end), {}, {}};
  auto begin = std::make_unique<State>(shifted(step.begin, direction.begin, amount));
  begin->port_motions = displaced(step.begin.port_motions, amount * direction.port_begin);
  auto carried = std::make_unique<const Carried>(carry_.begin(*begin, step.kept.h_s));
  return {*begin, *carried, std::move(end), std::move(begin), std::move(carried)};
}

/// Derivatives of what the step sees of its begin and end before it is solved.
void StepTangent::see(const Step& step, Direction& direction) const {
  const Eigen::Index n = step.begin.x.size();
  if (direction.started()) {
    // 1e-5 of the body's size, and of the turn of a step.
    const double h_s = step.kept.h_s;
    const double length = (step.begin.x.reshaped(3, n / 3).rowwise().maxCoeff() -
                           step.begin.x.reshaped(3, n / 3).rowwise().minCoeff())
                              .norm();
    const double moved = std::max({largest(direction.begin.x), h_s * largest(direction.begin.v),
                                   h_s * h_s * largest(direction.begin.a)});
    direction.amount = 1e-5 / std::max(moved / length, 1e-3);
  }
  const double amount = direction.amount;
  const Nudged below = nudge(step, direction, -amount);
  const Nudged above = nudge(step, direction, amount);
  const double scale = 0.5 / amount;
  direction.dd_first.resize(0);
  direction.turning.resize(0);
  direction.dd = Eigen::VectorXd::Zero(n);
  direction.da = Eigen::VectorXd::Zero(n);
  if (direction.started()) {
    const StepMap& a = below.carried.map;
    const StepMap& b = above.carried.map;
    direction.map.x_tilde = scale * (b.x_tilde - a.x_tilde);
    direction.map.d_hat = scale * (b.d_hat - a.d_hat);
    direction.map.a_hat = scale * (b.a_hat - a.a_hat);
    direction.map.a_hat_prescribed = scale * (b.a_hat_prescribed - a.a_hat_prescribed);
    direction.dd = direction.map.d_hat;
    direction.da = direction.map.a_hat;
    turn_forces(step, below, above, direction);
  }
  const Eigen::VectorXd drift = carry_.drift(above.carried, above.end);
  if (drift.size() > 0) {
    direction.dd += scale * (drift - carry_.drift(below.carried, below.end));
  }
  direction.d_circling = carry_.circling(above.carried, above.end);
  if (direction.d_circling.size() > 0) {
    direction.d_circling =
        scale * (direction.d_circling - carry_.circling(below.carried, below.end));
    direction.da += direction.d_circling;
  }
  direction.d_seen.motions = scale * difference(carry_.seen(below.carried, below.end),
                                                carry_.seen(above.carried, above.end));
  direction.d_seen.back.resize(loose_.ports().size());
  for (std::size_t k = 0; k < loose_.ports().size(); ++k) {
    direction.d_seen.back[k] = scale * (above.carried.back[k] - below.carried.back[k]);
  }
  if (step.result.damped.size() > 0) {
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(n);
    direction.d_reference = scale * (carry_.reference(above.begin, above.carried, above.end, none) -
                                     carry_.reference(below.begin, below.carried, below.end, none));
  }
  direction.d_drag.resize(0);
  if (step.result.damped.size() > 0 && direction.started()) {
    direction.d_drag = scale * (above.carried.drag - below.carried.drag);
  }
  if (above.carried.velocity.size() > 0 && direction.started()) {
    direction.dv = -scale * (above.carried.velocity - below.carried.velocity);
    for (int node : model_.free) direction.dv.segment<3>(3 * node).setZero();
  } else {
    direction.dv = Eigen::VectorXd::Zero(n);
  }
  const TorqueArms a = step_.torque_arms(below.carried, below.end, step.about);
  const TorqueArms b = step_.torque_arms(above.carried, above.end, step.about);
  const Eigen::VectorXd pose = scale * difference(a.pose, b.pose);
  direction.d_about.resize(pose.size() / 4);
  direction.d_origin.resize(pose.size() / 4);
  direction.d_arms_turn.resize(pose.size() / 4);
  for (std::size_t p = 0; p < a.pose.size(); ++p) {
    const auto at = static_cast<Eigen::Index>(p);
    direction.d_about.segment<3>(3 * at) = scale * (b.about[p] - a.about[p]);
    direction.d_origin.segment<3>(3 * at) =
        pose.segment<3>(12 * at) - direction.d_about.segment<3>(3 * at);
    direction.d_arms_turn.segment<3>(3 * at) = pose.segment<3>(12 * at + 3);
  }
  if (!loose_.empty()) see_loose(below, above, direction);
}

/// What averaging ports add to d and a before the solve.
void StepTangent::see_loose(const Nudged& below, const Nudged& above, Direction& direction) const {
  direction.d_phi = Eigen::VectorXd::Zero(loose_.size());
  if (direction.started()) direction.d_phi = direction.begin.attached;
  if (!model_.integrator->keeps_history()) return;
  struct Added {
    Eigen::VectorXd d, a;
    LoosePorts::Rates rates;
  };
  const auto prescribe = [&](const Nudged& nudged) {
    const Carried& carried = nudged.carried;
    const Eigen::VectorXd d_hat = carried.map.d_hat + carry_.drift(carried, nudged.end);
    Added added{Eigen::VectorXd::Zero(d_hat.size()), Eigen::VectorXd::Zero(d_hat.size()), {}};
    const PortsSeen seen = carry_.ports_seen(carried, nudged.end);
    added.rates = loose_.prescribe(carried.map, carry_.rigid(carried, nudged.end), d_hat,
                                   {nudged.end, seen}, added.d, added.a);
    return added;
  };
  const Added a = prescribe(below);
  const Added b = prescribe(above);
  const double scale = 0.5 / direction.amount;
  direction.dd += scale * (b.d - a.d);
  direction.da += scale * (b.a - a.a);
  direction.d_rates = {.v = scale * (b.rates.v - a.rates.v), .a = scale * (b.rates.a - a.rates.a)};
}

/// Derivative of the coordinates q at which the ports' forces act, x⁺ being changed by dx.
Eigen::VectorXd StepTangent::arms_change(const Step& step, const Direction& direction,
                                         const Eigen::VectorXd& dx) const {
  if (step_.balances_angular()) {  // they are those of x̃
    if (!direction.started()) return Eigen::VectorXd::Zero(loose_.size());
    return loose_.coordinates(direction.map.x_tilde);
  }
  const Eigen::VectorXd dq = loose_.coordinates(dx);
  if (!model_.integrator->keeps_history()) return dq;
  const auto followed = [&](double amount) {
    return loose_.followed(nudge(step, direction, amount).end, step.result.q + amount * dq);
  };
  return 0.5 / direction.amount * (followed(direction.amount) - followed(-direction.amount));
}

/// f_int and K of the linearisation turn and strain with x̃, T with the turn of the step.
void StepTangent::turn_forces(const Step& step, const Nudged& below, const Nudged& above,
                              Direction& direction) const {
  const StepMap& map = step.kept.map;
  const Eigen::VectorXd& dx = direction.map.x_tilde;
  const bool iterated = step.last().kind == Linearisation::Kind::Iterated;
  Eigen::VectorXd f_above = step.last().f_int;
  Eigen::VectorXd f_below = step.last().f_int;
  carry_.take_mean(above.carried, f_above);
  carry_.take_mean(below.carried, f_below);
  const Eigen::VectorXd of_mean = 0.5 / direction.amount * (f_above - f_below);
  if (iterated) {
    direction.turning = of_mean;
    return;
  }
  const bool corrected = step.last().kind == Linearisation::Kind::Corrected;
  Eigen::VectorXd y =
      corrected ? Eigen::VectorXd(step.last().map.x_tilde - map.x_tilde) : step.result.d;
  if (step.result.damped.size() > 0) {
    y += model_.params.damping.beta_s * (corrected ? step.result.first_damped : step.result.damped);
  }
  direction.turning = step_.turning(step.kept, map.x_tilde, y, dx);
  if (!step.kept.carried.turning || model_.integrator->keeps_history()) return;
  Eigen::VectorXd of_force =
      model_.formulation->derivative(map.x_tilde, Eigen::VectorXd::Zero(y.size()), dx);
  direction.turning += of_mean - of_force;
  carry_.take_mean(step.kept.carried, of_force);
  direction.turning += of_force;
}

/// Derivatives before the solve: free nodes with dv = 0, prescribed nodes with
/// their final ones.
///   dx_i = δp + δθ × r,   dv_i = δv + δw × r + w × (δθ × r),   r = R_WP r_i
void StepTangent::prescribe(const Step& step, Eigen::Index column, Direction& direction) const {
  const StepMap& map = step.kept.map;
  const auto p = static_cast<std::size_t>(column / 12);
  const Eigen::Matrix<double, 12, 1> change = step.end.derivative[p].col(column % 12);
  direction.port_end = Eigen::VectorXd::Zero(12 * static_cast<Eigen::Index>(step.end.value.size()));
  direction.port_end.segment<12>(12 * static_cast<Eigen::Index>(p)) = change;
  see(step, direction);
  direction.dx = Eigen::VectorXd::Zero(step.begin.x.size());
  const Eigen::Matrix3d R_WP = step.end.value[p].q_WP.toRotationMatrix();
  for (std::size_t k = 0; k < arms_[p].size(); ++k) {
    const Eigen::Vector3d r = R_WP * arms_[p][k];
    const Eigen::Vector3d turn = change.segment<3>(3).cross(r);
    const Eigen::Index at = 3 * model_.ports[p].nodes[k];
    direction.dx.segment<3>(at) = change.segment<3>(0) + turn;
    direction.dv.segment<3>(at) +=
        change.segment<3>(6) + change.segment<3>(9).cross(r) + step.end.value[p].w_WP.cross(turn);
  }
  if (!model_.integrator->inertia()) direction.dv.setZero();
  for (int node : model_.prescribed) {
    const Eigen::Index at = 3 * node;
    Eigen::Vector3d da = map.c_a_prescribed * direction.dv.segment<3>(at);
    Eigen::Vector3d dd = map.prescribed_position ? Eigen::Vector3d(direction.dx.segment<3>(at))
                                                 : map.c_x * direction.dv.segment<3>(at);
    if (direction.started()) {
      da += direction.map.a_hat_prescribed.segment<3>(at);
      if (map.prescribed_position) {
        dd -= direction.map.x_tilde.segment<3>(at);
      } else {
        dd += direction.map.d_hat.segment<3>(at);
      }
    }
    if (direction.d_circling.size() > 0) da += direction.d_circling.segment<3>(at);
    direction.da.segment<3>(at) = da;
    direction.dd.segment<3>(at) = dd;
  }
  if (direction.d_reference.size() > 0) {
    const auto shift = [&](double amount) {
      const Nudged nudged = nudge(step, direction, amount);
      return carry_.prescribed_shift(nudged.carried, nudged.end,
                                     step.result.state.x + amount * direction.dx,
                                     step.result.y + amount * direction.dv);
    };
    direction.d_shift =
        0.5 / direction.amount * (shift(direction.amount) - shift(-direction.amount));
  }
  const bool damped = direction.d_reference.size() > 0 && !direction.d_reference.isZero(0.0);
  const bool own = model_.ports[p].attachment.loose() && !change.isZero(0.0);
  direction.moves = direction.started() || damped || own ||
                    direction.dv.squaredNorm() + direction.dd.squaredNorm() > 0.0;
}

/// Derivative of the state after the step.
State StepTangent::concluded(const Step& step, const Direction& direction) const {
  const TransientStep::Result& result = step.result;
  const auto after = [&](double amount) {
    const Nudged nudged = nudge(step, direction, amount);
    Carry::Made made{.x = step.last().map.x_tilde + result.d,
                     .v = result.y + amount * direction.dv,
                     .a = result.a + amount * direction.da,
                     .rates = result.rates,
                     .end = nudged.end};
    for (int node : model_.prescribed) {
      made.x.segment<3>(3 * node) =
          result.state.x.segment<3>(3 * node) + amount * direction.dx.segment<3>(3 * node);
    }
    for (int node : model_.free) {
      const Eigen::Index at = 3 * node;
      made.x.segment<3>(at) += amount * direction.dd.segment<3>(at);
      if (direction.started()) {
        made.x.segment<3>(at) += amount * direction.map.x_tilde.segment<3>(at);
      }
    }
    add(direction.d_rates.v, amount, made.rates.v);
    add(direction.d_rates.a, amount, made.rates.a);
    State state;
    if (model_.integrator->keeps_history()) loose_.follow(nudged.end, made.x);
    carry_.conclude(nudged.begin, nudged.carried, std::move(made), state);
    loose_.follow(nudged.end, state.x);
    return state;
  };
  State change = slope(after(-direction.amount), after(direction.amount), direction.amount);
  change.attached = direction.d_phi;
  return change;
}

}  // namespace tandem::fem

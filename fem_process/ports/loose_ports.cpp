#include "fem_process/ports/loose_ports.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace tandem::fem {
namespace {

/// Relative rotation that a bushing bears: the rotation vector ends at π.
constexpr double kMostTurn_rad = 2.5;
constexpr int kMostIterations = 50;

Eigen::Matrix3d rotation_of(const Motion& motion) { return motion.q_WP.toRotationMatrix(); }

/// Rates of a set that moves with the port, as the velocities that a step solves for have them.
Vector12 rates_seen(const NodeAverage& average, Motion motion, const Eigen::Matrix3d& back) {
  motion.w_WP = back * motion.w_WP;
  Vector12 rates = rigid_rates(average, motion);
  rates.head<3>() -= motion.v_WP;
  rates = four_times(back.transpose()) * rates;
  rates.head<3>() += motion.v_WP;
  return rates;
}

/// As if the coordinates were nodes', for the integrator; there are no positions.
State as_state(const RateHistory& rates) {
  State state;
  state.x = Eigen::VectorXd::Zero(rates.v.size());
  state.v = rates.v;
  state.a = rates.a;
  state.acceleration = rates.acceleration;
  state.a_mean = rates.a_mean;
  return state;
}

}  // namespace

Eigen::VectorXd solve_equilibrated(const Eigen::MatrixXd& G, const Eigen::VectorXd& b) {
  const Eigen::VectorXd scale = G.cwiseAbs().rowwise().maxCoeff().cwiseInverse();
  return (scale.asDiagonal() * G).partialPivLu().solve(scale.asDiagonal() * b);
}

Vector12 rigid_coordinates(const NodeAverage& average, const Motion& motion) {
  const Eigen::Matrix3d R = rotation_of(motion);
  Vector12 q;
  q.head<3>() = motion.p_WP + R * average.centroid();
  for (int k = 0; k < 3; ++k) q.segment<3>(3 * (k + 1)) = R * average.inertia().col(k);
  return q;
}

Vector12 rigid_rates(const NodeAverage& average, const Motion& motion) {
  const Vector12 q = rigid_coordinates(average, motion);
  Vector12 rates;
  rates.head<3>() = motion.v_WP + motion.w_WP.cross(Eigen::Vector3d(q.head<3>() - motion.p_WP));
  for (int j = 3; j < 12; j += 3) {
    rates.segment<3>(j) = motion.w_WP.cross(Eigen::Vector3d(q.segment<3>(j)));
  }
  return rates;
}

LoosePorts::LoosePorts(const Model& model, const PortArms& arms)
    : free_rows_(3 * static_cast<Eigen::Index>(model.free.size())) {
  for (std::size_t p = 0; p < model.ports.size(); ++p) {
    const Model::Port& port = model.ports[p];
    if (!port.attachment.loose()) continue;
    Port& loose =
        ports_.emplace_back(Port{p, NodeAverage(port.nodes, port.weights, arms[p]), std::nullopt});
    if (port.attachment.kind == scenario::AttachmentKind::Bushing) {
      loose.bushing.emplace(port.attachment.bushing);
    }
    names_.push_back(port.name);
    std::vector<Eigen::Index>& rows = free_at_.emplace_back();
    for (int node : port.nodes) {
      const auto found = std::lower_bound(model.free.begin(), model.free.end(), node);
      rows.push_back(3 * (found - model.free.begin()));
    }
  }
}

Eigen::VectorXd LoosePorts::coordinates(const Eigen::VectorXd& x) const {
  Eigen::VectorXd q(size());
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    q.segment<12>(12 * static_cast<Eigen::Index>(k)) = ports_[k].average.coordinates(x);
  }
  return q;
}

void LoosePorts::add_forces(const Eigen::VectorXd& phi, double scale, Eigen::VectorXd& f) const {
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    ports_[k].average.add_forces(part(phi, k), scale, f);
  }
}

Eigen::MatrixXd LoosePorts::columns() const {
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(free_rows_, size());
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    for (std::size_t i = 0; i < free_at_[k].size(); ++i) {
      for (int c = 0; c < 12; ++c) {
        N(free_at_[k][i] + c % 3, 12 * static_cast<Eigen::Index>(k) + c) =
            ports_[k].average.share(i, c / 3);
      }
    }
  }
  return N;
}

Eigen::MatrixXd LoosePorts::coordinates_of(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd q = Eigen::MatrixXd::Zero(size(), columns.cols());
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    for (std::size_t i = 0; i < free_at_[k].size(); ++i) {
      for (int j = 0; j < 4; ++j) {
        q.middleRows<3>(12 * static_cast<Eigen::Index>(k) + 3 * j) +=
            ports_[k].average.share(i, j) * columns.middleRows<3>(free_at_[k][i]);
      }
    }
  }
  return q;
}

RateHistory LoosePorts::rigid_start(const MotionSet& motions) const {
  RateHistory start{.v = Eigen::VectorXd(size()), .a = Eigen::VectorXd(size())};
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    const Motion& motion = motions[ports_[k].index];
    const Vector12 rates = rigid_rates(ports_[k].average, motion);
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    start.v.segment<12>(row) = rates;
    start.a.segment<12>(row) = rates;
    start.a.segment<3>(row) -= motion.v_WP;
    for (Eigen::Index j = row; j < row + 12; j += 3) {
      start.a.segment<3>(j) = motion.w_WP.cross(Eigen::Vector3d(start.a.segment<3>(j)));
    }
  }
  start.a_mean = start.acceleration = start.a;
  return start;
}

LoosePorts::RigidStep LoosePorts::rigid_step(const Integrator& integrator, const State& begin,
                                             double h_s) const {
  return {.map = integrator.map(as_state(begin.rigid), h_s),
          .lag = coordinates(begin.v) - begin.rigid.v};
}

RateHistory kept_rates(const Integrator& integrator, const RateHistory& begin,
                       const LoosePorts::Rates& rates, double h_s) {
  State after;
  integrator.keep(as_state(begin), rates.v, rates.a, h_s, after);
  return {.v = rates.v, .a = after.a, .acceleration = after.acceleration, .a_mean = after.a_mean};
}

LoosePorts::Rates LoosePorts::prescribe(const StepMap& map, const RigidStep& rigid,
                                        const Eigen::VectorXd& d_hat, const EndMotions& end,
                                        Eigen::VectorXd& d, Eigen::VectorXd& a) const {
  Rates rates{Eigen::VectorXd(size()), rigid.map.a_hat};
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    const auto& [index, average, bushing] = ports_[k];
    const Motion& seen = end.seen.motions[index];
    const Eigen::Matrix3d& back = end.seen.back[k];
    const Vector12 rho = rates_seen(average, seen, back);
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    rates.v.segment<12>(row) = rho;
    rates.a.segment<12>(row) += map.c_a * rho;
    if (bushing) continue;
    const Eigen::Matrix3d R = rotation_of(seen);
    const Vector12 lacking_a = part(rigid.map.a_hat_prescribed, k) +
                               map.c_a_prescribed * rigid_rates(average, end.in_world[index]) -
                               part(rates.a, k);
    average.add_rigid_part(R, lacking_a, 1.0, a);
    rates.a.segment<12>(row) += average.rigid_part(R, lacking_a);
    const Vector12 lag = four_times((back * back).transpose()) * part(rigid.lag, k);
    const Vector12 lacking_d = rigid_coordinates(average, seen) - average.coordinates(map.x_tilde) -
                               average.coordinates(d_hat) - map.c_x * (rho + lag);
    average.add_rigid_part(R, lacking_d, 1.0, d);
  }
  return rates;
}

void LoosePorts::follow(const MotionSet& end, Eigen::VectorXd& x) const {
  for (const auto& [index, average, bushing] : ports_) {
    if (bushing) continue;
    average.add_rigid_part(rotation_of(end[index]),
                           rigid_coordinates(average, end[index]) - average.coordinates(x), 1.0, x);
  }
}

Eigen::VectorXd LoosePorts::followed(const MotionSet& end, const Eigen::VectorXd& q) const {
  Eigen::VectorXd moved = q;
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    const auto& [index, average, bushing] = ports_[k];
    if (bushing) continue;
    moved.segment<12>(12 * static_cast<Eigen::Index>(k)) += average.rigid_part(
        rotation_of(end[index]), rigid_coordinates(average, end[index]) - part(q, k));
  }
  return moved;
}

void LoosePorts::set_velocities(const MotionSet& motions, Eigen::VectorXd& v) const {
  for (const auto& [index, average, bushing] : ports_) {
    if (bushing) continue;
    for (int node : average.nodes()) v.segment<3>(3 * node).setZero();
    const Vector12 rates = rigid_rates(average, motions[index]);
    average.add_rigid_field(rotation_of(motions[index]), rates.head<3>(), motions[index].w_WP, v);
  }
}

PortRelation LoosePorts::relation(std::size_t k, const PortsSeen& seen, const Eigen::VectorXd& q,
                                  const Eigen::VectorXd& q_rate, const Eigen::VectorXd& phi) const {
  const auto& [index, average, bushing] = ports_[k];
  const PortView view =
      port_view(seen.motions[index], seen.back[k], part(q, k), part(q_rate, k), part(phi, k));
  return bushing ? bushing->relation(average, view) : averaging_relation(average, view);
}

Eigen::MatrixXd LoosePorts::tangent(const std::vector<PortRelation>& relations,
                                    const PortsSeen& seen, double c_x,
                                    const Eigen::MatrixXd& Y) const {
  Eigen::MatrixXd G(size(), size());
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    const Eigen::Matrix3d R = rotation_of(seen.motions[ports_[k].index]).transpose();
    const Matrix12 R_PW = four_times(R);
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    const Matrix12 of_rate =
        c_x * relations[k].F_q * R_PW + relations[k].F_u * four_times(R * seen.back[k]);
    G.middleRows<12>(row) = of_rate * Y.middleRows<12>(row);
    G.block<12, 12>(row, row) += relations[k].F_phi * R_PW;
  }
  return G;
}

SolveReport LoosePorts::close(const PortsSeen& end, double c_x, const Eigen::MatrixXd& Y,
                              const Eigen::VectorXd& near, Eigen::VectorXd& q,
                              Eigen::VectorXd& q_rate, Eigen::VectorXd& phi) const {
  Eigen::VectorXd at = near;
  std::vector<PortRelation> relations(ports_.size());
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    Eigen::VectorXd F(size());
    for (std::size_t k = 0; k < ports_.size(); ++k) {
      const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
      relations[k] = relation(k, end, at, q_rate, phi);
      const Matrix12 R_PW = four_times(rotation_of(end.motions[ports_[k].index]).transpose());
      F.segment<12>(row) = relations[k].F + relations[k].F_q * (R_PW * (q - at).segment<12>(row));
    }
    const Eigen::VectorXd change = solve_equilibrated(tangent(relations, end, c_x, Y), -F);
    const Eigen::VectorXd rate_change = Y * change;
    phi += change;
    q_rate += rate_change;
    q += c_x * rate_change;
    at = q;
    if (!phi.allFinite()) break;
    // A last correction below round-off of the forces, or of the positions.
    constexpr double kRoundOff = 8.0 * std::numeric_limits<double>::epsilon();
    const bool forces = change.norm() <= 1e-13 * phi.norm();
    const bool positions = iteration > 0 && (c_x * rate_change).cwiseAbs().maxCoeff() <=
                                                kRoundOff * q.cwiseAbs().maxCoeff();
    if (!forces && !positions) continue;
    for (std::size_t k = 0; k < ports_.size(); ++k) {
      const auto& [index, average, bushing] = ports_[k];
      if (!bushing) continue;
      const Vector12 q_P =
          port_view(end.motions[index], end.back[k], part(q, k), part(q_rate, k), part(phi, k)).q;
      const double turn = bushing->deflection(average, q_P).theta.norm();
      if (turn <= kMostTurn_rad) continue;
      return {.outcome = Outcome::Failed,
              .message = "the bushing of port '" + names_[k] + "' is turned by " +
                         fmt::format("{:.6g}", turn) +
                         " rad, and its rotation vector holds up to " +
                         fmt::format("{:.3g}", kMostTurn_rad) +
                         " rad. Make it stiffer, or join the bodies by a joint of the multibody "
                         "side and a rigid port."};
    }
    return {};
  }
  return {.outcome = Outcome::Failed,
          .message = "the forces of the averaging ports and bushings have not converged in " +
                     std::to_string(kMostIterations) +
                     " iterations. Shorten fem.micro_step_s, or check the bushings' stiffness."};
}

void LoosePorts::close_accelerations(const Eigen::MatrixXd& Y, const Eigen::VectorXd& q,
                                     const Eigen::VectorXd& q_acceleration,
                                     Eigen::VectorXd& phi) const {
  Eigen::MatrixXd G = Eigen::MatrixXd::Identity(size(), size());
  Eigen::VectorXd b = phi;
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    if (ports_[k].bushing) continue;
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    const Motion still{.p_WP = Eigen::Vector3d::Zero(),
                       .q_WP = Eigen::Quaterniond(NodeAverage::rotation(part(q, k)))};
    const Vector12 zero = Vector12::Zero();
    const PortRelation relation = averaging_relation(
        ports_[k].average, port_view(still, Eigen::Matrix3d::Identity(), part(q, k), zero, zero));
    const Matrix12 R_PW = four_times(rotation_of(still).transpose());
    const Matrix12 of_rate = relation.F_u * R_PW;
    G.middleRows<12>(row) = of_rate * Y.middleRows<12>(row);
    G.block<12, 12>(row, row) += relation.F_phi * R_PW;
    b.segment<12>(row) = -of_rate * part(q_acceleration, k);
  }
  phi = solve_equilibrated(G, b);
}

Eigen::VectorXd LoosePorts::bushing_forces(const MotionSet& motions, const Eigen::VectorXd& q,
                                           const Eigen::VectorXd& q_rate) const {
  const PortsSeen in_world{motions, {ports_.size(), Eigen::Matrix3d::Identity()}};
  Eigen::VectorXd phi = Eigen::VectorXd::Zero(size());
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    if (!ports_[k].bushing) continue;
    const Matrix12 R_WP = four_times(rotation_of(motions[ports_[k].index]));
    phi.segment<12>(12 * static_cast<Eigen::Index>(k)) =
        -R_WP * relation(k, in_world, q, q_rate, phi).F;
  }
  return phi;
}

double LoosePorts::energy_J(const MotionSet& motions, const Eigen::VectorXd& q) const {
  double energy = 0.0;
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    const auto& [index, average, bushing] = ports_[k];
    if (!bushing) continue;
    const Vector12 zero = Vector12::Zero();
    const Vector12 q_P =
        port_view(motions[index], Eigen::Matrix3d::Identity(), part(q, k), zero, zero).q;
    energy += bushing->energy_J(bushing->deflection(average, q_P));
  }
  return energy;
}

void LoosePorts::add_wrenches(const std::vector<Eigen::Vector3d>& about, const Eigen::VectorXd& q,
                              const Eigen::VectorXd& phi, WrenchSet& wrenches) const {
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    Vector12 arms = part(q, k);
    arms.head<3>() -= about[ports_[k].index];
    const Vector12 forces = part(phi, k);
    Wrench& wrench = wrenches[ports_[k].index];
    wrench.f_P_W -= forces.head<3>();
    for (int j = 0; j < 12; j += 3) {
      wrench.t_P_W -= arms.segment<3>(j).cross(forces.segment<3>(j));
    }
  }
}

}  // namespace tandem::fem

#include "fem_process/loose_tangent.h"

#include <Eigen/Geometry>

namespace tandem::fem {
namespace {

Vector12 part(const Eigen::VectorXd& all, std::size_t k) {
  return all.segment<12>(12 * static_cast<Eigen::Index>(k));
}

Vector12 turned(const Eigen::Vector3d& turn, Vector12 q) {
  for (int j = 0; j < 12; j += 3) {
    q.segment<3>(j) = turn.cross(Eigen::Vector3d(q.segment<3>(j)));
  }
  return q;
}

/// What a change means for the port `index`: nothing for any but its own.
Vector12 change_of(const LooseTangent::Change& change, std::size_t index) {
  return change.port == index ? change.motion : Vector12(Vector12::Zero());
}

/// Derivatives of rigid_coordinates() and rigid_rates().
Vector12 d_rigid_coordinates(const NodeAverage& average, const Motion& motion,
                             const Vector12& change) {
  Vector12 arms = rigid_coordinates(average, motion);
  arms.head<3>() -= motion.p_WP;
  Vector12 dq = turned(change.segment<3>(3), arms);
  dq.head<3>() += change.head<3>();
  return dq;
}

Vector12 d_rigid_rates(const NodeAverage& average, const Motion& motion, const Vector12& change) {
  Vector12 arms = rigid_coordinates(average, motion);
  arms.head<3>() -= motion.p_WP;
  Vector12 rates =
      turned(change.tail<3>(), arms) + turned(motion.w_WP, turned(change.segment<3>(3), arms));
  rates.head<3>() += change.segment<3>(6);
  return rates;
}

}  // namespace

LooseTangent::LooseTangent(const LoosePorts& ports, const Solution& solution)
    : ports_(ports),
      end_(solution.end),
      q_(ports.coordinates(solution.x)),
      q_rate_(ports.coordinates(solution.v)),
      phi_(solution.phi) {
  for (std::size_t k = 0; k < ports_.ports().size(); ++k) {
    relations_.push_back(ports_.relation(k, end_, q_, q_rate_, phi_));
  }
  const Eigen::MatrixXd G = ports_.tangent(relations_, end_, solution.c_x, solution.Y);
  row_scale_ = G.cwiseAbs().rowwise().maxCoeff().cwiseInverse();
  G_.compute(row_scale_.asDiagonal() * G);
}

/// P_R y = R P_0 Rᵀ y: a turn of R turns the rigid part and turns y back.
void LooseTangent::add_rigid_part(const NodeAverage& average, const Eigen::Matrix3d& R,
                                  const Vector12& eta, const Vector12& d_eta,
                                  const Eigen::Vector3d& turn, Eigen::VectorXd& field) const {
  average.add_rigid_part(R, d_eta - turned(turn, eta), 1.0, field);
  if (turn.isZero(0.0)) return;
  Eigen::VectorXd part_of_eta = Eigen::VectorXd::Zero(field.size());
  average.add_rigid_part(R, eta, 1.0, part_of_eta);
  for (int node : average.nodes()) {
    field.segment<3>(3 * node) += turn.cross(Eigen::Vector3d(part_of_eta.segment<3>(3 * node)));
  }
}

LoosePorts::Rates LooseTangent::prescribe(const StepMap& map, const LoosePorts::RigidStep& rigid,
                                          const StepMap* d_map,
                                          const LoosePorts::RigidStep* d_rigid,
                                          const Change& change, Eigen::VectorXd& dd,
                                          Eigen::VectorXd& da) const {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(ports_.size());
  LoosePorts::Rates rates{zero, d_rigid != nullptr ? d_rigid->map.a_hat : zero};
  for (std::size_t k = 0; k < ports_.ports().size(); ++k) {
    const auto& [index, average, bushing] = ports_.ports()[k];
    const Motion& motion = end_[index];
    const Vector12 own = change_of(change, index);
    const Eigen::Vector3d turn = own.segment<3>(3);
    const Eigen::Matrix3d R = motion.q_WP.toRotationMatrix();
    const Vector12 rho = rigid_rates(average, motion);
    const Vector12 d_rho = d_rigid_rates(average, motion, own);
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    rates.v.segment<12>(row) = d_rho;
    rates.a.segment<12>(row) += map.c_a * d_rho;
    if (bushing) continue;
    const double excess = map.c_a_prescribed - map.c_a;
    const Vector12 a =
        part(rigid.map.a_hat_prescribed, k) - part(rigid.map.a_hat, k) + excess * rho;
    const Vector12 d = rigid_coordinates(average, motion) - average.coordinates(map.x_tilde) -
                       average.coordinates(map.d_hat) - map.c_x * (rho + part(rigid.lag, k));
    Vector12 d_a = map.c_a_prescribed * d_rho - part(rates.a, k);
    Vector12 d_d = d_rigid_coordinates(average, motion, own) - map.c_x * d_rho;
    if (d_map != nullptr) {
      d_a += part(d_rigid->map.a_hat_prescribed, k);
      d_d -= average.coordinates(d_map->x_tilde) + average.coordinates(d_map->d_hat) +
             map.c_x * part(d_rigid->lag, k);
    }
    add_rigid_part(average, R, a, d_a, turn, da);
    rates.a.segment<12>(row) +=
        average.rigid_part(R, d_a - turned(turn, a)) + turned(turn, average.rigid_part(R, a));
    add_rigid_part(average, R, d, d_d, turn, dd);
  }
  return rates;
}

Eigen::VectorXd LooseTangent::correction(const Eigen::VectorXd& dx, const Eigen::VectorXd& dv,
                                         const Eigen::VectorXd& d_phi, const Change& change) const {
  const Eigen::VectorXd dq = ports_.coordinates(dx);
  const Eigen::VectorXd dq_rate = ports_.coordinates(dv);
  Eigen::VectorXd dF(ports_.size());
  for (std::size_t k = 0; k < ports_.ports().size(); ++k) {
    const std::size_t index = ports_.ports()[k].index;
    const Motion& motion = end_[index];
    const Vector12 own = change_of(change, index);
    const Eigen::Vector3d turn = own.segment<3>(3);
    Vector12 arms = part(q_, k);
    Vector12 rates = part(q_rate_, k);
    arms.head<3>() -= motion.p_WP;
    rates.head<3>() -= motion.v_WP;
    Vector12 dq_seen = part(dq, k) - turned(turn, arms);
    Vector12 du_seen = part(dq_rate, k) - turned(turn, rates);
    dq_seen.head<3>() -= own.head<3>();
    du_seen.head<3>() -= own.segment<3>(6);
    const Eigen::Matrix3d R_PW = motion.q_WP.toRotationMatrix().transpose();
    const Matrix12 to_port = four_times(R_PW);
    const PortRelation& relation = relations_[k];
    dF.segment<12>(12 * static_cast<Eigen::Index>(k)) =
        relation.F_q * (to_port * dq_seen) + relation.F_u * (to_port * du_seen) +
        relation.F_w * (R_PW * (own.tail<3>() - turn.cross(motion.w_WP))) +
        relation.F_phi * (to_port * (part(d_phi, k) - turned(turn, part(phi_, k))));
  }
  return -G_.solve(row_scale_.asDiagonal() * dF);
}

void LooseTangent::follow(const Change& change, Eigen::VectorXd& dx) const {
  for (std::size_t k = 0; k < ports_.ports().size(); ++k) {
    const auto& [index, average, bushing] = ports_.ports()[k];
    if (bushing) continue;
    const Vector12 own = change_of(change, index);
    const Vector12 gap = rigid_coordinates(average, end_[index]) - part(q_, k);
    add_rigid_part(average, end_[index].q_WP.toRotationMatrix(), gap,
                   d_rigid_coordinates(average, end_[index], own) - average.coordinates(dx),
                   own.segment<3>(3), dx);
  }
}

void add_wrench_derivative(const LoosePorts& ports, const MotionSet& pose, const Eigen::VectorXd& q,
                           const Eigen::VectorXd& phi, const LooseTangent::Change& d_pose,
                           const Eigen::VectorXd& dq, const Eigen::VectorXd& d_phi,
                           WrenchSet& wrenches) {
  ports.add_wrenches(pose, q, d_phi, wrenches);
  for (std::size_t k = 0; k < ports.ports().size(); ++k) {
    const std::size_t index = ports.ports()[k].index;
    Vector12 d_arms = part(dq, k);
    d_arms.head<3>() -= change_of(d_pose, index).head<3>();
    for (int j = 0; j < 12; j += 3) {
      wrenches[index].t_P_W -=
          Eigen::Vector3d(d_arms.segment<3>(j))
              .cross(Eigen::Vector3d(phi.segment<3>(12 * static_cast<Eigen::Index>(k) + j)));
    }
  }
}

}  // namespace tandem::fem

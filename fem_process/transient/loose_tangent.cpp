#include "fem_process/transient/loose_tangent.h"

#include <Eigen/Geometry>

namespace tandem::fem {
namespace {

Vector12 turned(const Eigen::Vector3d& turn, Vector12 q) {
  for (int j = 0; j < 12; j += 3) {
    q.segment<3>(j) = turn.cross(Eigen::Vector3d(q.segment<3>(j)));
  }
  return q;
}

/// Change of the motion of the port `index`.
Vector12 change_of(const Eigen::VectorXd& changes, std::size_t index) {
  return changes.segment<12>(12 * static_cast<Eigen::Index>(index));
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

Eigen::VectorXd LooseTangent::correction(const Eigen::VectorXd& dx, const Eigen::VectorXd& dv,
                                         const Eigen::VectorXd& d_phi,
                                         const SeenChange& d_end) const {
  const Eigen::VectorXd dq = ports_.coordinates(dx);
  const Eigen::VectorXd dq_rate = ports_.coordinates(dv);
  Eigen::VectorXd dF(ports_.size());
  for (std::size_t k = 0; k < ports_.ports().size(); ++k) {
    const std::size_t index = ports_.ports()[k].index;
    const Motion& motion = end_.motions[index];
    const Matrix12 back = four_times(end_.back[k]);
    const Vector12 own = change_of(d_end.motions, index);
    const Eigen::Vector3d turn = own.segment<3>(3);
    Vector12 arms = part(q_, k);
    Vector12 rates = part(q_rate_, k);
    arms.head<3>() -= motion.p_WP;
    rates.head<3>() -= motion.v_WP;
    Vector12 dq_seen = part(dq, k) - turned(turn, arms);
    Vector12 d_rates = part(dq_rate, k);
    dq_seen.head<3>() -= own.head<3>();
    d_rates.head<3>() -= own.segment<3>(6);
    const Vector12 du_seen =
        back * d_rates + four_times(d_end.back[k]) * rates - turned(turn, back * rates);
    const Eigen::Vector3d w = end_.back[k] * motion.w_WP;
    const Eigen::Vector3d dw = end_.back[k] * own.tail<3>() + d_end.back[k] * motion.w_WP;
    const Eigen::Matrix3d R_PW = motion.q_WP.toRotationMatrix().transpose();
    const Matrix12 to_port = four_times(R_PW);
    const PortRelation& relation = relations_[k];
    dF.segment<12>(12 * static_cast<Eigen::Index>(k)) =
        relation.F_q * (to_port * dq_seen) + relation.F_u * (to_port * du_seen) +
        relation.F_w * (R_PW * (dw - turn.cross(w))) +
        relation.F_phi * (to_port * (part(d_phi, k) - turned(turn, part(phi_, k))));
  }
  return -G_.solve(row_scale_.asDiagonal() * dF);
}

void add_wrench_derivative(const LoosePorts& ports, const std::vector<Eigen::Vector3d>& about,
                           const Eigen::VectorXd& q, const Eigen::VectorXd& phi,
                           const Eigen::VectorXd& d_about, const Eigen::VectorXd& dq,
                           const Eigen::VectorXd& d_phi, WrenchSet& wrenches) {
  ports.add_wrenches(about, q, d_phi, wrenches);
  for (std::size_t k = 0; k < ports.ports().size(); ++k) {
    const std::size_t index = ports.ports()[k].index;
    Vector12 d_arms = part(dq, k);
    d_arms.head<3>() -= d_about.segment<3>(3 * static_cast<Eigen::Index>(index));
    for (int j = 0; j < 12; j += 3) {
      wrenches[index].t_P_W -=
          Eigen::Vector3d(d_arms.segment<3>(j))
              .cross(Eigen::Vector3d(phi.segment<3>(12 * static_cast<Eigen::Index>(k) + j)));
    }
  }
}

}  // namespace tandem::fem

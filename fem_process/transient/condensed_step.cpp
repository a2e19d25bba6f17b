#include "fem_process/transient/condensed_step.h"

#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace tandem::fem {
namespace {

using Rates = Eigen::Matrix<double, 3, 12>;

/// A prescribed node that follows a port.
struct PortNode {
  int node = 0;
  std::size_t port = 0;
  Eigen::Vector3d arm;         ///< from the port's origin at the end of the step (m)
  Eigen::Vector3d torque_arm;  ///< from where torques are taken about (m)
  Rates rate;                  ///< of its velocity with its port's end motion
};

/// dv = δv + δw × r + w × (δθ × r).
Rates rates_of(const Motion& end, const Eigen::Vector3d& arm) {
  const Eigen::Vector3d r = end.q_WP * arm;
  Rates rates = Rates::Zero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Vector3d turn = Eigen::Vector3d::Unit(k).cross(r);
    rates.col(3 + k) = end.w_WP.cross(turn);
    rates.col(6 + k) = Eigen::Vector3d::Unit(k);
    rates.col(9 + k) = turn;
  }
  return rates;
}

/// What the step's columns are made of.
class Condensation {
 public:
  Condensation(const Model& model, const PortArms& arms, const MotionSet& end,
               const TorqueArms& torques, const Linearisation& kept)
      : model_(model),
        kept_(kept),
        free_(static_cast<std::size_t>(model.mesh.nodes()), -1),
        port_node_(free_.size(), -1) {
    for (std::size_t k = 0; k < model.free.size(); ++k) {
      free_[static_cast<std::size_t>(model.free[k])] = static_cast<int>(k);
    }
    for (std::size_t p = 0; p < arms.size(); ++p) {
      for (std::size_t k = 0; k < arms[p].size(); ++k) {
        const int node = model.ports[p].nodes[k];
        port_node_[static_cast<std::size_t>(node)] = static_cast<int>(nodes_.size());
        nodes_.push_back({.node = node,
                          .port = p,
                          .arm = end[p].q_WP * arms[p][k],
                          .torque_arm = torques.pose[p].p_WP - torques.about[p] +
                                        torques.pose[p].q_WP * arms[p][k],
                          .rate = rates_of(end[p], arms[p][k])});
      }
      offset_.push_back(torques.pose[p].p_WP - torques.about[p]);
      // A turn of the port moves velocities where it rotates; a displacement
      // moves none.
      for (Eigen::Index c = end[p].w_WP.isZero(0.0) ? 6 : 3; c < 12; ++c) {
        moving_.push_back(12 * static_cast<Eigen::Index>(p) + c);
      }
    }
    reactions_.setZero(3 * static_cast<Eigen::Index>(nodes_.size()), columns());
  }

  [[nodiscard]] Eigen::Index columns() const { return static_cast<Eigen::Index>(moving_.size()); }

  /// −S_Ip T_c; the share of S_pp T_c goes to the reactions.
  [[nodiscard]] Eigen::MatrixXd right_hand_sides() {
    Eigen::MatrixXd b =
        Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(model_.free.size()), columns());
    for_blocks([&](std::size_t at, int j, const Eigen::Matrix3d& S) {
      const auto other = static_cast<std::size_t>(j);
      if (free_[other] >= 0) {
        add(-S.transpose() * nodes_[at].rate, nodes_[at].port, b.middleRows<3>(3 * free_[other]));
      } else if (port_node_[other] >= 0) {
        const PortNode& neighbour = nodes_[static_cast<std::size_t>(port_node_[other])];
        add(S * neighbour.rate, neighbour.port,
            reactions_.middleRows<3>(3 * static_cast<Eigen::Index>(at)));
      }
    });
    return b;
  }

  /// Adds to the rows of the free nodes' velocities what these do through the reactions of held
  /// nodes, S_pI x.
  void add_reactions(const AngularBalance& angular, AngularBalance::Rows& rows) const {
    if (rows.mass.isZero(0.0)) return;
    const Eigen::MatrixXd moments = moments_of_reactions(angular, rows);
    for_blocks([&](std::size_t at, int j, const Eigen::Matrix3d& S) {
      const int free = free_[static_cast<std::size_t>(j)];
      if (free < 0) return;
      rows.free.middleRows<3>(3 * free).noalias() +=
          S.transpose() * moments.middleCols<3>(3 * static_cast<Eigen::Index>(at)).transpose();
    });
  }

  /// Adds S_pI x_c to the reactions.
  void add_interior(const Eigen::MatrixXd& x) {
    for_blocks([&](std::size_t at, int j, const Eigen::Matrix3d& S) {
      const int free = free_[static_cast<std::size_t>(j)];
      if (free < 0) return;
      reactions_.middleRows<3>(3 * static_cast<Eigen::Index>(at)).noalias() +=
          S * x.middleRows<3>(3 * free);
    });
  }

  /// Wrenches of the reactions, corrected by what is left of the columns'
  /// equations.
  void wrenches(const Eigen::MatrixXd& x, const Eigen::MatrixXd& left,
                InterfaceJacobian& jacobian) const {
    const Eigen::MatrixXd products = x.transpose() * left;
    for (Eigen::Index c = 0; c < columns(); ++c) {
      const Eigen::Index column = moving_[static_cast<std::size_t>(c)];
      for (std::size_t k = 0; k < nodes_.size(); ++k) {
        const Eigen::Vector3d g = reactions_.col(c).segment<3>(3 * static_cast<Eigen::Index>(k));
        const Eigen::Index row = 6 * static_cast<Eigen::Index>(nodes_[k].port);
        jacobian.col(column).segment<3>(row) -= g;
        jacobian.col(column).segment<3>(row + 3) -= nodes_[k].torque_arm.cross(g);
      }
      for (Eigen::Index w = 0; w < columns(); ++w) {
        const Eigen::Index rate = moving_[static_cast<std::size_t>(w)];
        if (rate % 12 < 6) continue;  // forces go with v_WP, torques with w_WP
        const Eigen::Index port = rate / 12;
        jacobian(6 * port + rate % 12 - 6, column) += products(w, c);
        if (rate % 12 >= 9) continue;
        // Torques are taken about `about`, beside the origin that the rates refer to.
        jacobian.col(column).segment<3>(6 * port + 3) +=
            offset_[static_cast<std::size_t>(port)].cross(products(w, c) *
                                                          Eigen::Vector3d::Unit(rate % 3));
      }
    }
  }

  /// What AngularBalance adds to the torques: through the free nodes' velocities (B x), the ports'
  /// origins and the nodes that they hold, their reactions S_pp T_c.
  void turn(const Eigen::MatrixXd& by_free, const AngularBalance& angular,
            const AngularBalance::Rows& rows, InterfaceJacobian& jacobian) const {
    const Eigen::Index ports = jacobian.rows() / 6;
    const Eigen::MatrixXd by_reactions = moments_of_reactions(angular, rows) * reactions_;
    const auto add = [&](Eigen::Index column, Eigen::Index moving) {
      const auto port = static_cast<std::size_t>(column / 12);
      const Eigen::Index c = column % 12;
      for (Eigen::Index k = 0; k < ports; ++k) {
        auto torque = jacobian.col(column).segment<3>(6 * k + 3);
        if (moving >= 0) {
          torque +=
              by_free.col(moving).segment<3>(3 * k) + by_reactions.col(moving).segment<3>(3 * k);
        }
        if (c < 3) torque += rows.ports.block<3, 1>(3 * k, 6 * (column / 12) + c);
        if (c >= 6 && c < 9) torque += rows.ports.block<3, 1>(3 * k, 6 * (column / 12) + c - 3);
      }
      for (const PortNode& node : nodes_) {
        if (node.port != port) continue;
        AngularBalance::Held change;
        if (c < 3) change.x = Eigen::Vector3d::Unit(c);
        if (c >= 3 && c < 6) change.x = Eigen::Vector3d::Unit(c - 3).cross(node.arm);
        change.v = node.rate.col(c);
        for (Eigen::Index k = 0; k < ports; ++k) {
          jacobian.col(column).segment<3>(6 * k + 3) +=
              angular.held(rows, static_cast<std::size_t>(k), node.node, change);
        }
      }
    };
    Eigen::Index moving = 0;
    for (Eigen::Index column = 0; column < jacobian.cols(); ++column) {
      const bool moves = moving < columns() && moving_[static_cast<std::size_t>(moving)] == column;
      add(column, moves ? moving++ : -1);
    }
  }

 private:
  /// What the reactions of the held nodes add to the torques of all ports.
  [[nodiscard]] Eigen::MatrixXd moments_of_reactions(const AngularBalance& angular,
                                                     const AngularBalance::Rows& rows) const {
    const Eigen::Index ports = rows.mass.size();
    Eigen::MatrixXd moments(3 * ports, 3 * static_cast<Eigen::Index>(nodes_.size()));
    for (std::size_t j = 0; j < nodes_.size(); ++j) {
      for (Eigen::Index c = 0; c < 3; ++c) {
        AngularBalance::Held change;
        change.r = Eigen::Vector3d::Unit(c);
        for (Eigen::Index k = 0; k < ports; ++k) {
          moments.block<3, 1>(3 * k, 3 * static_cast<Eigen::Index>(j) + c) =
              angular.held(rows, static_cast<std::size_t>(k), nodes_[j].node, change);
        }
      }
    }
    return moments;
  }

  /// Calls work(index of the port node, other node, block of S) for the rows of
  /// the port nodes.
  template <class Work>
  void for_blocks(const Work& work) const {
    const BlockPattern& pattern = model_.pattern();
    const double m = kept_.map.c_a;
    const double k = kept_.map.c_x;
    for (std::size_t at = 0; at < nodes_.size(); ++at) {
      const auto row = static_cast<std::size_t>(nodes_[at].node);
      for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
        Eigen::Matrix3d S = k * block(kept_.K, b);
        S.diagonal().array() += m * model_.mass[static_cast<std::size_t>(b)];
        work(at, pattern.column[static_cast<std::size_t>(b)], S);
      }
    }
  }

  /// Adds a port's columns to those that move.
  template <class Rows>
  void add(const Rates& change, std::size_t port, Rows rows) const {
    for (std::size_t c = 0; c < moving_.size(); ++c) {
      if (moving_[c] / 12 != static_cast<Eigen::Index>(port)) continue;
      rows.col(static_cast<Eigen::Index>(c)) += change.col(moving_[c] % 12);
    }
  }

  const Model& model_;
  const Linearisation& kept_;
  std::vector<int> free_;       ///< index of every node among the free ones; below zero: none
  std::vector<int> port_node_;  ///< the same in nodes_
  std::vector<PortNode> nodes_;
  std::vector<Eigen::Vector3d>
      offset_;                        ///< of every port's origin from where torques are taken (m)
  std::vector<Eigen::Index> moving_;  ///< columns of the Jacobian that do not vanish
  Eigen::MatrixXd reactions_;
};

}  // namespace

bool condenses(const Model& model, const Linearisation& kept) {
  // What mass damping refers to moves with the ports, everywhere.
  return kept.kind == Linearisation::Kind::Predicted && !model.integrator->keeps_history() &&
         !kept.map.prescribed_position && model.params.damping.alpha_per_s == 0.0 &&
         model.params.damping.beta_s == 0.0;
}

SolveReport condense(const Model& model, const PortArms& arms, const MotionSet& end,
                     const CondensedTorques& torques, const Linearisation& kept,
                     InterfaceJacobian& jacobian) {
  jacobian.setZero(6 * static_cast<Eigen::Index>(arms.size()),
                   12 * static_cast<Eigen::Index>(arms.size()));
  if (arms.empty()) return {};
  Condensation condensation(model, arms, end, torques.arms, kept);
  AngularBalance::Rows rows = torques.angular.rows();
  condensation.add_reactions(torques.angular, rows);
  Eigen::MatrixXd x = condensation.right_hand_sides();
  Eigen::VectorXd norms = x.colwise().norm();
  const Eigen::Index columns = x.cols();
  const bool exact = model.params.solver.kind == SolverKind::Cholmod;
  if (!exact) {
    // Solutions of Bᵀ for the second order of B x, measured by what they are added to.
    x.conservativeResize(Eigen::NoChange, columns + rows.free.cols());
    x.rightCols(rows.free.cols()) = rows.free;
    norms.conservativeResize(x.cols());
    norms.tail(rows.free.cols()).setConstant(norms.head(columns).maxCoeff());
  }
  Eigen::MatrixXd left;
  const SolveReport report = kept.solver->solve_roughly(x, norms, left);
  if (report.outcome == Outcome::Failed) return report;
  Eigen::MatrixXd by_free = rows.free.transpose() * x.leftCols(columns);
  if (!exact) {
    by_free += x.rightCols(rows.free.cols()).transpose() * left.leftCols(columns);
    x.conservativeResize(Eigen::NoChange, columns);
    left.conservativeResize(Eigen::NoChange, columns);
  }
  condensation.turn(by_free, torques.angular, rows, jacobian);
  condensation.add_interior(x);
  condensation.wrenches(x, left, jacobian);
  return report;
}

}  // namespace tandem::fem

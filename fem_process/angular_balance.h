#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/carry.h"
#include "fem_process/model.h"
#include "fem_process/state.h"
#include "fem_process/transient_step.h"
#include "protocol/contract/port.h"

namespace tandem::fem {

/// What the torques of a backward Euler step lack of the body's angular momentum. With x_m = x̃, the
/// nodes turned by half with their part about its centre c at the beginning, and p = M v,
///   [Σ (x − c) × p]⁺ − [Σ (x − c) × p] = Σ (x_m − c) × (p⁺ − p) + h Σ κ,
///   h κ = (x⁺ − x_m) × p⁺ − (x − x_m) × p;
/// the first sum holds the moments of the reactions r and of the external forces, both with the
/// arms x_m, and m_int = Σ (x_m − c) × ((p⁺ − p)/h − f_ext − r), what the linearised internal
/// forces have of a moment. Torques about P with the arms x_m − P, and further
///   t_k −= Σ_i φ_ik κ_i + μ_k m_int,   μ_k = Σ_i m_i φ_ik / Σ_i m_i,
/// close the angular momentum of a part and its ports to round-off over every step. κ is of first
/// order in ω h: the port's own motion and the body's elastic one during the turn.
///
/// The ground takes up m_int of what it holds (μ = 0). Internal forces of the linear formulation
/// have moments: there μ = 0 and h κ = (x⁺ − x − h v⁺) × p⁺ alone.
class AngularBalance {
 public:
  struct Step {
    const State& begin;
    const Carried& carried;
    const State& after;
    const Eigen::VectorXd& external;  ///< loads, weight and drag of the nodes (N)
    const Eigen::VectorXd& react;     ///< of all ports and of the ground on the nodes (N)
  };
  AngularBalance(const Model& model, const Carry& carry, const Step& step);

  void add(WrenchSet& wrenches) const;

  /// A direction's derivatives; of the beginning of the step empty where it does not change.
  struct Change {
    const Eigen::VectorXd& x_end;     ///< m
    const Eigen::VectorXd& v_end;     ///< in W (m/s)
    const Eigen::VectorXd& react;     ///< N
    const Eigen::VectorXd& dragged;   ///< of the velocities that α M damps; empty: none (m/s)
    const Eigen::VectorXd& x_begin;   ///< m
    const Eigen::VectorXd& v_begin;   ///< m/s
    const Eigen::VectorXd& x_middle;  ///< of x_m (m)
  };
  /// Adds the derivative of what add() adds.
  void add_change(const Change& change, WrenchSet& wrenches) const;

  /// The same as a linear map, where the beginning of the step does not change, there is no drag,
  /// and x⁺ of a node that no port holds rigidly moves by h Q^½ δv + Σ_l φ_l (δp_l − h Q^½ δv_l).
  struct Rows {
    Eigen::MatrixXd free;   ///< 3 rows per port: of δv of the free nodes
    Eigen::MatrixXd ports;  ///< 3 rows per port: of (δp, δv) of the ports' origins, by those nodes
    Eigen::MatrixXd arms;   ///< M (φ_k (x⁺ − x_m) + μ_k (x_m − c)) by port, a column each
    Eigen::MatrixXd phi;    ///< node by port
    Eigen::VectorXd mass;   ///< μ by port
  };
  [[nodiscard]] Rows rows() const;
  /// What a node that a port holds rigidly adds to the torque of port k when it moves by these.
  struct Held {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();  ///< of x⁺ (m)
    Eigen::Vector3d v = Eigen::Vector3d::Zero();  ///< of v⁺ (m/s)
    Eigen::Vector3d r = Eigen::Vector3d::Zero();  ///< of its reaction (N)
  };
  [[nodiscard]] Eigen::Vector3d held(const Rows& rows, std::size_t k, int node,
                                     const Held& change) const;

 private:
  struct Share {
    std::size_t port;
    std::size_t part;
    Eigen::Index holder;
    double mass;  ///< μ
  };
  template <class Work>
  void for_nodes(const Share& share, const Work& work) const;

  const Model& model_;
  const Carry& carry_;
  const Step step_;
  double h_s_;
  bool rotates_;
  Eigen::VectorXd p_, p_end_;   ///< kg m/s
  Eigen::VectorXd out_, back_;  ///< x⁺ and x less what they are compared with in κ (m)
  Eigen::VectorXd internal_;    ///< (p⁺ − p)/h − f_ext − r (N)
  Eigen::VectorXd arm_;         ///< x_m − c (m)
  std::vector<Share> shares_;
};

/// Of a step that was made.
[[nodiscard]] inline AngularBalance::Step balanced(const State& begin, const Linearisation& kept,
                                                   const TransientStep::Result& result) {
  return {.begin = begin,
          .carried = kept.carried,
          .after = result.state,
          .external = result.external,
          .react = result.on_nodes};
}

}  // namespace tandem::fem

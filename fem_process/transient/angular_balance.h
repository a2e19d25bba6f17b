#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/body/model.h"
#include "fem_process/body/state.h"
#include "fem_process/transient/transient_step.h"
#include "fem_process/turning/carry.h"
#include "protocol/contract/port.h"

namespace tandem::fem {

/// What the torques of a backward Euler step lack of the body's angular momentum. With x_m = x̃, the
/// nodes turned by half with their part about its centre c at the beginning,
///   [Σ (x − c) × M v]⁺ − [Σ (x − c) × M v] = Σ (x_m − c) × M (v⁺ − v) + h Σ_k κ_k,
///   h κ_k = Σ (x⁺ − x_m) × p_k⁺ − Σ (x − x_m) × p_k,   p_k = ½ (φ_k M v + M φ_k v),
/// φ_k the nodes' shares of holder k (so Σ_k p_k = M v, and Σ v × p_k = 0 for each). The first sum
/// holds the moments of the reactions r and of the external forces, both with the arms x_m, and
/// what the linearised elastic forces have of one, m = Σ (x_m − c) × (M (v⁺ − v)/h − f_ext − r).
/// Torques about P with the arms x_m − P, and further
///   t_k −= κ_k + μ_k m,   μ_k = Σ_i m_i φ_ik / Σ_i m_i,
/// close the angular momentum of a part and its ports to round-off over every step; damping forces
/// count as external ones and keep the moments that they have. κ and m are of first order in h: the
/// port's own motion and the body's elastic one during the turn.
///
/// The ground takes up the m of what it holds (μ = 0). Internal forces of the linear formulation
/// have moments: there μ = 0 and h κ_k = Σ (x⁺ − x − h v⁺) × p_k⁺ alone.
class AngularBalance {
 public:
  struct Step {
    const State& begin;
    const Carried& carried;
    const Eigen::VectorXd& momentum;  ///< M v at the beginning (kg m/s)
    const Eigen::VectorXd& behind;    ///< M (x − x̃) there (kg m)
    const State& after;
    const Eigen::VectorXd& external;  ///< loads, weight and damping forces of the nodes (N)
    const Eigen::VectorXd& react;     ///< of all ports and of the ground on the nodes (N)
  };
  AngularBalance(const Model& model, const Carry& carry, const Step& step);

  void add(WrenchSet& wrenches) const;

  /// A direction's derivatives; of the beginning of the step empty where it does not change.
  struct Change {
    const Eigen::VectorXd& x_end;     ///< m
    const Eigen::VectorXd& v_end;     ///< in W (m/s)
    const Eigen::VectorXd& react;     ///< N
    const Eigen::VectorXd& damping;   ///< of the damping forces; empty: none (N)
    const Eigen::VectorXd& x_begin;   ///< m
    const Eigen::VectorXd& v_begin;   ///< m/s
    const Eigen::VectorXd& x_middle;  ///< of x_m (m)
  };
  /// Adds the derivative of what add() adds.
  void add_change(const Change& change, WrenchSet& wrenches) const;

  /// The same as a linear map, where the beginning of the step does not change, there is no
  /// damping, and x⁺ of a node that no port holds rigidly moves by h Q^½ δv + Σ_l φ_l (δp_l − h Q^½
  /// δv_l).
  struct Rows {
    Eigen::MatrixXd free;   ///< 3 columns per port, transposed: of δv of the free nodes
    Eigen::MatrixXd ports;  ///< 3 rows per port: of (δp, δv) of the ports' origins, by those nodes
    Eigen::MatrixXd arms;  ///< ½ (φ_k M + M φ_k)(x⁺ − x_m) + μ_k M (x_m − c), a column a port
    Eigen::MatrixXd momenta;  ///< p_k⁺, a column a port
    Eigen::VectorXd mass;     ///< μ by port
    std::vector<std::size_t> part_of_node, part_of_port;
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
  /// A field over the nodes with its product with the mass matrix.
  struct Weighed {
    Eigen::VectorXd a, Ma;
  };
  [[nodiscard]] Weighed weighed(Eigen::VectorXd a) const;
  /// ½ Σ φ_i (a_i × (M b)_i + (M a)_i × b_i).
  [[nodiscard]] Eigen::Vector3d moment(const Share& share, const Weighed& a,
                                       const Weighed& b) const;
  /// ½ (φ M a + M φ a) on the nodes of the part, zero elsewhere.
  [[nodiscard]] Eigen::VectorXd shared(const Share& share, const Weighed& a) const;

  const Model& model_;
  const Carry& carry_;
  const Step step_;
  double h_s_;
  bool rotates_;
  Weighed v_, v_end_;         ///< m/s, kg m/s
  Weighed out_, back_;        ///< x⁺ and x less what they are compared with in κ (m, kg m)
  Eigen::VectorXd internal_;  ///< (p⁺ − p)/h − f_ext − r (N)
  Eigen::VectorXd arm_;       ///< x_m − c (m)
  std::vector<Share> shares_;
};

/// Of a step that was made.
[[nodiscard]] inline AngularBalance::Step balanced(const State& begin, const Linearisation& kept,
                                                   const TransientStep::Result& result) {
  return {.begin = begin,
          .carried = kept.carried,
          .momentum = kept.momentum,
          .behind = kept.behind,
          .after = result.state,
          .external = result.external,
          .react = result.on_nodes};
}

}  // namespace tandem::fem

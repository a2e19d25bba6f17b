#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "fem_process/ports/loose_ports.h"

namespace tandem::fem {

/// Derivatives of what averaging ports and bushings add to a step, at the step's solution, along
/// changes of the motions of all ports in the coordinates of difference(), 12 per port. Derivatives
/// with respect to a port's rotation follow from those of positions and forces, because turning
/// port, nodes and forces together changes no relation.
class LooseTangent {
 public:
  struct Solution {
    PortsSeen end;        ///< motions at the end of the step, as the balance has them
    Eigen::VectorXd x;    ///< x̃ + d: positions in the balance (m)
    Eigen::VectorXd v;    ///< m/s
    Eigen::VectorXd phi;  ///< forces of the ports
    Eigen::MatrixXd Y;    ///< see LoosePorts
    double c_x = 0.0;
  };
  LooseTangent(const LoosePorts& ports, const Solution& solution);

  /// Of PortsSeen.
  struct SeenChange {
    Eigen::VectorXd motions;            ///< 12 per port, as in difference()
    std::vector<Eigen::Matrix3d> back;  ///< per loose port
  };
  /// δφ that closes the relations' derivatives, which have dx, dv (all nodes) and dφ so far.
  [[nodiscard]] Eigen::VectorXd correction(const Eigen::VectorXd& dx, const Eigen::VectorXd& dv,
                                           const Eigen::VectorXd& d_phi,
                                           const SeenChange& d_end) const;

 private:
  const LoosePorts& ports_;
  PortsSeen end_;
  Eigen::VectorXd q_;
  Eigen::VectorXd q_rate_;
  Eigen::VectorXd phi_;
  std::vector<PortRelation> relations_;
  Eigen::VectorXd row_scale_;
  Eigen::PartialPivLU<Eigen::MatrixXd> G_;
};

/// Adds the derivative of LoosePorts::add_wrenches(): the points, arms q and forces φ change by
/// `d_about` (3 per port), dq and dφ.
void add_wrench_derivative(const LoosePorts& ports, const std::vector<Eigen::Vector3d>& about,
                           const Eigen::VectorXd& q, const Eigen::VectorXd& phi,
                           const Eigen::VectorXd& d_about, const Eigen::VectorXd& dq,
                           const Eigen::VectorXd& d_phi, WrenchSet& wrenches);

}  // namespace tandem::fem

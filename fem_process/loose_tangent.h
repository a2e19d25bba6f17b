#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "fem_process/loose_ports.h"

namespace tandem::fem {

/// Derivatives of what averaging ports and bushings add to a step, at the step's solution. A change
/// of the input is the change of one port's motion in the coordinates of difference(). Derivatives
/// with respect to a port's rotation follow from those of positions and forces, because turning
/// port, nodes and forces together changes no relation.
class LooseTangent {
 public:
  struct Solution {
    MotionSet end;        ///< motions at the end of the step
    Eigen::VectorXd x;    ///< x̃ + d: positions in the balance (m)
    Eigen::VectorXd v;    ///< m/s
    Eigen::VectorXd phi;  ///< forces of the ports
    Eigen::MatrixXd Y;    ///< see LoosePorts
    double c_x = 0.0;
  };
  LooseTangent(const LoosePorts& ports, const Solution& solution);

  struct Change {
    std::size_t port = 0;  ///< index in the scenario's table
    Vector12 motion;       ///< of its motion at the end of the step
  };

  /// Derivative of LoosePorts::prescribe(), `d_map` and `d_rigid` those of what the step knows
  /// beforehand (null: they stay).
  LoosePorts::Rates prescribe(const StepMap& map, const LoosePorts::RigidStep& rigid,
                              const StepMap* d_map, const LoosePorts::RigidStep* d_rigid,
                              const Change& change, Eigen::VectorXd& dd, Eigen::VectorXd& da) const;

  /// δφ that closes the relations' derivatives, which have dx, dv (all nodes) and dφ so far.
  [[nodiscard]] Eigen::VectorXd correction(const Eigen::VectorXd& dx, const Eigen::VectorXd& dv,
                                           const Eigen::VectorXd& d_phi,
                                           const Change& change) const;

  /// Derivative of LoosePorts::follow(): of x from that of x̃ + d.
  void follow(const Change& change, Eigen::VectorXd& dx) const;

 private:
  /// Derivative of the rigid part of a field with the coordinates η, which change by dη.
  void add_rigid_part(const NodeAverage& average, const Eigen::Matrix3d& R, const Vector12& eta,
                      const Vector12& d_eta, const Eigen::Vector3d& turn,
                      Eigen::VectorXd& field) const;

  const LoosePorts& ports_;
  MotionSet end_;
  Eigen::VectorXd q_;
  Eigen::VectorXd q_rate_;
  Eigen::VectorXd phi_;
  std::vector<PortRelation> relations_;
  Eigen::VectorXd row_scale_;
  Eigen::PartialPivLU<Eigen::MatrixXd> G_;
};

/// Adds the derivative of LoosePorts::add_wrenches(): poses, arms q and forces φ change by
/// `d_pose` (see difference(), one port's), dq and dφ.
void add_wrench_derivative(const LoosePorts& ports, const MotionSet& pose, const Eigen::VectorXd& q,
                           const Eigen::VectorXd& phi, const LooseTangent::Change& d_pose,
                           const Eigen::VectorXd& dq, const Eigen::VectorXd& d_phi,
                           WrenchSet& wrenches);

}  // namespace tandem::fem

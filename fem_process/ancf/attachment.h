#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/ancf/beam_mesh.h"
#include "protocol/contract/port.h"

namespace tandem::fem::ancf {

/// An end of an open chain that is fixed to the body of a port.
struct Attachment {
  int port = 0;
  bool at_end = false;                ///< else at the beginning
  Support support = Support::Hinged;  ///< Hinged: its point. Clamped: its gradients as well
};

/// The ends of a chain that follow port frames as they lie in them at t = 0:
///   r = p_WP + R_WP p_P,    v = v_WP + w_WP × R_WP p_P            (the point)
///   g = R_WP g_P,           g' = w_WP × g                          (gradients of a clamped end)
/// Their vectors are prescribed unknowns; what the balance R = f_ext − f_int + f_contact − M a
/// leaves there is the load of the chain on the body:
///   f = R_r,    t = R_WP p_P × R_r + Σ g × R_g                     (virtual work)
class Attachments {
 public:
  Attachments() = default;
  /// Fixes the attached vectors of the mesh.
  Attachments(BeamMesh& mesh, const std::vector<Attachment>& attached);

  [[nodiscard]] bool empty() const { return vectors_.empty(); }
  /// Takes the places of the ends in the port frames: once, at t = 0.
  void take_places(const MotionSet& motions, const Eigen::VectorXd& q);

  /// Writes the attached unknowns and their rates.
  void place(const MotionSet& motions, Eigen::VectorXd& q, Eigen::VectorXd& v) const;
  /// Takes positions, rates and accelerations of the attached unknowns to the end of a step of
  /// length h > 0. A mean acceleration ā = (v⁺ − v)/h is kept in A,
  ///   a⁺ = ā + ½ (ā − ā_n):
  /// second order, and jumps of the port's velocity are forgotten after two steps.
  void advance(const MotionSet& motions, double h_s, const Eigen::VectorXd& v_begin,
               const Eigen::VectorXd& A_begin, Eigen::VectorXd& q, Eigen::VectorXd& v,
               Eigen::VectorXd& a, Eigen::VectorXd& A) const;
  /// ∂a⁺/∂v⁺ of advance().
  [[nodiscard]] static double acceleration_rate(double h_s) { return 1.5 / h_s; }

  /// Adds the wrenches of the balance R (before attached rows are cleared).
  void add_wrenches(const MotionSet& motions, const Eigen::VectorXd& balance,
                    WrenchSet& wrenches) const;

  /// Derivatives of the attached unknowns by the motions [p | θ | v | w] of all ports, with zero
  /// rows elsewhere: positions, rates; `loads`: λ = loadsᵀ R, and ∂λ/∂m at fixed R.
  struct Derivatives {
    Eigen::MatrixXd q, v;   ///< unknowns × 12P
    Eigen::MatrixXd loads;  ///< unknowns × 6P
    Eigen::MatrixXd turn;   ///< 6P × 12P
  };
  [[nodiscard]] Derivatives derivatives(const MotionSet& motions,
                                        const Eigen::VectorXd& balance) const;

 private:
  /// A prescribed vector, and what it is in its port's frame: an arm (m) or a gradient.
  struct Vector {
    int port = 0;
    Eigen::Index row = 0;  ///< of its first unknown
    bool point = false;
    Eigen::Vector3d in_port = Eigen::Vector3d::Zero();
  };
  std::vector<Vector> vectors_;
};

}  // namespace tandem::fem::ancf

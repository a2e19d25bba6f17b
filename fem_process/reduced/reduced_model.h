#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "fem_process/body/model.h"
#include "fem_process/ports/floating_frame.h"
#include "fem_process/reduced/component_modes.h"
#include "fem_process/turning/elastic_turn.h"

namespace tandem::fem {

/// Motion of the nodes in the reduced body's terms, 3 × fields(): x_i = Y n_i with the values n_i
/// of the scalar fields at node i. Velocities, accelerations and their derivatives have the same
/// form.
using FieldMotion = Eigen::Matrix3Xd;

/// A body reduced to few coordinates by component mode synthesis in a floating frame F
/// [Craig & Bampton 1968; Shabana 2013, chapter 5]:
///   x_i = p_WF + R_WF (X_i − X_F + Σ_c B_c,i z_c),   z = [ζ; η]
/// B: constraint modes of the rigid parts (every port; all fixed nodes together are one more), then
/// normal modes of the body with its boundary held. ζ follows from the parts' poses, η is solved
/// for. The components of 1, X − X_F and B_c are scalar fields, so that x = [p_WF | R_WF | R_WF z_1
/// | …] times their values, and the mass matrix m ⊗ I₃ of the mesh becomes the Gram matrix T = Nᵀ m
/// N: all inertia invariants at once, none left out. Const after construction.
class ReducedModel {
 public:
  /// `motions` of the ports at t = 0. `model` must outlive this.
  ReducedModel(const Model& model, const BoundaryModes& modes, const MotionSet& motions);

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const FloatingFrame& frame() const { return frame_; }
  [[nodiscard]] Eigen::Index boundary() const { return K_boundary_.rows(); }  ///< size of ζ
  [[nodiscard]] Eigen::Index modes() const { return omega2_.size(); }         ///< size of η
  [[nodiscard]] Eigen::Index fields() const { return T_.rows(); }
  /// Motions of all rigid parts: the ports', and rest for the fixed nodes.
  [[nodiscard]] MotionSet with_ground(const MotionSet& ports) const;

  /// [p | R | R z_1 | R z_2 | …], the second block times `one`: 0 for derivatives.
  [[nodiscard]] static FieldMotion fields_of(const Eigen::Vector3d& p, const Eigen::Matrix3d& R,
                                             double one, const Eigen::VectorXd& z);

  [[nodiscard]] const Eigen::MatrixXd& T() const { return T_; }  ///< kg times the fields' units
  /// Stiffness of the constraint modes; that of the normal modes is diagonal, and there is none
  /// between the two.
  [[nodiscard]] const Eigen::MatrixXd& K_boundary() const { return K_boundary_; }
  [[nodiscard]] const Eigen::VectorXd& omega2() const { return omega2_; }
  /// Φᵀ (a ×) Φ with the mass: the modes' Coriolis coupling for the axes of F (kg).
  [[nodiscard]] const std::array<Eigen::MatrixXd, 3>& coriolis() const { return coriolis_; }

  /// How far elements turn in F with [ζ; η].
  [[nodiscard]] const ElasticTurn& elastic_turn() const { return *turn_; }

  /// Forces on the fields (N): gravity; loads without and with it at time t.
  [[nodiscard]] const FieldMotion& gravity() const { return gravity_; }
  [[nodiscard]] FieldMotion loads(double t_s) const;
  [[nodiscard]] FieldMotion external_forces(double t_s) const;

  /// Positions of all nodes (m) in equilibrium with `factor` times the external forces of time t,
  /// the rigid parts where they were at t = 0. Throws a Usage error for a body free to move.
  [[nodiscard]] Eigen::VectorXd equilibrium(double factor, double t_s) const;

  /// Values 3 × nodes, as one vector, of a motion of the fields.
  [[nodiscard]] Eigen::VectorXd expand(const FieldMotion& motion) const;
  /// Normal modes' part of a field of the nodes, Φᵀ M v.
  [[nodiscard]] Eigen::VectorXd project(const Eigen::VectorXd& nodal) const;

 private:
  struct LoadField {
    FieldMotion unit;  ///< N
    Law law;
  };

  const Model& model_;
  FloatingFrame frame_;
  Motion ground_;
  bool grounded_ = false;
  Eigen::MatrixXd N_;  ///< nodes × fields
  Eigen::MatrixXd T_;
  Eigen::MatrixXd K_boundary_;
  Eigen::VectorXd omega2_;
  std::array<Eigen::MatrixXd, 3> coriolis_;
  FieldMotion gravity_;
  std::optional<ElasticTurn> turn_;
  std::vector<LoadField> loads_;
};

/// What carries the floating frame, per port and then for the fixed nodes. Throws a Usage error at
/// the scenario's place when no port has the name.
[[nodiscard]] std::vector<double> frame_weights(const Model& model);

/// Where the normal modes' scalar fields begin; three per mode.
[[nodiscard]] inline Eigen::Index first_modal_field(const ReducedModel& reduced) {
  return 4 + 3 * reduced.boundary();
}

}  // namespace tandem::fem

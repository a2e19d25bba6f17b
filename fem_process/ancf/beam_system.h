#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/ancf/beam_kernel.h"
#include "fem_process/ancf/beam_mesh.h"
#include "fem_process/ancf/klu_solver.h"
#include "fem_process/ancf/point_law.h"
#include "protocol/scenario/law.h"

namespace tandem::fem::ancf {

/// A dead force at a point of the centre line, times a law of time.
struct PointLoad {
  int element = 0;
  double xi = 0.0;
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Law law{ConstantLaw{1.0}};
};

/// Everything about a beam structure that does not change.
struct BeamModel {
  BeamMesh mesh;
  BeamSection section;
  BeamMaterial material;
  Integration integration = Integration::Full;
  GaussOrder order;
  Strain strain = Strain::Assumed;
  Eigen::Vector3d gravity_m_per_s2 = Eigen::Vector3d::Zero();
  std::vector<PointLoad> loads;
};

/// Beams with their connections: assembled mass, forces and tangents of M a = f_ext − f_int.
/// The connections are those of the mesh's constant projection B: M = Bᵀ M_e B, f = Bᵀ f_e.
class BeamSystem {
 public:
  explicit BeamSystem(BeamModel model);

  [[nodiscard]] const BeamModel& model() const { return model_; }
  [[nodiscard]] const BeamMesh& mesh() const { return model_.mesh; }
  [[nodiscard]] const BeamKernel& kernel() const { return kernel_; }
  [[nodiscard]] const KluSolver& solver() const { return solver_; }
  [[nodiscard]] ElementArrays element_arrays() const;

  /// M x.
  [[nodiscard]] Eigen::VectorXd mass_times(const Eigen::VectorXd& x) const;
  [[nodiscard]] double mass_kg() const { return mass_kg_; }
  /// Gravity and loads at time t (N).
  [[nodiscard]] Eigen::VectorXd external_forces(double t_s) const;
  /// Loads alone at time t (N).
  [[nodiscard]] Eigen::VectorXd load_forces(double t_s) const;
  [[nodiscard]] double kinetic_J(const Eigen::VectorXd& v) const {
    return 0.5 * v.dot(mass_times(v));
  }
  [[nodiscard]] double elastic_J(const Eigen::VectorXd& q) const { return kernel_.energy(q); }
  /// Zero at the world origin.
  [[nodiscard]] double potential_J(const Eigen::VectorXd& q) const {
    return -gravity_forces_.dot(q);
  }
  /// Σ ∫ ρ r' dV (kg m/s).
  [[nodiscard]] Eigen::Vector3d momentum(const Eigen::VectorXd& v) const;

  /// f += Bᵀ f_e.
  void add_forces(const ElementArrays& elements, Eigen::VectorXd& f) const;
  /// Σ Bᵀ K_e B + mass_factor M.
  void sum(const ElementArrays& elements, double mass_factor, std::vector<double>& values) const;
  /// Makes rows and columns of fixed unknowns unit ones.
  void hold(std::vector<double>& values) const;
  /// Both.
  void assemble(const ElementArrays& elements, double mass_factor,
                std::vector<double>& values) const {
    sum(elements, mass_factor, values);
    hold(values);
  }
  /// Zero at fixed unknowns.
  void clear_fixed(Eigen::Ref<Eigen::VectorXd> x) const;

 private:
  /// Two terms of an element and the 3 × 3 block that they enter.
  struct BlockTerm {
    int element_entry = 0;  ///< of the block's first entry in the element's tangent
    int position = 0;       ///< of the block's first entry in the values
    int stride = 0;         ///< from one of its columns to the next
    double factor = 1.0;
  };
  struct MassEntry {
    int row = 0, column = 0;  ///< vectors
    double mass = 0.0;
    int position = 0, stride = 0;
  };
  void list_blocks();
  void list_masses();
  [[nodiscard]] static ColumnPattern pattern_of(const BeamMesh& mesh);

  BeamModel model_;
  BeamKernel kernel_;
  KluSolver solver_;
  std::vector<std::vector<BlockTerm>> blocks_;  ///< per element
  std::vector<MassEntry> masses_;
  std::vector<int> cleared_;  ///< positions in rows and columns of fixed unknowns
  std::vector<int> units_;    ///< their diagonal
  Eigen::VectorXd gravity_forces_;
  double mass_kg_ = 0.0;
};

/// Where an equilibrium search ended.
struct Equilibrium {
  bool found = false;
  int iterations = 0;
  double residual_N = 0.0;
};
/// Newton's iteration on factor · f_ext(t) = f_int(q) from the given q, which it overwrites.
/// Converged when the largest change of an unknown is below `tolerance_m`.
Equilibrium find_equilibrium(const BeamSystem& system, double t_s, double factor,
                             double tolerance_m, int most_iterations, Eigen::VectorXd& q);

}  // namespace tandem::fem::ancf

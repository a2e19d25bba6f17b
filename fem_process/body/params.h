#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fem_process/body/boundary.h"
#include "fem_process/elements/formulation_kind.h"
#include "fem_process/elements/mass.h"
#include "fem_process/material/materials.h"
#include "fem_process/mesh/mesh.h"
#include "fem_process/solvers/linear_solver.h"
#include "protocol/contract/sim_time.h"
#include "protocol/scenario/attachment.h"
#include "protocol/scenario/law.h"

namespace tandem::fem {

/// Rayleigh damping C = α M + β K: K is the formulation's stiffness at the present positions.
struct Damping {
  double alpha_per_s = 0.0;
  double beta_s = 0.0;
};

enum class IntegratorKind { BackwardEuler, Hht, GeneralisedAlpha, Newmark, QuasiStatic };

struct IntegratorParams {
  IntegratorKind kind = IntegratorKind::BackwardEuler;
  double hht_alpha = -0.05;    ///< in [−1/3, 0]; 0 is the trapezoidal rule
  double rho_infinity = 0.9;   ///< generalised-α, in [0, 1]; 1 damps nothing
  double newmark_beta = 0.25;  ///< with γ = ½: average acceleration
  double newmark_gamma = 0.5;
  /// 0: the single linearised step of [Marinkovic & Zehn 2012], or 100 with QuasiStatic.
  int newton_steps = 0;
  double newton_tolerance = 1e-8;  ///< residual relative to the largest kind of force
};

/// Component mode synthesis; see ReducedModel.
struct CraigBamptonParams {
  int modes = 20;  ///< normal modes, when no limit is given
  std::optional<double> frequency_limit_Hz;
  SetName frame{.name = "mean"};  ///< "mean" of all rigid parts, a port's name, or "world"
};

/// A dead load (fixed direction in W, reference areas) times a law of time.
struct Load {
  enum class Kind {
    Nodal,        ///< `value` is the total force (N), in equal parts on the nodes of the set
    Surface,      ///< `value` is the traction (Pa), ∫ N_i dA of it at node i
    SurfaceForce  ///< `value` is the total force (N) of such a uniform traction
  };
  Kind kind = Kind::Nodal;
  SetName set;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Law law{ConstantLaw{1.0}};
};

/// v(X) = linear + angular × (X − about) + gradient (X − about), in W.
struct InitialVelocity {
  Eigen::Vector3d linear_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d about_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient_per_s = Eigen::Matrix3d::Zero();
};

/// A port: its name, the node set that hangs on its frame, and how.
struct PortSet {
  std::string name;
  SetName set;
  std::optional<Eigen::Vector3d> p_WP;  ///< Po at t = 0 (m), when the scenario states it
  scenario::Attachment attachment{};
};

struct Params {
  MeshParams mesh;
  Material material;                       ///< of all elements when `materials` is empty
  std::vector<MaterialSection> materials;  ///< every element in exactly one
  FormulationKind formulation = FormulationKind::Corotational;
  CraigBamptonParams craig_bampton;
  MassKind mass = MassKind::Consistent;
  Damping damping;
  IntegratorParams integrator;
  SolverParams solver;
  int threads = 1;  ///< of the loops of a step; the results do not depend on it
  SimTime micro_step{};
  /// No micro step of its own: one step as long as the macro step, whatever that is. `micro_step`
  /// is then the nominal macro step.
  bool follows_macro_step = false;
  Eigen::Vector3d gravity_m_per_s2 = Eigen::Vector3d::Zero();
  std::vector<SetName> fixed;
  std::vector<Load> loads;
  InitialVelocity initial_velocity;
  std::vector<PortSet> ports;
  bool nodal = false;               ///< every free node is a mass of the multibody side: NodalBody
  std::vector<SetName> node_ports;  ///< then: the ports as the scenario has them
  std::vector<ScheduledChange> changes;  ///< of fixed sets and forces, times ascending
  std::vector<SetName> watch;            ///< node sets whose mean motion is reported
};

/// Throws a Usage error that names the first bad value. Names of sets are checked by the model.
void check(const Params& params);

}  // namespace tandem::fem

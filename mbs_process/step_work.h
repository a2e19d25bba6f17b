#pragma once

#include <vector>

#include "mbs_process/params.h"
#include "mbs_process/state.h"

namespace tandem::mbs {

/// Wrenches on all bodies during one dWorldStep, sorted by what becomes of their work.
struct SortedWrenches {
  std::vector<BodyWrench> driven;      ///< force laws
  std::vector<BodyWrench> viscous;     ///< dampers
  std::vector<BodyWrench> elastic;     ///< springs
  std::vector<BodyWrench> ports;       ///< the flexible side's
  std::vector<BodyWrench> gyroscopic;  ///< −w × I w as the step has it
  std::vector<BodyWrench> motors;      ///< reactions of joints with a motor
  std::vector<BodyWrench> joints;      ///< reactions of all other joints

  /// Zero wrenches on so many bodies.
  void reset(std::size_t bodies);
};

/// Work of constant wrenches over h while the bodies move with the velocities of `moving` (J).
[[nodiscard]] double work_J(const std::vector<BodyWrench>& wrenches,
                            const std::vector<BodyState>& moving, double h_s);

/// Σ ½ m |v_b − v_a|² + ½ (w_b − w_a)·I (w_b − w_a), I in the poses of `a`, of bodies with mass
/// (J).
[[nodiscard]] double velocity_change_J(const Params& params, const std::vector<BodyState>& a,
                                       const std::vector<BodyState>& b);

/// Work (J) that the inertia takes which stands in for that of junctions, whose velocities go from
/// those of `a` to those of `b` in a step that moves them with those of `moving`:
///   Σ m (v_b − v_a)·v + I (w_b − w_a)·w.
[[nodiscard]] double stand_in_work_J(const Params& params, const std::vector<BodyState>& a,
                                     const std::vector<BodyState>& b,
                                     const std::vector<BodyState>& moving);

/// The gyroscopic torque of a dWorldStep that makes it implicit [Lacoursière 2006]:
///   τ = I (w̃ − w)/h,   I w̃ + h w̃ × I w = I w.
[[nodiscard]] Eigen::Vector3d implicit_gyroscopic_torque(const BodyParams& body,
                                                         const BodyState& state, double h_s);

/// Works of the wrenches of one micro step (J), all by the displacement that the step makes, and
/// what it books. A step of semi-implicit Euler is x⁺ = x ⊕ h v⁺, M (v⁺ − v) = h Σ f, so that
///   Δ(½ v·M v) = Σ f·h v⁺ − ½ |v⁺ − v|²_M;
/// Verlet's, with the half steps M (u − v) = ½ h Σ f, M (v⁺ − u) = ½ h Σ f⁺ and x⁺ = x ⊕ h u,
///   Δ(½ v·M v) = Σ ½ (f + f⁺)·h u − ½ |u − v|²_M + ½ |v⁺ − u|²_M.
/// I turns with the body about w, which leaves w·I w as it is.
struct StepWork {
  double driven_J = 0.0;
  double viscous_J = 0.0;
  double elastic_J = 0.0;
  double ports_J = 0.0;
  double gyroscopic_J = 0.0;
  double reactions_J = 0.0;     ///< of all joints
  double motors_J = 0.0;        ///< of those with a motor, by the rates they enforce
  double kinetic_loss_J = 0.0;  ///< ½ |v⁺ − v|²_M, or ½ |u − v|²_M − ½ |v⁺ − u|²_M
  double stored_change_J = 0.0;  ///< of the springs
  double interface_J = 0.0;      ///< of the port wrenches in the port motions
  double stand_in_J = 0.0;       ///< of that, what junctions' stand-in inertias have taken

  /// Adds the works of one dWorldStep, forces to the `share`: reactions are those of the whole h.
  void add(const SortedWrenches& wrenches, const std::vector<BodyState>& moving, double h_s,
           double share);

  /// Books the step. The numerical loss is what the discrete kinetic energy loses, what the springs
  /// take more than they store (their force is that of the beginning), the work of gyroscopic
  /// torques and of joint reactions (erp, cfm), and the turning of the ports' arms within the step:
  ///   kinetic_loss − gyroscopic − (elastic + stored_change) − (reactions − motors)
  ///   + (interface − ports).
  void book(EnergyBook& book) const;
};

}  // namespace tandem::mbs

#pragma once

#include "fem_process/body/model.h"
#include "fem_process/transient/angular_balance.h"
#include "fem_process/transient/transient_step.h"

namespace tandem::fem {

/// Whether the derivative of a macro step of one micro step is condense()'s:
/// prescribed nodes enter the balance of forces as free ones do, and neither a
/// history nor an iteration adds to it.
[[nodiscard]] bool condenses(const Model& model, const Linearisation& kept);

/// Derivative of the wrenches at the end of a macro step of one backward Euler
/// step with respect to the motions there: the Schur complement of the step
/// matrix S onto the ports,
///   ∂λ/∂m = −T_bᵀ (S_pp − S_pI S_II⁻¹ S_Ip) T_e,
/// T the rigid velocities of the port nodes per coordinate, with the arms of
/// the torques at fixed motions, and those at the end of the step. Columns x_c =
/// −S_II⁻¹ S_Ip T_c are solved roughly: with what is left of their equations,
/// r_c, and a symmetric S
///   T_wᵀ S_pI S_II⁻¹ S_Ip T_c = −T_wᵀ S_pI x_c + x_wᵀ r_c + r_wᵀ S_II⁻¹ r_c.
/// The last term, of second order, is left out, and with it the turn of the
/// arms within the step in x_w. The rows B of AngularBalance likewise: with
/// y = S_II⁻¹ Bᵀ, B x = B x_c + yᵀ r_c. 6P × 12P.
struct CondensedTorques {
  const TorqueArms& arms;
  const AngularBalance& angular;  ///< its rows come on top
};
SolveReport condense(const Model& model, const PortArms& arms, const MotionSet& end,
                     const CondensedTorques& torques, const Linearisation& kept,
                     InterfaceJacobian& jacobian);

}  // namespace tandem::fem

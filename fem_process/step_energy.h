#pragma once

#include <Eigen/Core>

#include "fem_process/model.h"
#include "fem_process/transient_step.h"

namespace tandem::fem {

/// What a step made, as far as its works need it.
struct StepForces {
  const Linearisation& kept;  ///< of the step's balance of forces
  const LoosePorts& loose;
  const Eigen::VectorXd& f_begin;    ///< f_int at the step's first x̃ (N)
  const Eigen::VectorXd& d;          ///< x⁺ − x̃ as the balance has it (m)
  const Eigen::VectorXd& react;      ///< forces of all ports on the nodes at the end (N)
  const Eigen::VectorXd& commanded;  ///< nodal forces by command (N)
  const MotionSet& motions;          ///< of the ports at the end
  const WrenchSet& wrenches;         ///< at the end
};

/// Books a step from `begin` to `after`, whose time, x, v and accelerations are there, in `after`.
///
/// Backward Euler balances forces at the end, so its works are those of end-of-step forces over the
/// step. With Δv = v⁺ − v, D = h v⁺ and C = α M + β K
///   interface = −h Σ λ⁺·V⁺,  external = f⁺·Δx,  damping = D·C v⁺,
///   numerical = ½ Δv·M Δv + ½ D·K D + kinematic,
/// kinematic because prescribed nodes go to their port's pose, e = Δx − D beyond the balance:
///   kinematic = e·(M Δv/h + C v⁺) − ½ e·K e − Δx·g⁺ + interface.
/// ½ D·K D is exact for linear bodies. For others K leaves out how the force turns with the
/// elements; once the next step knows f_int(x⁺) it adds what makes the strain energy's change the
/// trapezoid ½ Δx·(f_int(x) + f_int(x⁺)). The book thus lags by that term of the last step.
///
/// All others balance forces at both ends, M q + C v + f_int − f_ext = g: works are trapezoids over
/// the displacement,
///   interface = −½ Σ (λ + λ⁺)·Δ(pose),  external = ½ (f + f⁺)·Δx,  damping = ½ Δx·(C v + C⁺ v⁺),
///   numerical = ½ Δx·M (q + q⁺) − ½ (v + v⁺)·M Δv − ½ Δx·(g + g⁺) + interface.
/// By Newmark's rule the first two are h² (β − γ/2) Δq·M q̄ − h (γ − ½) v̄·M Δq [Hughes 1987, 9.1].
/// For HHT, M q is what its weighed forces leave: g − r.
///
/// Bushings store energy and damp by themselves: both are taken off what their ports put in.
///
/// What is left is the error of the strain energy: zero for linear bodies, O(|Δx|³) a step else.
void book_step(const Model& model, const State& begin, const StepForces& step, State& after);

/// ½ v·M v (J); 0 in statics.
[[nodiscard]] double kinetic_energy_J(const Model& model, const Eigen::VectorXd& v);

/// What the dampers of bushings take (W): the part of their forces that vanishes where the nodes
/// move with the port, times the rates between the two.
[[nodiscard]] double bushing_loss_W(const LoosePorts& loose, const MotionSet& motions,
                                    const Eigen::VectorXd& q, const Eigen::VectorXd& q_rate);

/// Fills what the first step's trapezoids need of a state in balance with the stiffness K: its
/// reactions and damping forces.
void book_start(const Model& model, const BlockValues& K, const Eigen::VectorXd& react,
                State& state);

}  // namespace tandem::fem

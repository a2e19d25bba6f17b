#pragma once

#include <Eigen/Core>

#include "fem_process/body/model.h"
#include "fem_process/transient/transient_step.h"

namespace tandem::fem {

/// What a step made, as far as its works need it.
struct StepForces {
  const Linearisation& kept;  ///< of the step's balance of forces
  const Carried& carried;
  const LoosePorts& loose;
  const Carry& carry;
  const Eigen::VectorXd& f_begin;    ///< f_int at the step's first x̃ (N)
  const Eigen::VectorXd& d;          ///< x⁺ − x̃ as the balance has it (m)
  const Eigen::VectorXd& react;      ///< forces of all ports on the nodes at the end (N)
  const Eigen::VectorXd& commanded;  ///< nodal forces by command (N)
  const Eigen::VectorXd& damped;     ///< velocities that β K damps (m/s); empty without damping
  const Eigen::VectorXd& dragged;    ///< velocities that α M damps (m/s); empty without damping
  const MotionSet& motions;          ///< of the ports at the end
  const WrenchSet& wrenches;         ///< at the end
};

/// Books a step from `begin` to `after`, whose time, x, v and accelerations are there, in `after`.
///
/// Backward Euler, in the axes of MiddleCarry. With Δv = v⁺ − v, v̄ = ½ (v + v⁺), Δx = x⁺ − x, and δ
/// the displacement without the turn, Q^−½ (x⁺ − c − Q (x − c)):
///   interface = −h Σ λ·V⁺,  external = f⁺·Δx,  damping = h (v⁺·α M v⁺ + w·β K w)  (w what β K
///   damps),
/// The kinetic energy changes by v̄·M Δv, which is h v̄ times all forces of the balance, so that
///   numerical = f_ext·(Δx − h v̄) + interface − h v̄·g + h v̄·(α M v⁺ + β K w) − damping
///               + h v̄·(T f + K d) − ΔU,   ΔU = δ·f(x̃) + ½ δ·K δ,
/// gravity among f_ext. In translation this is ½ Δv·M Δv + ½ d·K d, and what port nodes, which go
/// to their port's pose, move beyond h v⁺. For others than linear bodies K leaves out how the force
/// turns with the elements; once the next step knows f(x⁺) it adds what makes ΔU the trapezoid ½
/// δ·(f(x) + f(x⁺)). The book thus lags by that term of the last step.
///
/// All others balance forces at both ends, M q + C v + f_int − f_ext = g: works are trapezoids over
/// the displacement,
///   interface = −½ Σ (λ + λ⁺)·Δ(pose),  external = ½ (f + f⁺)·Δx,  damping = ½ Δx·(C v + C⁺ v⁺),
///   numerical = ½ Δx·M (q + q⁺) − ½ (v + v⁺)·M Δv − ½ Δx·(g + g⁺) + interface.
/// By Newmark's rule the first two are h² (β − γ/2) Δq·M q̄ − h (γ − ½) v̄·M Δq [Hughes 1987, 9.1].
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
/// reactions and the damping forces of the velocities `damped`.
void book_start(const Model& model, const BlockValues& K, const Eigen::VectorXd& react,
                const Eigen::VectorXd& damped, State& state);

}  // namespace tandem::fem

#pragma once

#include <Eigen/Core>

#include "fem_process/body/integrator.h"
#include "fem_process/body/state.h"
#include "fem_process/reduced/reduced_model.h"

namespace tandem::fem {

/// What a step of Newmark's family starts from when the fields R, R z_c turn with the frame: with
/// its rate ω at the beginning, r a field there and Q = exp(h [ω]×),
///   a⁺ = ω² Q r + (what the integrator's recursion makes of the velocities in W and of
///   Q (a − ω² r)) − (what it makes of the velocities of a steady turn, ω × r and ω × Q r),
/// ω² r = ω × (ω × r). In steady turning a⁺ is the centripetal acceleration; in any other motion
/// this changes a⁺ by O(h²), what differences of turning velocities leave. The history of the
/// recursion is that of the accelerations beyond ω² r. The first field, p_WF, does not turn.
struct ReducedTurn {
  State fields;         ///< as the recursion takes them
  StepMap map;          ///< of the fields, with all of the above
  FieldMotion carried;  ///< ω² Q r (m/s²)
};
[[nodiscard]] ReducedTurn reduced_turn(const Integrator& integrator, const State& fields,
                                       const FieldMotion& Y, const Eigen::Vector3d& omega,
                                       double h_s);

/// Its derivative, by central differences along changes of its arguments: 1e-9 is left.
struct ReducedTurnChange {
  const State& fields;
  const FieldMotion& Y;
  const Eigen::Vector3d& omega;
};
[[nodiscard]] ReducedTurn reduced_turn_change(const Integrator& integrator, const State& fields,
                                              const FieldMotion& Y, const Eigen::Vector3d& omega,
                                              double h_s, const ReducedTurnChange& change);

}  // namespace tandem::fem

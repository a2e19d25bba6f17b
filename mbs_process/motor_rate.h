#pragma once

#include "mbs_process/params.h"

namespace tandem::mbs {

/// What a motor's rate is for: to move its coordinate over the step, or to be that at its end.
enum class MotorAim { Mean, End };

/// Rate (rad/s, slider: m/s) that a motor aims at in the step from t_s to t_s + h_s, see
/// MotorParams; `coordinate` is that at t_s. At the end of a step it is the law, or the difference
/// of a position law half a step before and after.
[[nodiscard]] double motor_rate(const MotorParams& motor, MotorAim aim, double coordinate,
                                double t_s, double h_s, double erp);

/// Largest size of the mean rate in steps of h_s over a run, drift left out: of every step of
/// shorter runs, of a hundred thousand of longer ones.
[[nodiscard]] double largest_motor_rate(const MotorParams& motor, double h_s, double duration_s);

}  // namespace tandem::mbs

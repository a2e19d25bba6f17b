#include "mbs_process/motor_rate.h"

#include <algorithm>
#include <cmath>

namespace tandem::mbs {

double motor_rate(const MotorParams& motor, MotorAim aim, double coordinate, double t_s, double h_s,
                  double erp) {
  const Law& law = motor.law;
  const double end_s = t_s + h_s;
  if (motor.kind == MotorParams::Kind::Speed) {
    // The mean over the step: the rate at its end would leave the joint ahead by h/2 of the law.
    return aim == MotorAim::Mean ? law.mean(t_s, end_s) : law(end_s);
  }
  if (aim == MotorAim::End) return (law(t_s + 1.5 * h_s) - law(t_s + 0.5 * h_s)) / h_s;
  const double target = law(t_s) - law(0.0);
  return (law(end_s) - law(t_s) - erp * (coordinate - target)) / h_s;
}

double largest_motor_rate(const MotorParams& motor, double h_s, double duration_s) {
  // Every step of shorter runs, a hundred thousand of longer ones.
  const double steps = std::max(1.0, std::round(duration_s / h_s));
  const auto samples = static_cast<int>(std::min(steps, 1e5));
  double largest = 0.0;
  for (int i = 0; i < samples; ++i) {
    const double t_s = h_s * std::floor(i * steps / samples);
    largest = std::max(largest, std::abs(motor_rate(motor, MotorAim::Mean, 0.0, t_s, h_s, 0.0)));
  }
  return largest;
}

}  // namespace tandem::mbs

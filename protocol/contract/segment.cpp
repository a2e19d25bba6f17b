#include "protocol/contract/segment.h"

namespace tandem {
namespace {

Motion interpolate_motion(const Motion& a, const Motion& b, double s, double h_s,
                          VelocityRule rule) {
  // Cubic Hermite: p(0) = p_a, p(1) = p_b, p'(0) = H v_a, p'(1) = H v_b.
  const double s2 = s * s;
  const double s3 = s2 * s;
  Motion motion;
  motion.p_WP = (2 * s3 - 3 * s2 + 1) * a.p_WP + (s3 - 2 * s2 + s) * h_s * a.v_WP +
                (-2 * s3 + 3 * s2) * b.p_WP + (s3 - s2) * h_s * b.v_WP;
  if (rule == VelocityRule::Linear) {
    motion.v_WP = (1 - s) * a.v_WP + s * b.v_WP;
  } else {
    motion.v_WP = (6 * s2 - 6 * s) / h_s * a.p_WP + (3 * s2 - 4 * s + 1) * a.v_WP +
                  (-6 * s2 + 6 * s) / h_s * b.p_WP + (3 * s2 - 2 * s) * b.v_WP;
  }
  motion.q_WP = a.q_WP.slerp(s, b.q_WP).normalized();
  motion.w_WP = (1 - s) * a.w_WP + s * b.w_WP;
  return motion;
}

}  // namespace

MotionSet interpolate(const Segment<MotionSet>& input, double s, SimTime H, VelocityRule rule) {
  if (s >= 1.0) return input.end;
  MotionSet motions(input.end.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    motions[i] = interpolate_motion(input.begin[i], input.end[i], s, to_seconds(H), rule);
  }
  return motions;
}

WrenchSet interpolate(const Segment<WrenchSet>& input, double s, SimTime /*H*/) {
  if (s >= 1.0) return input.end;
  WrenchSet wrenches(input.end.size());
  for (std::size_t i = 0; i < wrenches.size(); ++i) {
    wrenches[i].f_P_W = (1 - s) * input.begin[i].f_P_W + s * input.end[i].f_P_W;
    wrenches[i].t_P_W = (1 - s) * input.begin[i].t_P_W + s * input.end[i].t_P_W;
  }
  return wrenches;
}

}  // namespace tandem

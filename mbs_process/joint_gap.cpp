#include "mbs_process/joint_gap.h"

#include <algorithm>

namespace tandem::mbs {

JointGaps::JointGaps(const Params& params) {
  std::vector<double> reach_m(params.bodies.size(), 0.0);
  for (const JointParams& params_of : params.joints) {
    const std::size_t body1 = body_index(params, params_of.body1).value();
    const BodyParams& first = params.bodies[body1];
    const bool anchored = params_of.kind != JointKind::Slider && params_of.kind != JointKind::Fixed;
    const Eigen::Vector3d A_W = anchored ? params_of.p_WA : first.p_WB;
    const auto end_at = [&](const std::string& name) -> End {
      const auto body = body_index(params, name);
      if (!body) return {.body = kWorld, .r = A_W};
      const BodyParams& at = params.bodies[*body];
      const Eigen::Vector3d r = A_W - at.p_WB;
      reach_m[*body] = std::max(reach_m[*body], r.norm());
      return {.body = *body, .r = at.q_WB.conjugate() * r};
    };
    Joint joint{.first = end_at(params_of.body1), .second = end_at(params_of.body2)};
    if (params_of.kind == JointKind::Slider) {
      joint.free_axis = first.q_WB.conjugate() * params_of.axis_W.normalized();
    }
    joints_.push_back(joint);
  }
  for (Joint& joint : joints_) {
    for (const End& end : {joint.first, joint.second}) {
      if (end.body != kWorld) joint.arm_m = std::max(joint.arm_m, reach_m[end.body]);
    }
  }
  const double longest_m =
      reach_m.empty() ? 0.0 : *std::max_element(reach_m.begin(), reach_m.end());
  for (Joint& joint : joints_) {
    if (joint.arm_m == 0.0) joint.arm_m = longest_m;
  }
}

Eigen::Vector3d JointGaps::place(const End& end, const State& state) {
  if (end.body == kWorld) return end.r;
  const BodyState& body = state.bodies[end.body];
  return body.p_WB + body.q_WB * end.r;
}

JointGap JointGaps::widest(const State& state) const {
  JointGap widest;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    if (!(joint.arm_m > 0.0)) continue;
    Eigen::Vector3d e = place(joint.first, state) - place(joint.second, state);
    const Eigen::Vector3d axis = state.bodies[joint.first.body].q_WB * joint.free_axis;
    e -= axis.dot(e) * axis;
    const double part = e.norm() / joint.arm_m;
    // Written so that a gap that is no number is told.
    if (part <= widest.part) continue;
    widest = {.gap_m = e.norm(), .part = part, .joint = static_cast<std::int32_t>(j)};
  }
  return widest;
}

}  // namespace tandem::mbs

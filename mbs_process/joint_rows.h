#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "mbs_process/params.h"
#include "mbs_process/state.h"

namespace tandem::mbs {

/// One row over the twists of its joint's two bodies, [v1 | w1 | v2 | w2]; the last six are of no
/// meaning where body2 is the world.
using TwistRow = Eigen::Matrix<double, 1, 12>;

/// The rows by which a joint ties its bodies, J v⁺ + cfm μ = −(erp / h) φ: at most six.
struct JointRows {
  Eigen::Matrix<double, Eigen::Dynamic, 12, Eigen::RowMajor, 6, 12> J;
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1> error;  ///< φ (m, rad)
};

/// The rows that ODE makes of a joint, as functions of its bodies' poses. ODE keeps its own to
/// itself; where it chooses two directions across an axis, others that turn with body1 stand here:
/// rows of equal erp and cfm hold the same whatever their basis.
///
/// With arms a = R r of the anchor, axes s1 (fixed in body1) and s2 (in body2), both across p, q:
///   ball, hinge, universal, hinge2   v1 + w1 × a1 − v2 − w2 × a2,    φ = p1 + a1 − p2 − a2,
///   hinge                            p, q · (w1 − w2),               φ = −p, q · (s1 × s2),
///   universal, n = s1 × s2 / |…|     n · (w1 − w2),                  φ = s1 · s2,
///   hinge2, at t = 0 c0, s0          n · (w1 − w2),                  φ = s1 · s2 s0 − |s1 × s2|
///   c0, slider, fixed                    w1 − w2,                        φ = −2 R1 vec(q1⁻¹ q2
///   q_rel⁻¹), slider, d = p2 − p1              p, q · (v1 − v2 + ½ (w1 + w2) × d),  φ = −p, q · (d
///   + R2 r), fixed, a = R1 r                  v1 + a × w1 − v2,               φ = p1 − p2 − a.
/// [R. Smith, Open Dynamics Engine, 0.16: the joints' constraint rows]
class JointGeometry {
 public:
  /// The joint in the poses of `params`, those at t = 0.
  JointGeometry(const Params& params, const JointParams& joint);

  [[nodiscard]] std::size_t body1() const { return body1_; }
  [[nodiscard]] std::optional<std::size_t> body2() const { return body2_; }
  [[nodiscard]] JointKind kind() const { return kind_; }

  [[nodiscard]] JointRows rows(const BodyState& body1, const BodyState& body2) const;
  /// The row of a stop or motor: the rate about (slider: along) axis 1 or 2. The force along a
  /// slider acts half way between the two centres of mass.
  [[nodiscard]] TwistRow axis_row(int axis, const BodyState& body1, const BodyState& body2) const;
  /// Unit vector of that axis in W.
  [[nodiscard]] Eigen::Vector3d axis_W(int axis, const BodyState& body1,
                                       const BodyState& body2) const;
  /// A slider's coordinate (m).
  [[nodiscard]] double slide(const BodyState& body1, const BodyState& body2) const;
  /// The state of body2; the world rests at the origin.
  [[nodiscard]] BodyState second(const std::vector<BodyState>& bodies) const;

 private:
  void add_anchor(const BodyState& body1, const BodyState& body2, JointRows& rows) const;
  void add_orientation(const BodyState& body1, const BodyState& body2, JointRows& rows) const;
  void add_across(const BodyState& body1, const BodyState& body2, JointRows& rows) const;
  void add_slider(const BodyState& body1, const BodyState& body2, JointRows& rows) const;
  void add_fixed(const BodyState& body1, const BodyState& body2, JointRows& rows) const;

  JointKind kind_;
  std::size_t body1_;
  std::optional<std::size_t> body2_;
  Eigen::Vector3d anchor_B1_, anchor_B2_;
  Eigen::Vector3d axis_B1_, axis_B2_;
  Eigen::Vector3d across1_B1_, across2_B1_;
  Eigen::Vector3d offset_;  ///< p1 − p2 at t = 0, in body2; of a fixed pair in body1
  Eigen::Quaterniond q_rel_;
  double cos0_, sin0_;  ///< of the angle between the axes of a hinge2
};

}  // namespace tandem::mbs

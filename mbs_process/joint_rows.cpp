#include "mbs_process/joint_rows.h"

#include "mbs_process/port_jacobian.h"

namespace tandem::mbs {
namespace {

BodyState at_start(const BodyParams& body) { return {.p_WB = body.p_WB, .q_WB = body.q_WB}; }

/// a unit vector, or zero where the joint has no such axis.
Eigen::Vector3d unit(const Eigen::Vector3d& axis) {
  return axis.norm() > 0.0 ? axis.normalized() : axis;
}

/// n · (w1 − w2)
TwistRow turn_row(const Eigen::Vector3d& n) {
  TwistRow row = TwistRow::Zero();
  row.segment<3>(3) = n.transpose();
  row.segment<3>(9) = -n.transpose();
  return row;
}

}  // namespace

JointGeometry::JointGeometry(const Params& params, const JointParams& joint)
    : kind_(joint.kind),
      body1_(body_index(params, joint.body1).value()),
      body2_(body_index(params, joint.body2)) {
  const BodyState first = at_start(params.bodies[body1_]);
  const BodyState other = body2_ ? at_start(params.bodies[*body2_]) : BodyState{};
  const Eigen::Quaterniond q_BW1 = first.q_WB.conjugate();
  const Eigen::Quaterniond q_BW2 = other.q_WB.conjugate();
  const Eigen::Vector3d s1 = unit(joint.axis_W);
  const Eigen::Vector3d s2 = coordinate_count(kind_) > 1 ? unit(joint.axis2_W) : s1;
  anchor_B1_ = q_BW1 * (joint.p_WA - first.p_WB);
  anchor_B2_ = q_BW2 * (joint.p_WA - other.p_WB);
  axis_B1_ = q_BW1 * s1;
  axis_B2_ = q_BW2 * s2;
  across1_B1_ = axis_B1_.unitOrthogonal();
  across2_B1_ = axis_B1_.cross(across1_B1_);
  offset_ = kind_ == JointKind::Fixed && body2_ ? q_BW1 * (first.p_WB - other.p_WB)
                                                : q_BW2 * (first.p_WB - other.p_WB);
  q_rel_ = q_BW1 * other.q_WB;
  cos0_ = s1.dot(s2);
  sin0_ = s1.cross(s2).norm();
}

JointRows JointGeometry::rows(const BodyState& body1, const BodyState& body2) const {
  JointRows rows;
  const Eigen::Index count = kind_ == JointKind::Ball ? 3 : 6 - coordinate_count(kind_);
  rows.J.setZero(count, 12);
  rows.error.setZero(count);
  switch (kind_) {
    case JointKind::Ball:
      add_anchor(body1, body2, rows);
      break;
    case JointKind::Hinge:
    case JointKind::Universal:
    case JointKind::Hinge2:
      add_anchor(body1, body2, rows);
      add_across(body1, body2, rows);
      break;
    case JointKind::Slider:
      add_orientation(body1, body2, rows);
      add_slider(body1, body2, rows);
      break;
    case JointKind::Fixed:
      add_orientation(body1, body2, rows);
      add_fixed(body1, body2, rows);
      break;
  }
  return rows;
}

void JointGeometry::add_anchor(const BodyState& body1, const BodyState& body2,
                               JointRows& rows) const {
  const Eigen::Vector3d a1 = body1.q_WB * anchor_B1_;
  const Eigen::Vector3d a2 = body2.q_WB * anchor_B2_;
  rows.J.block<3, 3>(0, 0).setIdentity();
  rows.J.block<3, 3>(0, 3) = -cross_matrix(a1);
  rows.J.block<3, 3>(0, 6) = -Eigen::Matrix3d::Identity();
  rows.J.block<3, 3>(0, 9) = cross_matrix(a2);
  rows.error.head<3>() = (body1.p_WB - body2.p_WB) + (a1 - a2);
}

void JointGeometry::add_orientation(const BodyState& body1, const BodyState& body2,
                                    JointRows& rows) const {
  rows.J.block<3, 3>(0, 3).setIdentity();
  rows.J.block<3, 3>(0, 9) = -Eigen::Matrix3d::Identity();
  const Eigen::Quaterniond q_error = body1.q_WB.conjugate() * body2.q_WB * q_rel_.conjugate();
  const double sign = q_error.w() < 0.0 ? -1.0 : 1.0;
  rows.error.head<3>() = -2.0 * sign * (body1.q_WB * Eigen::Vector3d(q_error.vec()));
}

void JointGeometry::add_across(const BodyState& body1, const BodyState& body2,
                               JointRows& rows) const {
  const Eigen::Vector3d s1 = body1.q_WB * axis_B1_;
  const Eigen::Vector3d s2 = body2.q_WB * axis_B2_;
  const Eigen::Vector3d n = s1.cross(s2);
  if (kind_ == JointKind::Hinge) {
    Eigen::Index row = 3;
    for (const Eigen::Vector3d& across_B1 : {across1_B1_, across2_B1_}) {
      const Eigen::Vector3d across = body1.q_WB * across_B1;
      rows.J.row(row) = turn_row(across);
      rows.error[row++] = -across.dot(n);
    }
    return;
  }
  rows.J.row(3) = turn_row(n.normalized());
  rows.error[3] =
      kind_ == JointKind::Universal ? s1.dot(s2) : s1.dot(s2) * sin0_ - n.norm() * cos0_;
}

void JointGeometry::add_slider(const BodyState& body1, const BodyState& body2,
                               JointRows& rows) const {
  const Eigen::Vector3d d = body2.p_WB - body1.p_WB;
  const Eigen::Vector3d gap = d + body2.q_WB * offset_;
  Eigen::Index row = 3;
  for (const Eigen::Vector3d& across_B1 : {across1_B1_, across2_B1_}) {
    const Eigen::Vector3d across = body1.q_WB * across_B1;
    rows.J.row(row).segment<3>(0) = across.transpose();
    rows.J.row(row).segment<3>(6) = -across.transpose();
    if (body2_) {
      const Eigen::Vector3d arm = 0.5 * d.cross(across);
      rows.J.row(row).segment<3>(3) = arm.transpose();
      rows.J.row(row).segment<3>(9) = arm.transpose();
    }
    rows.error[row++] = -across.dot(gap);
  }
}

void JointGeometry::add_fixed(const BodyState& body1, const BodyState& body2,
                              JointRows& rows) const {
  rows.J.block<3, 3>(3, 0).setIdentity();
  rows.J.block<3, 3>(3, 6) = -Eigen::Matrix3d::Identity();
  if (!body2_) {
    rows.error.tail<3>() = body1.p_WB - offset_;
    return;
  }
  const Eigen::Vector3d a = body1.q_WB * offset_;
  rows.J.block<3, 3>(3, 3) = cross_matrix(a);
  rows.error.tail<3>() = body1.p_WB - body2.p_WB - a;
}

Eigen::Vector3d JointGeometry::axis_W(int axis, const BodyState& body1,
                                      const BodyState& body2) const {
  return axis == 1 ? body1.q_WB * axis_B1_ : body2.q_WB * axis_B2_;
}

TwistRow JointGeometry::axis_row(int axis, const BodyState& body1, const BodyState& body2) const {
  const Eigen::Vector3d s = axis_W(axis, body1, body2);
  if (kind_ != JointKind::Slider) return turn_row(s);
  TwistRow row = TwistRow::Zero();
  row.segment<3>(0) = s.transpose();
  row.segment<3>(6) = -s.transpose();
  if (!body2_) return row;
  const Eigen::Vector3d arm = 0.5 * (body2.p_WB - body1.p_WB).cross(s);
  row.segment<3>(3) = arm.transpose();
  row.segment<3>(9) = arm.transpose();
  return row;
}

double JointGeometry::slide(const BodyState& body1, const BodyState& body2) const {
  return (body1.q_WB * axis_B1_).dot(body1.p_WB - body2.q_WB * offset_ - body2.p_WB);
}

BodyState JointGeometry::second(const std::vector<BodyState>& bodies) const {
  return body2_ ? bodies[*body2_] : BodyState{};
}

}  // namespace tandem::mbs

#include "mbs_process/ode_joint.h"

#include <stdexcept>

namespace tandem::mbs {

dJointID create_joint(dWorldID world, const JointParams& params, dBodyID body1, dBodyID body2) {
  const Eigen::Vector3d& p = params.p_WA;
  const Eigen::Vector3d a = params.axis_W.normalized();
  const Eigen::Vector3d b = params.axis2_W.normalized();
  dJointID joint = nullptr;
  switch (params.kind) {
    case JointKind::Ball:
      joint = dJointCreateBall(world, nullptr);
      dJointAttach(joint, body1, body2);
      dJointSetBallAnchor(joint, p.x(), p.y(), p.z());
      break;
    case JointKind::Hinge:
      joint = dJointCreateHinge(world, nullptr);
      dJointAttach(joint, body1, body2);
      dJointSetHingeAnchor(joint, p.x(), p.y(), p.z());
      dJointSetHingeAxis(joint, a.x(), a.y(), a.z());
      break;
    case JointKind::Slider:
      joint = dJointCreateSlider(world, nullptr);
      dJointAttach(joint, body1, body2);
      dJointSetSliderAxis(joint, a.x(), a.y(), a.z());
      break;
    case JointKind::Universal:
      joint = dJointCreateUniversal(world, nullptr);
      dJointAttach(joint, body1, body2);
      dJointSetUniversalAnchor(joint, p.x(), p.y(), p.z());
      dJointSetUniversalAxis1(joint, a.x(), a.y(), a.z());
      dJointSetUniversalAxis2(joint, b.x(), b.y(), b.z());
      break;
    case JointKind::Fixed:
      joint = dJointCreateFixed(world, nullptr);
      dJointAttach(joint, body1, body2);
      dJointSetFixed(joint);
      break;
    case JointKind::Hinge2: {
      joint = dJointCreateHinge2(world, nullptr);
      dJointAttach(joint, body1, body2);
      dJointSetHinge2Anchor(joint, p.x(), p.y(), p.z());
      const dVector3 axis1 = {a.x(), a.y(), a.z(), 0};
      const dVector3 axis2 = {b.x(), b.y(), b.z(), 0};
      dJointSetHinge2Axes(joint, axis1, axis2);
      break;
    }
  }
  return joint;
}

dJointID create_row(dWorldID world, const JointParams& params, int axis, dBodyID body1,
                    dBodyID body2) {
  const Eigen::Vector3d a = (axis == 1 ? params.axis_W : params.axis2_W).normalized();
  // Axis 1 stays fixed in body1, axis 2 in body2, or in W (0) where that is the world.
  const int fixed_in = axis == 1 ? 1 : (body2 != nullptr ? 2 : 0);
  const bool slides = params.kind == JointKind::Slider;
  dJointID row = slides ? dJointCreateLMotor(world, nullptr) : dJointCreateAMotor(world, nullptr);
  dJointAttach(row, body1, body2);
  if (slides) {
    dJointSetLMotorNumAxes(row, 1);
    dJointSetLMotorAxis(row, 0, fixed_in, a.x(), a.y(), a.z());
  } else {
    dJointSetAMotorNumAxes(row, 1);
    dJointSetAMotorAxis(row, 0, fixed_in, a.x(), a.y(), a.z());
  }
  return row;
}

void set_parameter(dJointID joint, int parameter, double value) {
  switch (dJointGetType(joint)) {
    case dJointTypeSlider:
      dJointSetSliderParam(joint, parameter, value);
      break;
    case dJointTypeAMotor:
      dJointSetAMotorParam(joint, parameter, value);
      break;
    case dJointTypeLMotor:
      dJointSetLMotorParam(joint, parameter, value);
      break;
    default:
      throw std::logic_error("joint type has neither stop nor motor");
  }
}

// Balls and fixed joints, the suspension of a hinge2, and stops take over the world's erp and cfm
// when they are made; all other rows ask the world in every step.
void set_softness(dJointID joint, double erp, double cfm) {
  switch (dJointGetType(joint)) {
    case dJointTypeBall:
      dJointSetBallParam(joint, dParamERP, erp);
      dJointSetBallParam(joint, dParamCFM, cfm);
      break;
    case dJointTypeFixed:
      dJointSetFixedParam(joint, dParamERP, erp);
      dJointSetFixedParam(joint, dParamCFM, cfm);
      break;
    case dJointTypeHinge2:
      dJointSetHinge2Param(joint, dParamSuspensionERP, erp);
      dJointSetHinge2Param(joint, dParamSuspensionCFM, cfm);
      break;
    case dJointTypeSlider:
    case dJointTypeAMotor:
      set_parameter(joint, dParamStopERP, erp);
      set_parameter(joint, dParamStopCFM, cfm);
      break;
    default:
      break;
  }
}

std::array<double, 2> coordinates_of(dJointID joint) {
  switch (dJointGetType(joint)) {
    case dJointTypeHinge:
      return {dJointGetHingeAngle(joint), 0.0};
    case dJointTypeSlider:
      return {dJointGetSliderPosition(joint), 0.0};
    case dJointTypeUniversal:
      return {dJointGetUniversalAngle1(joint), dJointGetUniversalAngle2(joint)};
    case dJointTypeHinge2:
      // ODE counts this one angle, alone of all, as body2 relative to body1.
      return {dJointGetHinge2Angle1(joint), -dJointGetHinge2Angle2(joint)};
    default:
      return {0.0, 0.0};
  }
}

std::array<double, 2> rates_of(dJointID joint) {
  switch (dJointGetType(joint)) {
    case dJointTypeHinge:
      return {dJointGetHingeAngleRate(joint), 0.0};
    case dJointTypeSlider:
      return {dJointGetSliderPositionRate(joint), 0.0};
    case dJointTypeUniversal:
      return {dJointGetUniversalAngle1Rate(joint), dJointGetUniversalAngle2Rate(joint)};
    case dJointTypeHinge2:
      return {dJointGetHinge2Angle1Rate(joint), dJointGetHinge2Angle2Rate(joint)};
    default:
      return {0.0, 0.0};
  }
}

}  // namespace tandem::mbs

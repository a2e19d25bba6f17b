#include "mbs_process/ode_world.h"

#include <ode/ode.h>

#include <cstdarg>
#include <cstdio>
#include <mutex>

#include "protocol/contract/error.h"

namespace tandem::mbs {
namespace {

/// What ODE's last message on this thread was; empty = none since the last step began.
thread_local std::string last_message;  // NOLINT: ODE's handlers carry no context of ours

std::string format_message(const char* text, va_list arguments) {
  std::array<char, 512> buffer{};
  std::vsnprintf(buffer.data(), buffer.size(), text, arguments);
  return buffer.data();
}

// ODE ends the process when an error or debug handler returns, so they throw. Debian builds ODE
// with unwind tables, and the world that was left half way is discarded by whoever catches.
extern "C" void throw_fault(int number, const char* text, va_list arguments) {
  throw OdeFault("ODE error " + std::to_string(number) + ": " + format_message(text, arguments));
}

extern "C" void keep_message(int /*number*/, const char* text, va_list arguments) {
  last_message = format_message(text, arguments);
}

/// Keeps ODE initialised while any world lives; its own counters are not safe against threads.
class OdeLibrary {
 public:
  OdeLibrary() {
    const std::lock_guard lock(mutex());
    if (users()++ > 0) return;
    if (dInitODE2(0) == 0) {
      --users();
      throw Error(ErrorKind::Usage, "mbs: ODE cannot be initialised.");
    }
    dSetErrorHandler(throw_fault);
    dSetDebugHandler(throw_fault);
    dSetMessageHandler(keep_message);
  }
  ~OdeLibrary() {
    const std::lock_guard lock(mutex());
    if (--users() > 0) return;
    dSetErrorHandler(nullptr);
    dSetDebugHandler(nullptr);
    dSetMessageHandler(nullptr);
    dCloseODE();
  }
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  static int& users() {
    static int count = 0;
    return count;
  }
};

struct WorldDeleter {
  void operator()(dWorldID world) const { dWorldDestroy(world); }
};
using WorldPtr = std::unique_ptr<dxWorld, WorldDeleter>;

struct ThreadingDeleter {
  void operator()(dThreadingImplementationID threading) const {
    dThreadingFreeImplementation(threading);
  }
};
using ThreadingPtr = std::unique_ptr<dxThreadingImplementation, ThreadingDeleter>;

Eigen::Vector3d vector_of(const dReal* v) { return {v[0], v[1], v[2]}; }

/// ODE and the wire say wxyz, Eigen keeps xyzw.
void set_orientation(dBodyID body, const Eigen::Quaterniond& q) {
  const dQuaternion wxyz = {q.w(), q.x(), q.y(), q.z()};
  dBodySetQuaternion(body, wxyz);
}

void set_motion(dBodyID body, const BodyState& state) {
  dBodySetPosition(body, state.p_WB.x(), state.p_WB.y(), state.p_WB.z());
  set_orientation(body, state.q_WB);
  dBodySetLinearVel(body, state.v_WB.x(), state.v_WB.y(), state.v_WB.z());
  dBodySetAngularVel(body, state.w_WB.x(), state.w_WB.y(), state.w_WB.z());
}

dBodyID create_body(dWorldID world, const BodyParams& params, bool implicit_gyroscopic_torque) {
  dBodyID body = dBodyCreate(world);
  dMass mass;
  const auto& I = params.inertia_kg_m2;
  dMassSetParameters(&mass, params.mass_kg, 0, 0, 0, I[0], I[1], I[2], I[3], I[4], I[5]);
  dBodySetMass(body, &mass);
  dBodySetGyroscopicMode(body, implicit_gyroscopic_torque ? 1 : 0);
  dBodySetFiniteRotationMode(body, 1);
  dBodySetFiniteRotationAxis(body, 0, 0, 0);
  set_motion(body, {params.p_WB, params.q_WB, params.v_WB, params.w_WB});
  return body;
}

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

/// Sets a parameter of the limit-and-motor of axis 1 or 2.
void set_parameter(dJointID joint, int axis, int parameter, double value) {
  const int numbered = axis == 1 ? parameter : parameter + dParamGroup2;
  switch (dJointGetType(joint)) {
    case dJointTypeHinge:
      dJointSetHingeParam(joint, parameter, value);
      break;
    case dJointTypeSlider:
      dJointSetSliderParam(joint, parameter, value);
      break;
    case dJointTypeUniversal:
      dJointSetUniversalParam(joint, numbered, value);
      break;
    case dJointTypeHinge2:
      dJointSetHinge2Param(joint, numbered, value);
      break;
    default:
      throw std::logic_error("joint type has neither limits nor motor");
  }
}

/// Balls and fixed joints, and the suspension of a hinge2, take over the world's erp when they are
/// made; the others ask the world in every step.
void set_erp(dJointID joint, double erp) {
  switch (dJointGetType(joint)) {
    case dJointTypeBall:
      dJointSetBallParam(joint, dParamERP, erp);
      break;
    case dJointTypeFixed:
      dJointSetFixedParam(joint, dParamERP, erp);
      break;
    case dJointTypeHinge2:
      dJointSetHinge2Param(joint, dParamSuspensionERP, erp);
      break;
    default:
      break;
  }
}

void set_limits_and_motor(dJointID joint, const JointParams& params) {
  for (const LimitParams& limit : params.limits) {
    // ODE refuses a stop that would reverse the range at the moment of the call, so the upper one
    // is set before the narrow one can cross it; ±∞ leaves that end free.
    set_parameter(joint, limit.axis, dParamHiStop, std::min(limit.upper, dInfinity));
    set_parameter(joint, limit.axis, dParamLoStop, std::max(limit.lower, -dInfinity));
  }
  if (params.motor) {
    set_parameter(joint, params.motor->axis, dParamFMax,
                  std::min(params.motor->max_effort, dInfinity));
  }
}

}  // namespace

struct OdeWorld::Impl {
  OdeLibrary library;      // first, so that it outlives the world
  ThreadingPtr threading;  // likewise
  WorldPtr world;
  std::vector<dBodyID> bodies;
  std::vector<dJointID> joints;
  std::vector<int> motor_axes;                   // 0 = no motor
  std::vector<dJointFeedback> feedbacks;         // ODE writes into these
  std::vector<std::array<int, 2>> joint_bodies;  // −1 = world
  bool broken = false;                           // ODE was left in the middle of a step
};

// ODE asserts that its queues are empty when a world is destroyed, which they are not after a
// fault: such a world is kept until the process ends. Faults end runs, so there are never many.
void OdeWorld::Retire::operator()(Impl* impl) const {
  if (!impl->broken) {
    delete impl;
    return;
  }
  static std::mutex mutex;
  static auto* const kept = new std::vector<Impl*>;  // never destroyed, always reachable
  const std::lock_guard lock(mutex);
  kept->push_back(impl);
}

OdeWorld::OdeWorld(const Params& params)
    : impl_(new Impl), gravity_m_per_s2_(params.gravity_m_per_s2), erp_(params.erp) {
  Impl& impl = *impl_;
  impl.world.reset(dWorldCreate());
  dWorldID world = impl.world.get();
  // Worlds share ODE's default job queue, which has no locks; one queue each makes worlds of
  // different threads independent. It runs the jobs on the calling thread, in order.
  impl.threading.reset(dThreadingAllocateSelfThreadedImplementation());
  dWorldSetStepThreadingImplementation(
      world, dThreadingImplementationGetFunctions(impl.threading.get()), impl.threading.get());
  dWorldSetERP(world, params.erp);  // what limits take over when their joints are made
  dWorldSetCFM(world, params.cfm);
  dWorldSetAutoDisableFlag(world, 0);
  dWorldSetStepIslandsProcessingMaxThreadCount(world, 1);
  const bool implicit_gyroscopic_torque = params.integrator == IntegratorKind::Euler;
  for (const BodyParams& body : params.bodies) {
    impl.bodies.push_back(create_body(world, body, implicit_gyroscopic_torque));
  }

  impl.feedbacks.resize(params.joints.size());
  for (std::size_t j = 0; j < params.joints.size(); ++j) {
    const JointParams& joint = params.joints[j];
    const auto index1 = body_index(params, joint.body1);
    const auto index2 = body_index(params, joint.body2);
    dBodyID body2 = index2 ? impl.bodies[*index2] : nullptr;
    dJointID id = create_joint(world, joint, impl.bodies[index1.value()], body2);
    set_limits_and_motor(id, joint);
    dJointSetFeedback(id, &impl.feedbacks[j]);
    impl.joints.push_back(id);
    impl.motor_axes.push_back(joint.motor ? joint.motor->axis : 0);
    impl.joint_bodies.push_back(
        {static_cast<int>(*index1), index2 ? static_cast<int>(*index2) : -1});
  }
}

OdeWorld::~OdeWorld() = default;
OdeWorld::OdeWorld(OdeWorld&&) noexcept = default;
OdeWorld& OdeWorld::operator=(OdeWorld&&) noexcept = default;

void OdeWorld::load(const std::vector<BodyState>& bodies) {
  for (std::size_t i = 0; i < bodies.size(); ++i) set_motion(impl_->bodies[i], bodies[i]);
}

void OdeWorld::set_motor_speed(std::size_t joint, double speed) {
  set_parameter(impl_->joints[joint], impl_->motor_axes[joint], dParamVel, speed);
}

void OdeWorld::step(double h_s, const std::vector<BodyWrench>& applied, double share, double erp) {
  const Eigen::Vector3d g = share * gravity_m_per_s2_;
  dWorldSetGravity(impl_->world.get(), g.x(), g.y(), g.z());
  dWorldSetERP(impl_->world.get(), erp);
  for (dJointID joint : impl_->joints) set_erp(joint, erp);
  for (std::size_t i = 0; i < applied.size(); ++i) {
    const Eigen::Vector3d f = share * applied[i].f_B_W;
    const Eigen::Vector3d t = share * applied[i].t_B_W;
    dBodySetForce(impl_->bodies[i], f.x(), f.y(), f.z());
    dBodySetTorque(impl_->bodies[i], t.x(), t.y(), t.z());
  }
  last_message.clear();
  impl_->broken = true;  // until the step returns
  const int stepped = dWorldStep(impl_->world.get(), h_s);
  impl_->broken = false;
  if (stepped == 0) throw OdeFault("ODE ran out of memory");
  if (!last_message.empty()) throw OdeFault("ODE: " + last_message);
}

void OdeWorld::read(std::vector<BodyState>& bodies) const {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    dBodyID body = impl_->bodies[i];
    const dReal* q = dBodyGetQuaternion(body);
    bodies[i].p_WB = vector_of(dBodyGetPosition(body));
    bodies[i].q_WB = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    bodies[i].v_WB = vector_of(dBodyGetLinearVel(body));
    bodies[i].w_WB = vector_of(dBodyGetAngularVel(body));
  }
}

void OdeWorld::add_reactions(std::vector<BodyWrench>& motors,
                             std::vector<BodyWrench>& joints) const {
  for (std::size_t j = 0; j < impl_->joints.size(); ++j) {
    const dJointFeedback& feedback = impl_->feedbacks[j];
    const auto [body1, body2] = impl_->joint_bodies[j];
    std::vector<BodyWrench>& on_bodies = impl_->motor_axes[j] != 0 ? motors : joints;
    BodyWrench& first = on_bodies[static_cast<std::size_t>(body1)];
    first.f_B_W += vector_of(feedback.f1);
    first.t_B_W += vector_of(feedback.t1);
    if (body2 < 0) continue;
    BodyWrench& second = on_bodies[static_cast<std::size_t>(body2)];
    second.f_B_W += vector_of(feedback.f2);
    second.t_B_W += vector_of(feedback.t2);
  }
}

std::array<double, 2> OdeWorld::coordinates(std::size_t joint) const {
  dJointID id = impl_->joints[joint];
  switch (dJointGetType(id)) {
    case dJointTypeHinge:
      return {dJointGetHingeAngle(id), 0.0};
    case dJointTypeSlider:
      return {dJointGetSliderPosition(id), 0.0};
    case dJointTypeUniversal:
      return {dJointGetUniversalAngle1(id), dJointGetUniversalAngle2(id)};
    case dJointTypeHinge2:
      // ODE counts this one angle, alone of all, as body2 relative to body1.
      return {dJointGetHinge2Angle1(id), -dJointGetHinge2Angle2(id)};
    default:
      return {0.0, 0.0};
  }
}

}  // namespace tandem::mbs

#include "mbs_process/ode_world.h"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <deque>
#include <mutex>

#include "mbs_process/ode_joint.h"
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
  dBodySetGravityMode(body, params.massless ? 0 : 1);
  dBodySetGyroscopicMode(body, implicit_gyroscopic_torque ? 1 : 0);
  dBodySetFiniteRotationMode(body, 1);
  dBodySetFiniteRotationAxis(body, 0, 0, 0);
  set_motion(body, {params.p_WB, params.q_WB, params.v_WB, params.w_WB});
  return body;
}

/// ±∞ leaves that end free.
void set_stop(dJointID joint, const LimitParams& limit) {
  set_parameter(joint, dParamHiStop, std::min(limit.upper, dInfinity));
  set_parameter(joint, dParamLoStop, std::max(limit.lower, -dInfinity));
}

/// A joint of ODE; it writes its reactions into this very place.
struct Element {
  dJointID id = nullptr;
  std::size_t joint = 0;             ///< of Params::joints
  std::array<int, 2> bodies{0, -1};  ///< −1 = world
  int axis = 1;                      ///< of a stop or motor
  bool stops = false;                ///< a stop, or a slider with stops
  double max_effort = 0.0;           ///< of a motor
  double mobility = 0.0;             ///< of a motor beside a stop: its bodies' rate per impulse
  double cfm = 0.0, speed = 0.0, most = 0.0;  ///< in the next step; the last two of a motor
  dJointFeedback reaction{};
};
using Elements = std::deque<Element>;

/// Rate that a unit impulse along (angular: about an axis of) a coordinate gives a body, on
/// average.
double mobility_of(const BodyParams& body, JointKind kind) {
  return kind == JointKind::Slider ? 1.0 / body.mass_kg : 3.0 / body.inertia_B().trace();
}

void add_reactions_of(const Elements& elements, std::vector<BodyWrench>& on_bodies) {
  for (const Element& element : elements) {
    const dJointFeedback& feedback = element.reaction;
    const auto [body1, body2] = element.bodies;
    BodyWrench& first = on_bodies[static_cast<std::size_t>(body1)];
    first.f_B_W += vector_of(feedback.f1);
    first.t_B_W += vector_of(feedback.t1);
    if (body2 < 0) continue;
    BodyWrench& second = on_bodies[static_cast<std::size_t>(body2)];
    second.f_B_W += vector_of(feedback.f2);
    second.t_B_W += vector_of(feedback.t2);
  }
}

}  // namespace

struct OdeWorld::Impl {
  OdeLibrary library;      // first, so that it outlives the world
  ThreadingPtr threading;  // likewise
  WorldPtr world;
  std::vector<dBodyID> bodies;
  // Motors and the stops of angles are rows of their own beside their joint. Both may then act on
  // one coordinate (ODE's joint would push against its stop with all of the motor's effort), a stop
  // is told the angle through full turns, and a motor's work is known apart.
  Elements joints, stops, motors;
  bool broken = false;  // ODE was left in the middle of a step

  static Element& add(Elements& to, Element element) {
    to.push_back(element);
    dJointSetFeedback(element.id, &to.back().reaction);
    return to.back();
  }
  void add_joint(const Params& params, std::size_t j);
};

void OdeWorld::Impl::add_joint(const Params& params, std::size_t j) {
  const JointParams& joint = params.joints[j];
  const std::size_t index1 = body_index(params, joint.body1).value();
  const auto index2 = body_index(params, joint.body2);
  dBodyID body1 = bodies[index1];
  dBodyID body2 = index2 ? bodies[*index2] : nullptr;
  Element element{.joint = j,
                  .bodies = {static_cast<int>(index1), index2 ? static_cast<int>(*index2) : -1}};
  element.id = create_joint(world.get(), joint, body1, body2);
  add(joints, element);
  for (const LimitParams& limit : joint.limits) {
    if (joint.kind == JointKind::Slider) {
      set_stop(joints.back().id, limit);  // its coordinate has no turns
      joints.back().stops = true;
      continue;
    }
    element.id = create_row(world.get(), joint, limit.axis, body1, body2);
    set_stop(element.id, limit);
    Element& stop = add(stops, element);
    stop.axis = limit.axis;
    stop.stops = true;
  }
  if (!joint.motor) return;
  element.id = create_row(world.get(), joint, joint.motor->axis, body1, body2);
  element.max_effort = joint.motor->max_effort;
  element.axis = joint.motor->axis;
  for (const LimitParams& limit : joint.limits) {
    if (limit.axis != joint.motor->axis) continue;
    element.mobility = mobility_of(params.bodies[index1], joint.kind);
    if (!index2) continue;
    element.mobility = std::max(element.mobility, mobility_of(params.bodies[*index2], joint.kind));
  }
  add(motors, element);
}

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
    : impl_(new Impl), gravity_m_per_s2_(params.gravity_m_per_s2) {
  Impl& impl = *impl_;
  impl.world.reset(dWorldCreate());
  dWorldID world = impl.world.get();
  // Worlds share ODE's default job queue, which has no locks; one queue each makes worlds of
  // different threads independent. It runs the jobs on the calling thread, in order.
  impl.threading.reset(dThreadingAllocateSelfThreadedImplementation());
  dWorldSetStepThreadingImplementation(
      world, dThreadingImplementationGetFunctions(impl.threading.get()), impl.threading.get());
  dWorldSetAutoDisableFlag(world, 0);
  dWorldSetStepIslandsProcessingMaxThreadCount(world, 1);
  const bool implicit_gyroscopic_torque = params.integrator == IntegratorKind::Euler;
  for (const BodyParams& body : params.bodies) {
    impl.bodies.push_back(create_body(world, body, implicit_gyroscopic_torque));
  }

  for (std::size_t j = 0; j < params.joints.size(); ++j) impl.add_joint(params, j);
}

OdeWorld::~OdeWorld() = default;
OdeWorld::OdeWorld(OdeWorld&&) noexcept = default;
OdeWorld& OdeWorld::operator=(OdeWorld&&) noexcept = default;

void OdeWorld::load(const std::vector<BodyState>& bodies,
                    const std::vector<std::array<double, 2>>& joint_coordinates) {
  for (std::size_t i = 0; i < bodies.size(); ++i) set_motion(impl_->bodies[i], bodies[i]);
  for (const Element& stop : impl_->stops) {
    const auto axis = static_cast<std::size_t>(stop.axis - 1);
    dJointSetAMotorAngle(stop.id, 0, joint_coordinates[stop.joint][axis]);
  }
}

void OdeWorld::set_motor_speed(std::size_t joint, double speed) {
  for (Element& motor : impl_->motors) {
    if (motor.joint != joint) continue;
    motor.speed = speed;
    set_parameter(motor.id, dParamVel, speed);
  }
}

void OdeWorld::obey(const StepRule& rule, double h_s) {
  const Eigen::Vector3d g = rule.share * gravity_m_per_s2_;
  dWorldSetGravity(impl_->world.get(), g.x(), g.y(), g.z());
  dWorldSetERP(impl_->world.get(), rule.erp);
  dWorldSetCFM(impl_->world.get(), rule.cfm);
  for (Elements* elements : {&impl_->joints, &impl_->stops}) {
    for (Element& element : *elements) {
      element.cfm = rule.cfm;
      set_softness(element.id, rule.erp, rule.cfm);
    }
  }
  for (Element& motor : impl_->motors) {
    // A motor and a stop on one coordinate are two equal rows, which need some softness to be told
    // apart: the motor slips by 1e-8 of what its effort would do in a step.
    const double least = 1e-8 * h_s * motor.mobility;
    motor.cfm = std::max(rule.motor_cfm, least);
    motor.most = std::min(rule.share * motor.max_effort, dInfinity);
    set_parameter(motor.id, dParamCFM, motor.cfm);
    set_parameter(motor.id, dParamFMax, motor.most);
  }
}

void OdeWorld::step(double h_s, const std::vector<BodyWrench>& applied, const StepRule& rule) {
  obey(rule, h_s);
  for (std::size_t i = 0; i < applied.size(); ++i) {
    const Eigen::Vector3d f = rule.share * applied[i].f_B_W;
    const Eigen::Vector3d t = rule.share * applied[i].t_B_W;
    dBodySetForce(impl_->bodies[i], f.x(), f.y(), f.z());
    dBodySetTorque(impl_->bodies[i], t.x(), t.y(), t.z());
  }
  // ODE leaves out stops that do not act, and their reactions as they were.
  for (Element& stop : impl_->stops) stop.reaction = {};
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
  add_reactions_of(impl_->motors, motors);
  add_reactions_of(impl_->joints, joints);
  add_reactions_of(impl_->stops, joints);
}

std::vector<EffortRow> OdeWorld::effort_rows() const {
  std::vector<EffortRow> rows;
  const auto add = [&](const Element& element, bool slides) {
    const dJointFeedback& reaction = element.reaction;
    rows.push_back({.joint = element.joint,
                    .axis = element.axis,
                    .motor = !element.stops,
                    .cfm = element.cfm,
                    .speed = element.speed,
                    .most = element.most,
                    .on_body1 = vector_of(slides ? reaction.f1 : reaction.t1)});
  };
  for (const Element& joint : impl_->joints) {
    if (joint.stops) add(joint, true);
  }
  for (const Element& stop : impl_->stops) add(stop, false);
  for (const Element& motor : impl_->motors) {
    add(motor, dJointGetType(motor.id) == dJointTypeLMotor);
  }
  return rows;
}

std::array<double, 2> OdeWorld::coordinates(std::size_t joint) const {
  return coordinates_of(impl_->joints[joint].id);
}

std::array<double, 2> OdeWorld::rates(std::size_t joint) const {
  return rates_of(impl_->joints[joint].id);
}

}  // namespace tandem::mbs

#include "mbs_process/mbs_keys.h"

#include <utility>

#include "protocol/scenario/law.h"

namespace tandem::mbs {
namespace {

using scenario::Key;
using scenario::Section;

/// Pose and velocities at t = 0; `origin`: what the position is of.
void add_motion_keys(const std::string& origin, std::vector<Key>& keys) {
  keys.push_back(scenario::reals("position_m", "m")
                     .count(3)
                     .by_default("[0, 0, 0]")
                     .doc_is(origin + " at t = 0 in world axes."));
  keys.push_back(scenario::reals("orientation_wxyz", "")
                     .count(4)
                     .of_unit_length()
                     .by_default("[1, 0, 0, 0]")
                     .doc_is("Rotation of its axes at t = 0 as a quaternion [w, x, y, z]."));
  keys.push_back(scenario::reals("velocity_m_per_s", "m/s")
                     .count(3)
                     .by_default("[0, 0, 0]")
                     .doc_is("Velocity of that point at t = 0."));
  keys.push_back(scenario::reals("angular_velocity_rad_per_s", "rad/s")
                     .count(3)
                     .by_default("[0, 0, 0]")
                     .doc_is("Angular velocity at t = 0 in world axes."));
}

Key bodies_key() {
  Section body;
  body.title = "Body";
  body.doc = "A rigid body. Its frame B has its origin at the centre of mass.";
  body.keys = {
      scenario::name("name").must().doc_is("Name that joints, springs, forces and ports refer to."),
      scenario::real("mass_kg", "kg").must().above(0).doc_is("Mass."),
      scenario::reals("inertia_kg_m2", "kg m²")
          .must()
          .count(3, 6)
          .doc_is("Inertia tensor about the centre of mass in the body's axes: [Ixx, Iyy, Izz] or "
                  "[Ixx, Iyy, Izz, Ixy, Ixz, Iyz], where Ixy is the tensor's element −∫ x y dm."),
  };
  add_motion_keys("Centre of mass", body.keys);
  return scenario::sections("bodies", std::move(body))
      .at_least_count(1)
      .doc_is("Rigid bodies. May be left out where there are junctions.");
}

Key junctions_key() {
  Section junction;
  junction.title = "Junction";
  junction.doc =
      "A frame without mass that ports of several flexible bodies share, or that a joint holds: "
      "the wrenches of its ports and the forces of its joints are in balance at every step. With "
      "coupling.scheme interface_jacobian or implicit. While a step is made an inertia stands in "
      "for "
      "its own, and is taken away again.";
  junction.keys = {
      scenario::name("name").must().doc_is("Name that joints, springs, forces and ports refer to, "
                                           "as to a body's."),
      scenario::real("stand_in_mass_kg", "kg")
          .above(0)
          .by_default("1")
          .doc_is("Mass that stands in. With integrators of second order and with coupling.scheme: "
                  "implicit about that of the flexible bodies; else any."),
      scenario::real("stand_in_inertia_kg_m2", "kg m²")
          .above(0)
          .by_default("0.01")
          .doc_is("Inertia that stands in, about all axes."),
  };
  add_motion_keys("Origin, that of one of its ports,", junction.keys);
  return scenario::sections("junctions", std::move(junction))
      .doc_is("Massless frames that join flexible bodies without a rigid one.");
}

Key limits_key() {
  Section limit;
  limit.title = "Limit";
  limit.doc =
      "Range of one coordinate of a joint, counted from the pose at t = 0 and through full turns. "
      "A "
      "limit acts once it has been passed, so the coordinate overshoots by up to its rate times "
      "the micro step, of which each step pushes back the share erp.";
  limit.keys = {
      scenario::integer("axis").between(1, 2).by_default("1").doc_is("Which axis is limited."),
      scenario::real("lower_rad", "rad")
          .doc_is("Least angle, of any number of turns. Left out: none."),
      scenario::real("upper_rad", "rad")
          .doc_is("Greatest angle, of any number of turns. Left out: none."),
      scenario::real("lower_m", "m").doc_is("Least displacement of a slider. Left out: none."),
      scenario::real("upper_m", "m").doc_is("Greatest displacement of a slider. Left out: none."),
  };
  return scenario::sections("limits", std::move(limit))
      .doc_is("Ranges of the joint's coordinates.");
}

Key motor_key() {
  Section motor;
  motor.title = "Motor";
  motor.doc =
      "Drives one coordinate of a hinge, slider, universal or hinge2 joint along a law of time: "
      "its rate (speed; the coordinate follows the integral of the law), or its value (position). "
      "The pose at t = 0 belongs to a position law's value at t = 0. On an axis with limits it "
      "must "
      "yield somewhere, and presses against a stop with that.";
  motor.keys = {
      scenario::choice("kind", {"speed", "position"})
          .must()
          .doc_is("Whether the law prescribes the rate or the value of the coordinate."),
      scenario::law("law", "rad, rad/s; slider: m, m/s").must().doc_is("The prescribed function."),
      scenario::integer("axis").between(1, 2).by_default("1").doc_is("Which axis is driven."),
      scenario::real("max_torque_Nm", "N·m")
          .above(0)
          .doc_is("Torque at which the motor yields. Left out: it never does."),
      scenario::real("max_force_N", "N")
          .above(0)
          .doc_is("Force at which the motor of a slider yields. Left out: it never does."),
  };
  return scenario::section("motor", std::move(motor))
      .doc_is("Prescribed motion of one coordinate.");
}

Key joints_key() {
  Section joint;
  joint.title = "Joint";
  joint.doc =
      "A joint between two bodies or a body and the world. Its coordinates are zero at t = 0 and "
      "count the motion of body1 relative to body2, right-handed about (along) the axis.";
  joint.keys = {
      scenario::name("name").must().doc_is("Name of the joint."),
      scenario::choice("kind", {"ball", "hinge", "slider", "universal", "fixed", "hinge2"})
          .must()
          .doc_is("Kind of joint."),
      scenario::name("body1").must().doc_is("Body that moves."),
      scenario::name("body2").by_default("world").doc_is("Other body, or world."),
      scenario::reals("anchor_m", "m")
          .count(3)
          .only_when("kind", {"ball", "hinge", "universal", "hinge2"})
          .must()
          .doc_is("Common point at t = 0 in world axes."),
      scenario::reals("axis", "")
          .count(3)
          .only_when("kind", {"hinge", "slider", "universal", "hinge2"})
          .must()
          .doc_is("First axis at t = 0 in world axes, of any length."),
      scenario::reals("axis2", "")
          .count(3)
          .only_when("kind", {"universal", "hinge2"})
          .must()
          .doc_is(
              "Second axis at t = 0 in world axes; of a universal joint perpendicular to axis."),
      limits_key(),
      motor_key(),
  };
  return scenario::sections("joints", std::move(joint)).doc_is("Joints.");
}

Key springs_key() {
  Section spring;
  spring.title = "Spring";
  spring.doc = "Spring and damper between two points: f = k (l − l0) + c dl/dt along their line.";
  spring.keys = {
      scenario::name("name").must().doc_is("Name of the spring."),
      scenario::name("body1").must().doc_is("Body at the first end."),
      scenario::name("body2").by_default("world").doc_is("Body at the second end, or world."),
      scenario::reals("point1_m", "m").must().count(3).doc_is("First end at t = 0 in world axes."),
      scenario::reals("point2_m", "m").must().count(3).doc_is("Second end at t = 0 in world axes."),
      scenario::real("stiffness_N_per_m", "N/m").must().at_least(0).doc_is("Stiffness k."),
      scenario::real("damping_N_s_per_m", "N·s/m").at_least(0).by_default("0").doc_is("Damping c."),
      scenario::real("rest_length_m", "m")
          .at_least(0)
          .doc_is("Length l0 without force. Left out: the length at t = 0."),
  };
  return scenario::sections("springs", std::move(spring)).doc_is("Springs between points.");
}

Key joint_springs_key() {
  Section spring;
  spring.title = "Joint spring";
  spring.doc =
      "Spring and damper on the coordinate of a hinge (torsional) or slider (axial): "
      "−k (θ − θ0) − c dθ/dt acts on body1.";
  spring.keys = {
      scenario::name("name").must().doc_is("Name of the spring."),
      scenario::name("joint").must().doc_is("A hinge or slider."),
      scenario::choice("kind", {"torsional", "axial"})
          .by_default("torsional")
          .doc_is("Torsional on a hinge, axial on a slider."),
      scenario::real("stiffness_Nm_per_rad", "N·m/rad")
          .only_when("kind", {"torsional"})
          .at_least(0)
          .by_default("0")
          .doc_is("Torsional stiffness k."),
      scenario::real("damping_Nm_s_per_rad", "N·m·s/rad")
          .only_when("kind", {"torsional"})
          .at_least(0)
          .by_default("0")
          .doc_is("Torsional damping c."),
      scenario::real("rest_rad", "rad")
          .only_when("kind", {"torsional"})
          .by_default("0")
          .doc_is("Angle θ0 without torque, from the pose at t = 0."),
      scenario::real("stiffness_N_per_m", "N/m")
          .only_when("kind", {"axial"})
          .at_least(0)
          .by_default("0")
          .doc_is("Axial stiffness k."),
      scenario::real("damping_N_s_per_m", "N·s/m")
          .only_when("kind", {"axial"})
          .at_least(0)
          .by_default("0")
          .doc_is("Axial damping c."),
      scenario::real("rest_m", "m")
          .only_when("kind", {"axial"})
          .by_default("0")
          .doc_is("Displacement θ0 without force, from the pose at t = 0."),
  };
  return scenario::sections("joint_springs", std::move(spring))
      .doc_is("Springs on joint coordinates.");
}

Key forces_key() {
  Section force;
  force.title = "Force";
  force.doc = "An external force or torque on a body along a direction fixed in the world.";
  force.keys = {
      scenario::name("name").must().doc_is("Name of the force."),
      scenario::name("body").must().doc_is("Body it acts on."),
      scenario::choice("kind", {"force", "torque"}).by_default("force").doc_is("What acts."),
      scenario::reals("point_B_m", "m")
          .count(3)
          .only_when("kind", {"force"})
          .by_default("[0, 0, 0]")
          .doc_is("Point of action in the body's axes from its centre of mass."),
      scenario::reals("direction", "")
          .must()
          .count(3)
          .doc_is("Direction in world axes, of any length; the law gives the magnitude."),
      scenario::law("law", "N, torque: N·m").must().doc_is("Magnitude over time."),
  };
  return scenario::sections("forces", std::move(force)).doc_is("External forces and torques.");
}

}  // namespace

Key mbs_keys() {
  Section mbs;
  mbs.title = "Multibody side";
  mbs.doc = "Rigid bodies, joints and loads, integrated by the Open Dynamics Engine (dWorldStep).";
  mbs.keys = {
      scenario::name("name").doc_is(
          "Name of the world, by which `tandem replay --side` knows it. Each of several has one."),
      scenario::reals("gravity_m_per_s2", "m/s²")
          .count(3)
          .by_default("[0, 0, -9.81]")
          .doc_is("Gravity in world axes."),
      scenario::real("micro_step_s", "s")
          .above(0)
          .doc_is("Step of the multibody integrator, a whole fraction of the macro step. Left out: "
                  "the macro step."),
      scenario::choice("integrator", {"euler", "verlet", "generalised_alpha"})
          .by_default("euler")
          .doc_is(
              "ODE's own semi-implicit Euler step, first order and robust, or velocity Verlet on "
              "two steps of ODE, second order; for vibration together with a second-order "
              "fem.integrator. generalised_alpha: Verlet with port wrenches that damp what is too "
              "fast for the step; for light bodies on stiff flexible ones, with fem.integrator of "
              "the same kind."),
      scenario::real("rho_infinity", "")
          .only_when("integrator", {"generalised_alpha"})
          .between(0, 1)
          .by_default("0.8")
          .doc_is("What a step of generalised_alpha keeps of infinitely fast motion; 1: undamped."),
      scenario::real("newmark_beta", "")
          .only_when("integrator", {"verlet"})
          .between(0, 0.25)
          .by_default("0.25")
          .doc_is(
              "How the port wrench at the end of a verlet step acts on its pose: 0.25 is stable "
              "with any flexible body, 0.0833333333333333 has a vibration's frequency to fourth "
              "order while the step resolves it."),
      scenario::real("erp", "").between(0, 1).by_default("0.2").doc_is(
          "Share of a joint's position error that one step removes."),
      scenario::real("cfm", "").at_least(0).by_default("1e-10").doc_is(
          "Constraint force mixing, m/s per N: a joint or stop gives way by cfm times its force "
          "times "
          "the micro step over erp, a motor falls behind its law by cfm times its effort; must be "
          "positive where joints constrain the same motion twice."),
      bodies_key(),
      junctions_key(),
      joints_key(),
      springs_key(),
      joint_springs_key(),
      forces_key(),
  };
  mbs.check = [](const scenario::Node& node) { (void)read_mechanism(node); };
  return scenario::section("mbs", std::move(mbs))
      .must()
      .or_several()
      .doc_is(
          "The multibody side; or a list of several named worlds, each in a process of its own, "
          "which are coupled through flexible bodies only. A port belongs to the world that has "
          "its body.");
}

}  // namespace tandem::mbs

#include "fem_process/ancf/ancf_keys.h"

#include <utility>

#include "protocol/scenario/law.h"

namespace tandem::fem::ancf {
namespace {

using scenario::Key;
using scenario::Node;
using scenario::Section;

Key vector(const char* name, const char* unit, const char* value, const char* doc) {
  return scenario::reals(name, unit).count(3).by_default(value).doc_is(doc);
}

Key path_key() {
  Section path;
  path.title = "Path";
  path.doc =
      "The centre line at t = 0. Across it lie the lateral axis y and z = x × y, outward on closed "
      "paths.";
  path.keys = {
      scenario::choice("kind", {"line", "loop"})
          .must()
          .doc_is(
              "An open line, or the closed band around two circles (a ring when these are one)."),
      vector("start_m", "m", "[0, 0, 0]", "Where the line begins.").only_when("kind", {"line"}),
      vector("direction", "", "[1, 0, 0]", "Direction of the line, of any length.")
          .only_when("kind", {"line"}),
      scenario::real("length_m", "m")
          .only_when("kind", {"line"})
          .must()
          .above(0)
          .doc_is("Length of the line."),
      scenario::reals("center1_m", "m")
          .only_when("kind", {"loop"})
          .must()
          .count(3)
          .doc_is("Centre of the first circle; the chain begins where it leaves this one."),
      scenario::reals("center2_m", "m")
          .only_when("kind", {"loop"})
          .must()
          .count(3)
          .doc_is("Centre of the second circle."),
      scenario::real("radius1_m", "m")
          .only_when("kind", {"loop"})
          .must()
          .above(0)
          .doc_is("Radius of the centre line around the first circle."),
      scenario::real("radius2_m", "m")
          .only_when("kind", {"loop"})
          .must()
          .above(0)
          .doc_is("Radius of the centre line around the second circle."),
      vector("lateral", "", "[0, 1, 0]",
             "Lateral axis y: along the pins and the axes of the wheels, of any length."),
  };
  return scenario::section("path", std::move(path)).must().doc_is("The centre line at t = 0.");
}

Key chain_key() {
  Section chain;
  chain.title = "Chain";
  chain.doc = "Elements of equal length and how they are joined.";
  chain.keys = {
      scenario::integer("elements").must().at_least(1).doc_is("How many."),
      scenario::choice("joint", {"rigid", "pin", "ball"})
          .by_default("rigid")
          .doc_is("rigid: one beam (C1). pin: turns about the pin's axis and keeps five modes of "
                  "deformation of its own on both sides, eqs. (7)-(9) of [JC11]. ball: shares the "
                  "point alone."),
      vector("pin_axis", "", "[0, 1, 0]",
             "Axis of the pins in the elements' own x, y, z, of any length.")
          .only_when("joint", {"pin"}),
      scenario::real("strain", "")
          .above(-0.5)
          .below(1)
          .by_default("0")
          .doc_is(
              "Axial strain as mounted: the stress-free chain is shorter than the path by 1/(1 + "
              "strain). The sides are free of stress."),
      scenario::choice("stress_free", {"straight", "path"})
          .by_default("straight")
          .doc_is("Stress-free shape of the elements: straight, or bent as the path."),
      scenario::choice("left_support", {"free", "hinged", "clamped"})
          .by_default("free")
          .doc_is("What holds the beginning of an open chain: nothing, its point, or all."),
      scenario::choice("right_support", {"free", "hinged", "clamped"})
          .by_default("free")
          .doc_is("The same at its end."),
  };
  return scenario::section("chain", std::move(chain)).must().doc_is("Elements and joints.");
}

Key section_key() {
  Section section;
  section.title = "Cross-section";
  section.doc = "A rectangle.";
  section.keys = {
      scenario::real("width_m", "m").must().above(0).doc_is("Width w along y."),
      scenario::real("height_m", "m").must().above(0).doc_is("Height h along z."),
  };
  return scenario::section("section", std::move(section)).must().doc_is("Cross-section.");
}

Key material_key() {
  const char* law = "law";
  Section material;
  material.title = "Beam material";
  material.doc =
      "neo_hookean: W = μ/2 (J^(-2/3) tr C − 3) + k/2 (J − 1)². svk: St. Venant-Kirchhoff. "
      "Viscosity: bulk k γ_v, shear μ γ_d.";
  material.keys = {
      scenario::choice(law, {"neo_hookean", "svk"}).must().doc_is("Elastic law."),
      scenario::real("neo_hookean_Pa", "Pa")
          .only_when(law, {"neo_hookean"})
          .must()
          .above(0)
          .doc_is("Neo-Hookean constant; see constant_is."),
      scenario::choice("constant_is", {"mu", "c10"})
          .only_when(law, {"neo_hookean"})
          .by_default("mu")
          .doc_is("Whether the constant is the shear modulus μ, or C10 with μ = 2 C10."),
      scenario::real("bulk_Pa", "Pa")
          .only_when(law, {"neo_hookean"})
          .must()
          .above(0)
          .doc_is("Incompressibility constant k: the bulk modulus."),
      scenario::real("young_Pa", "Pa")
          .only_when(law, {"svk"})
          .must()
          .above(0)
          .doc_is("Young's modulus."),
      scenario::real("poisson", "")
          .only_when(law, {"svk"})
          .must()
          .above(-1)
          .below(0.5)
          .doc_is("Poisson's ratio."),
      scenario::real("density_kg_per_m3", "kg/m³").must().above(0).doc_is("Density."),
      scenario::real("dilatation_s", "s")
          .at_least(0)
          .by_default("0")
          .doc_is("Dissipation factor γ_v of the dilatation."),
      scenario::real("deviation_s", "s")
          .at_least(0)
          .by_default("0")
          .doc_is("Dissipation factor γ_d of the deviation."),
      scenario::choice("viscosity", {"spatial", "green"})
          .by_default("spatial")
          .doc_is("Viscous stress proportional to the rate of deformation in space, or to the rate "
                  "of Green's strain."),
  };
  return scenario::section("material", std::move(material)).must().doc_is("Material.");
}

Key integration_key() {
  Section integration;
  integration.title = "Integration over the elements";
  integration.doc = "Strains and points, and what is done about Poisson locking in bending.";
  integration.keys = {
      scenario::choice("kind", {"full", "volume_on_axis", "axis_d0"})
          .by_default("full")
          .doc_is(
              "full: as written, bends as stiffly as the constrained modulus. volume_on_axis: "
              "the volumetric part on the centre line (too soft). axis_d0: the whole law on the "
              "centre line and Young's modulus for bending."),
      scenario::choice("strain", {"assumed", "compatible"})
          .by_default("assumed")
          .doc_is("assumed: strains at the nodes and halfway along an element, those across linear "
                  "between the nodes: bent elements do not lock. compatible: as written, at Gauss "
                  "points; elements bent by θ on a radius R are as if stiffer by θ⁴ (R/h)²/10 and "
                  "more."),
      scenario::reals("points", "")
          .count(3)
          .doc_is("Gauss points along x, y and z, 1 to 8 each; left out: 4, 2 and 2, or 3 along x "
                  "where strain is assumed, which has no other number."),
  };
  integration.check = [](const Node& node) {
    if (!node.has("points")) return;
    for (double n : node.reals("points")) {
      if (n >= 1.0 && n <= 8.0 && n == static_cast<int>(n)) continue;
      node.fail("points", "must be three whole numbers from 1 to 8, as [4, 2, 2].");
    }
    if (node.text("strain") == "assumed" && node.reals("points").front() != 3.0) {
      node.fail("points",
                "must begin with 3: assumed strains are those of the nodes and halfway between. "
                "Write [3, 2, 2], leave it out, or set strain: compatible.");
    }
  };
  return scenario::section("integration", std::move(integration))
      .by_default("{}")
      .doc_is("Numerical integration.");
}

Key contact_key() {
  Section contact;
  contact.title = "Band contact";
  contact.doc =
      "Pressure k d + c d' per stress-free area of the band, and friction v_s v_t up to μ times "
      "the pressure, at Gauss points of its faces.";
  contact.keys = {
      scenario::real("stiffness_N_per_m3", "N/m³")
          .above(0)
          .by_default("9e7")
          .doc_is("k: pressure per depth."),
      scenario::real("damping_N_s_per_m3", "N s/m³")
          .at_least(0)
          .by_default("2e3")
          .doc_is("c: pressure per rate of depth; never pulls."),
      scenario::real("damping_depth_m", "m")
          .above(0)
          .by_default("1e-5")
          .doc_is("Depth over which damping (of the teeth as well) comes in, so that forces do not "
                  "jump when a point touches: an implicit step may have no solution there."),
      scenario::real("friction", "").at_least(0).by_default("0").doc_is("Coefficient μ."),
      scenario::real("friction_slope_N_s_per_m3", "N s/m³")
          .above(0)
          .by_default("1e6")
          .doc_is("v_s: traction per slip velocity below μ p / v_s."),
      scenario::integer("points_along")
          .between(1, 32)
          .by_default("8")
          .doc_is("Points of a face along an element."),
      scenario::integer("points_across").between(1, 8).by_default("2").doc_is("Points across it."),
  };
  return scenario::section("contact", std::move(contact)).by_default("{}").doc_is("Contact.");
}

Key teeth_key() {
  Section teeth;
  teeth.title = "Teeth";
  teeth.doc =
      "Seats for the pins of a chain, eqs. (10)-(20) of [JC11] in monotone form: a pin off its "
      "seat "
      "by more than the backlash is pushed back along the circle.";
  teeth.keys = {
      scenario::integer("count").must().at_least(3).doc_is("How many."),
      scenario::real("phase_rad", "rad")
          .by_default("0")
          .doc_is("Angle of a seat at the port's frame from its z toward its x axis."),
      scenario::real("pin_radius_m", "m").must().above(0).doc_is("Radius of a pin."),
      scenario::real("backlash", "")
          .at_least(0)
          .by_default("0.1")
          .doc_is("Play to each side over the pin radius."),
      scenario::real("height_m", "m")
          .must()
          .above(0)
          .doc_is("Height above the base circle; over the last pin radius the push fades."),
      scenario::real("stiffness_N_per_m", "N/m").must().above(0).doc_is("Flank stiffness."),
      scenario::real("damping_N_s_per_m", "N s/m")
          .at_least(0)
          .by_default("0")
          .doc_is("Flank damping."),
  };
  return scenario::section("teeth", std::move(teeth)).doc_is("Teeth; left out: a plain wheel.");
}

Key wheels_key() {
  Section wheel;
  wheel.title = "Wheel";
  wheel.doc = "A cylinder about the y axis of a port's frame.";
  wheel.keys = {
      scenario::name("port").must().doc_is("Port whose body is the wheel."),
      scenario::real("radius_m", "m").must().above(0).doc_is("Radius; of a sprocket: base circle."),
      scenario::choice("face", {"inner", "outer"})
          .by_default("inner")
          .doc_is("Face of the band that it touches: z = −h/2 or +h/2."),
      scenario::real("friction", "").at_least(0).doc_is("In place of contact.friction."),
      teeth_key(),
  };
  return scenario::sections("wheels", std::move(wheel)).doc_is("Wheels in contact with the band.");
}

Key attachments_key() {
  Section attachment;
  attachment.title = "Attachment";
  attachment.doc =
      "An end of an open chain that follows a port's frame as it lies in it at t = 0; the port "
      "takes its reaction.";
  attachment.keys = {
      scenario::name("port").must().doc_is("Port whose body holds the end."),
      scenario::choice("end", {"left", "right"})
          .must()
          .doc_is("The chain's beginning, or its end."),
      scenario::choice("kind", {"hinged", "clamped"})
          .by_default("hinged")
          .doc_is("hinged: its point. clamped: its point and gradients."),
  };
  return scenario::sections("attachments", std::move(attachment)).doc_is("Ends fixed to bodies.");
}

Key grounds_key() {
  Section ground;
  ground.title = "Ground";
  ground.doc = "A half-space at rest.";
  ground.keys = {
      vector("point_m", "m", "[0, 0, 0]", "A point of its surface."),
      vector("normal", "", "[0, 0, 1]", "Its outward normal, of any length."),
      scenario::choice("face", {"inner", "outer"})
          .by_default("outer")
          .doc_is("Face of the band that it touches."),
      scenario::real("friction", "").at_least(0).doc_is("In place of contact.friction."),
  };
  return scenario::sections("grounds", std::move(ground)).doc_is("Grounds.");
}

Key settle_key() {
  Section settle;
  settle.title = "Settling";
  settle.doc =
      "A damped phase before t = 0 with all wheels held and without friction: a strained chain "
      "finds its equilibrium, then is at rest.";
  settle.keys = {
      scenario::real("duration_s", "s").above(0).must().doc_is("How long."),
      scenario::real("step_s", "s").above(0).by_default("1e-4").doc_is("Step of this phase."),
      scenario::real("mass_damping_per_s", "1/s")
          .above(0)
          .by_default("300")
          .doc_is("α_M of the damping α_M M."),
  };
  return scenario::section("settle", std::move(settle)).doc_is("Left out: starts as it lies.");
}

Key beam_integrator_key() {
  const StepParams d;
  Section integrator;
  integrator.title = "Beam integrator";
  integrator.doc = "Generalised-α time integration of the beams.";
  integrator.keys = {
      scenario::real("rho_inf", "")
          .between(0, 1)
          .by_default("0.6")
          .doc_is("Spectral radius at infinite frequency: 1 no numerical damping, 0 most."),
      scenario::real("tolerance_m", "m")
          .above(0)
          .by_default("1e-9")
          .doc_is("Newton's iteration ends when no unknown changes by more."),
      scenario::integer("newton_steps")
          .at_least(2)
          .by_default(std::to_string(d.newton_steps))
          .doc_is("Most iterations before the step is cut in two."),
      scenario::integer("halvings")
          .between(0, 10)
          .by_default(std::to_string(d.halvings))
          .doc_is("How often a step may be cut in two."),
  };
  return scenario::section("integrator", std::move(integrator))
      .by_default("{}")
      .doc_is("Time integration.");
}

Key beam_loads_key() {
  Section load;
  load.title = "Beam load";
  load.doc = "A dead force on a point of the centre line, times a law of time.";
  load.keys = {
      scenario::real("at", "").between(0, 1).must().doc_is(
          "Where: part of the chain's length from its beginning."),
      scenario::reals("force_N", "N").must().count(3).doc_is("Force for a value 1 of the law."),
      scenario::law("law", "").by_default("1").doc_is("Factor as a function of time."),
  };
  return scenario::sections("loads", std::move(load)).doc_is("Point loads.");
}

Key beam_velocity_key() {
  Section field;
  field.title = "Beam velocity";
  field.doc = "v = linear + angular × (r − about) at t = 0; not with settling.";
  field.keys = {vector("linear_m_per_s", "m/s", "[0, 0, 0]", "Velocity at the point about_m."),
                vector("angular_rad_per_s", "rad/s", "[0, 0, 0]", "Angular velocity."),
                vector("about_m", "m", "[0, 0, 0]", "The field's reference point.")};
  return scenario::section("velocity", std::move(field))
      .by_default("{}")
      .doc_is("Velocities at t = 0.");
}

Key beam_watch_key() {
  Section point;
  point.title = "Watched point";
  point.doc = "A point of the centre line whose motion is written to beam.csv.";
  point.keys = {
      scenario::name("name").must().doc_is("Name of the columns."),
      scenario::real("at", "").between(0, 1).must().doc_is(
          "Where: part of the chain's length from its beginning."),
  };
  return scenario::sections("watch", std::move(point)).doc_is("Points that are reported.");
}

}  // namespace

Key ancf_keys() {
  Section ancf;
  ancf.title = "ANCF chain";
  ancf.doc =
      "Beams in absolute nodal coordinates: two-node elements of 24 coordinates with constant mass "
      "matrix, joined to a beam, a chain or a track, in contact with wheels and ground.";
  ancf.keys = {path_key(),
               chain_key(),
               section_key(),
               material_key(),
               integration_key(),
               contact_key(),
               wheels_key(),
               grounds_key(),
               attachments_key(),
               settle_key(),
               beam_loads_key(),
               beam_velocity_key(),
               beam_integrator_key(),
               beam_watch_key()};
  return scenario::section("ancf", std::move(ancf));
}

}  // namespace tandem::fem::ancf

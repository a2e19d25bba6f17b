#include "fem_process/keys/fem_keys.h"

#include <string>
#include <utility>
#include <vector>

#include "fem_process/ancf/ancf_keys.h"
#include "fem_process/keys/analysis_keys.h"
#include "fem_process/keys/craig_bampton_keys.h"
#include "fem_process/keys/material_keys.h"
#include "fem_process/keys/mesh_keys.h"
#include "fem_process/transient/micro_step.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/law.h"

namespace tandem::fem {
namespace {

using scenario::Key;
using scenario::Node;
using scenario::Section;

Key damping_key() {
  Section damping;
  damping.title = "Damping";
  damping.doc = "Rayleigh damping C = α M + β K with the stiffness K of the formulation.";
  damping.keys = {
      scenario::real("alpha_per_s", "1/s")
          .at_least(0)
          .by_default("0")
          .doc_is("Part proportional to mass; acts against absolute velocities."),
      scenario::real("beta_s", "s")
          .at_least(0)
          .by_default("0")
          .doc_is("Part proportional to stiffness: damping ratio ω β/2 at angular frequency ω."),
  };
  return scenario::section("damping", std::move(damping))
      .by_default("{}")
      .doc_is("Rayleigh damping.");
}

Key integrator_key() {
  Section integrator;
  integrator.title = "Integrator";
  integrator.doc = "The time integration of the flexible body.";
  integrator.keys = {
      scenario::choice("kind",
                       {"backward_euler", "hht", "generalised_alpha", "newmark", "quasi_static"})
          .by_default("backward_euler")
          .doc_is("First order and robust; or of second order, for vibration: HHT-α, "
                  "generalised-α, Newmark; or static equilibrium in every step, without inertia "
                  "and damping."),
      scenario::real("hht_alpha", "")
          .only_when("kind", {"hht"})
          .between(-1.0 / 3.0, 0)
          .by_default("-0.05")
          .doc_is("Numerical damping of HHT: 0 none (trapezoidal rule), -1/3 most."),
      scenario::real("rho_infinity", "")
          .only_when("kind", {"generalised_alpha"})
          .between(0, 1)
          .by_default("0.9")
          .doc_is("Amplification of infinitely fast motions by a step of generalised-α: 1 damps "
                  "nothing, 0 ends them in one step."),
      scenario::real("newmark_beta", "")
          .only_when("kind", {"newmark"})
          .between(0, 1)
          .above(0)
          .by_default("0.25")
          .doc_is("Newmark's β: 1/4 average, 1/6 linear acceleration. Below newmark_gamma/2 the "
                  "step is stable for slow motions only."),
      scenario::real("newmark_gamma", "")
          .only_when("kind", {"newmark"})
          .between(0.5, 1)
          .by_default("0.5")
          .doc_is("Newmark's γ: above 1/2 damps and is of first order."),
      scenario::integer("newton_steps")
          .at_least(0)
          .by_default("0")
          .doc_is("Most equilibrium iterations of a step; 0 is the single linearised step of "
                  "[MZ12], or 100 iterations when quasi_static."),
      scenario::real("newton_tolerance", "")
          .above(0)
          .below(1)
          .by_default("1e-8")
          .doc_is("Residual at which the iterations end, relative to the largest of inertia, "
                  "internal and external forces."),
  };
  return scenario::section("integrator", std::move(integrator))
      .by_default("{}")
      .doc_is("Time integration.");
}

Key solver_key() {
  Section solver;
  solver.title = "Linear solver";
  solver.doc = "How the linear system of a step is solved.";
  solver.keys = {
      scenario::choice("kind", {"automatic", "cholmod", "pcg"})
          .by_default("automatic")
          .doc_is(
              "Sparse Cholesky, or conjugate gradients started from past velocities. automatic: "
              "in coupled runs the faster one for run.accuracy, else Cholesky."),
      scenario::real("tolerance", "")
          .only_when("kind", {"pcg"})
          .above(0)
          .below(1)
          .doc_is("Residual at which PCG stops, relative to the right-hand side. Left out: 1e-4 "
                  "run.accuracy, at most 1e-10, in coupled runs, else 1e-12."),
      scenario::integer("max_iterations")
          .only_when("kind", {"pcg"})
          .at_least(1)
          .by_default("5000")
          .doc_is("Iterations after which PCG stops; see on_not_converged."),
      scenario::choice("on_not_converged", {"stop", "accept"})
          .only_when("kind", {"pcg"})
          .by_default("stop")
          .doc_is("What PCG does after max_iterations: stop the run, or take what it has, so that "
                  "no step takes longer than so many iterations [MZ12]; what that leaves in the "
                  "wrench is booked."),
      scenario::choice("preconditioner", {"automatic", "block_jacobi", "rest_factor",
                                          "warped_rest_factor", "warped_rest_multigrid"})
          .only_when("kind", {"pcg"})
          .by_default("automatic")
          .doc_is("What PCG takes for the inverse: that of the 3×3 diagonal blocks, of the step "
                  "matrix at the reference positions, of that one turned with the nodes, or a "
                  "cycle of multigrid in place of the latter. automatic: warped_rest_factor up to "
                  "10000 free nodes, beyond warped_rest_multigrid."),
      scenario::choice("initial_guess", {"previous", "projection"})
          .only_when("kind", {"pcg"})
          .by_default("projection")
          .doc_is("Where PCG starts: the last velocities, or the best combination of the last "
                  "eight."),
  };
  return scenario::section("solver", std::move(solver))
      .by_default("{}")
      .doc_is("Linear solver of the steps.");
}

Key loads_key() {
  Section load;
  load.title = "Load";
  load.doc = "A dead load: fixed direction in world axes, reference areas, times a law of time.";
  load.keys = {
      scenario::choice("kind", {"nodal", "surface"})
          .must()
          .doc_is(
              "A total force in equal parts on the nodes of a set, or a traction on a surface."),
      scenario::text("set").must().doc_is("Node set or surface of the mesh."),
      scenario::reals("force_N", "N")
          .count(3)
          .doc_is("Total force for a value 1 of the law; on a surface it is spread as a uniform "
                  "traction."),
      scenario::reals("traction_Pa", "Pa")
          .count(3)
          .only_when("kind", {"surface"})
          .doc_is("Force per reference area for a value 1 of the law, in place of force_N."),
      scenario::law("law", "").by_default("1").doc_is("Factor as a function of time."),
  };
  load.check = [](const Node& node) {
    const bool nodal = node.text("kind") == "nodal";
    if (node.has("force_N") && node.has("traction_Pa")) {
      node.fail("traction_Pa", "stands beside force_N. Give one of them.");
    }
    if (node.has("force_N") || node.has("traction_Pa")) return;
    node.fail("kind", nodal ? "needs force_N: [x, y, z]."
                            : "needs traction_Pa: [x, y, z] or force_N: [x, y, z].");
  };
  return scenario::sections("loads", std::move(load)).doc_is("Loads on the mesh.");
}

Key changes_key() {
  Section change;
  change.title = "Change";
  change.doc =
      "A change of the boundary conditions before the first macro step that begins at or after "
      "at_s; `tandem control` makes the same changes by hand.";
  change.keys = {
      scenario::real("at_s", "s").must().at_least(0).doc_is("When."),
      scenario::text("release").doc_is("Fixed set whose nodes move again."),
      scenario::text("fix").doc_is("Node set that is held where it is."),
      scenario::text("force").doc_is("Node set that takes force_N, in equal parts on its nodes, in "
                                     "place of the last such force on it."),
      scenario::reals("force_N", "N").count(3).doc_is("Total force in world axes."),
  };
  change.check = [](const Node& node) {
    const int verbs =
        (node.has("release") ? 1 : 0) + (node.has("fix") ? 1 : 0) + (node.has("force") ? 1 : 0);
    if (verbs != 1) node.fail("at_s", "needs one of release, fix and force beside it.");
    if (node.has("force") != node.has("force_N")) {
      node.fail(node.has("force") ? "force" : "force_N", "force and force_N go together.");
    }
  };
  return scenario::sections("changes", std::move(change))
      .doc_is("Sets released, fixed and loaded while the body runs, in the order of their times.");
}

Key initial_velocity_key() {
  Section field;
  field.title = "Initial velocity";
  field.doc = "v(X) = linear + angular × (X − about) + gradient (X − about), X in world axes.";
  const auto vector = [](const char* name, const char* unit, const char* doc) {
    return scenario::reals(name, unit).count(3).by_default("[0, 0, 0]").doc_is(doc);
  };
  field.keys = {
      vector("linear_m_per_s", "m/s", "Velocity at the point `about_m`."),
      vector("angular_rad_per_s", "rad/s", "Angular velocity."),
      vector("about_m", "m", "The field's reference point."),
      scenario::reals("gradient_per_s", "1/s")
          .count(9)
          .by_default("[0, 0, 0, 0, 0, 0, 0, 0, 0]")
          .doc_is("Velocity gradient ∂v_i/∂X_j, row by row."),
  };
  return scenario::section("initial_velocity", std::move(field))
      .by_default("{}")
      .doc_is("Velocities at t = 0; port nodes start with their port's instead.");
}

IntegratorParams read_integrator(const Node& node) {
  IntegratorParams integrator;
  integrator.newton_steps = static_cast<int>(node.integer("newton_steps"));
  integrator.newton_tolerance = node.real("newton_tolerance");
  if (node.text("kind") == "hht") {
    integrator.kind = IntegratorKind::Hht;
    integrator.hht_alpha = node.real("hht_alpha");
  } else if (node.text("kind") == "generalised_alpha") {
    integrator.kind = IntegratorKind::GeneralisedAlpha;
    integrator.rho_infinity = node.real("rho_infinity");
  } else if (node.text("kind") == "quasi_static") {
    integrator.kind = IntegratorKind::QuasiStatic;
  } else if (node.text("kind") == "newmark") {
    integrator.kind = IntegratorKind::Newmark;
    integrator.newmark_beta = node.real("newmark_beta");
    integrator.newmark_gamma = node.real("newmark_gamma");
  }
  return integrator;
}

PreconditionerKind read_preconditioner(const std::string& name) {
  if (name == "block_jacobi") return PreconditionerKind::BlockJacobi;
  if (name == "rest_factor") return PreconditionerKind::RestFactor;
  if (name == "warped_rest_factor") return PreconditionerKind::WarpedRestFactor;
  if (name == "warped_rest_multigrid") return PreconditionerKind::WarpedRestMultigrid;
  return PreconditionerKind::Automatic;
}

SolverParams read_solver(const Node& node) {
  SolverParams solver;
  if (node.text("kind") == "pcg") {
    solver.kind = SolverKind::Pcg;
    if (node.has("tolerance")) solver.tolerance = node.real("tolerance");
    solver.max_iterations = static_cast<int>(node.integer("max_iterations"));
    solver.accept_unconverged = node.text("on_not_converged") == "accept";
    solver.preconditioner = read_preconditioner(node.text("preconditioner"));
    if (node.text("initial_guess") == "previous") solver.initial_guess = InitialGuess::Previous;
  }
  return solver;
}

Load read_load(const Node& node) {
  Load load;
  load.set = {node.text("set"), node.place("set")};
  load.kind = node.text("kind") == "nodal" ? Load::Kind::Nodal
              : node.has("traction_Pa")    ? Load::Kind::Surface
                                           : Load::Kind::SurfaceForce;
  load.value = node.vector3(node.has("traction_Pa") ? "traction_Pa" : "force_N");
  load.law = scenario::read_law(node.section("law"));
  return load;
}

ScheduledChange read_change(const Node& node) {
  ScheduledChange change{
      .at = sim_time_from_seconds(node.real("at_s")), .command = {}, .place = {}};
  const char* const verb = node.has("release") ? "release" : node.has("fix") ? "fix" : "force";
  change.place = node.place(verb);
  change.command = node.has("force") ? force_command(node.vector3("force_N"), node.text("force"))
                                     : std::string(verb) + " " + node.text(verb);
  return change;
}

InitialVelocity read_initial_velocity(const Node& node) {
  InitialVelocity field;
  field.linear_m_per_s = node.vector3("linear_m_per_s");
  field.angular_rad_per_s = node.vector3("angular_rad_per_s");
  field.about_m = node.vector3("about_m");
  const std::vector<double> gradient = node.reals("gradient_per_s");
  field.gradient_per_s =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(gradient.data());
  return field;
}

FormulationKind read_formulation(const std::string& name) {
  if (name == "linear") return FormulationKind::Linear;
  if (name == "corotational_consistent") return FormulationKind::ConsistentCorotational;
  if (name == "total_lagrangian") return FormulationKind::TotalLagrangian;
  if (name == "craig_bampton") return FormulationKind::CraigBampton;
  return FormulationKind::Corotational;
}

std::vector<SetName> read_sets(const Node& node, const char* key) {
  std::vector<SetName> sets;
  for (const std::string& name : node.names(key)) sets.push_back({name, node.place(key)});
  return sets;
}

}  // namespace

Key fem_keys() {
  Section fem;
  fem.title = "Flexible body";
  fem.doc =
      "A finite-element body whose port nodes are attached to the ports, or beams in contact with "
      "the ports' bodies.";
  fem.keys = {
      mesh_key(),
      material_key(),
      materials_key(),
      scenario::choice("formulation", {"linear", "corotational", "corotational_consistent",
                                       "total_lagrangian", "craig_bampton"})
          .by_default("corotational")
          .doc_is("Internal forces: small displacements; co-rotational with the simplified tangent "
                  "of [MZ12], or with the rotation's derivative in the tangent; St. "
                  "Venant-Kirchhoff in total Lagrangian form; or small displacements in modes of a "
                  "floating frame."),
      craig_bampton_key(),
      scenario::choice("coupling", {"ports", "nodal"})
          .by_default("ports")
          .doc_is("What the sides exchange: rigid frames with the nodes attached to them; or every "
                  "free node, which then is a point mass of the multibody side while this side "
                  "evaluates internal forces alone. For nodal, leave out ports and mbs.bodies: "
                  "they are made from the mesh and called node_<tag>."),
      scenario::choice("mass", {"lumped", "consistent"})
          .by_default("consistent")
          .doc_is("A tet's mass on its nodes (a quarter each; of second order, in proportion to "
                  "the diagonal of the consistent matrix), or ∫ ρ N_i N_j dV."),
      damping_key(),
      integrator_key(),
      solver_key(),
      scenario::integer("threads").between(1, 64).by_default("1").doc_is(
          "Threads of the flexible side's loops. The results have the same bits for any number. "
          "More than one pays from some 5000 elements on, where processors are idle."),
      scenario::real("micro_step_s", "s")
          .above(0)
          .doc_is(
              "Integration step; the macro step is a whole multiple. Left out: the macro step."),
      scenario::reals("gravity_m_per_s2", "m/s²")
          .count(3)
          .by_default("[0, 0, 0]")
          .doc_is("Acceleration of gravity on the flexible body in world axes."),
      scenario::names("fixed").of_any_text().by_default("[]").doc_is(
          "Node sets held at their initial positions; any names that the mesh has."),
      loads_key(),
      changes_key(),
      initial_velocity_key(),
      scenario::names("watch").of_any_text().by_default("[]").doc_is(
          "Node sets whose mean motion is written to the results; any names that the mesh has."),
      analysis_keys(),
  };
  fem.check = [](const Node& node) {
    if (node.text("model") == "solid") check_materials(node);
  };
  for (Key& key : fem.keys) {
    const bool common =
        key.name == "micro_step_s" || key.name == "gravity_m_per_s2" || key.name == "analysis";
    if (!common) key.only_when("model", {"solid"});
  }
  fem.keys.insert(
      fem.keys.begin(),
      scenario::choice("model", {"solid", "ancf"})
          .by_default("solid")
          .doc_is("A meshed solid body, or beams in absolute nodal coordinates: chains, tracks, "
                  "belts."));
  fem.keys.push_back(ancf::ancf_keys()
                         .must()
                         .only_when("model", {"ancf"})
                         .doc_is("Beams in absolute nodal coordinates."));
  fem.keys.insert(fem.keys.begin(),
                  scenario::name("name").doc_is("Name of the body, where there are several: ports "
                                                "say which is theirs (`flexible`)."));
  return scenario::section("fem", std::move(fem))
      .must()
      .or_several()
      .doc_is("The flexible side: one body, or a list of them, each in a process of its own.");
}

Params read_params(const Node& root) {
  const Node fem = root.section("fem");
  Params params;
  params.mesh = read_mesh_params(fem.section("mesh"));
  const Eigen::Matrix3d R_WM = params.mesh.orientation.toRotationMatrix();
  if (fem.has("material")) params.material = read_material(fem.section("material"), R_WM);
  params.materials = read_materials(fem, R_WM);
  params.formulation = read_formulation(fem.text("formulation"));
  params.craig_bampton = read_craig_bampton(fem.section("craig_bampton"));
  params.mass = fem.text("mass") == "lumped" ? MassKind::Lumped : MassKind::Consistent;
  const Node damping = fem.section("damping");
  params.damping = {damping.real("alpha_per_s"), damping.real("beta_s")};
  params.integrator = read_integrator(fem.section("integrator"));
  params.solver = read_solver(fem.section("solver"));
  params.threads = static_cast<int>(fem.integer("threads"));
  const MicroStep step = read_micro_step(root);
  params.micro_step = step.length;
  params.follows_macro_step = step.follows_macro_step;
  params.gravity_m_per_s2 = fem.vector3("gravity_m_per_s2");
  params.fixed = read_sets(fem, "fixed");
  params.watch = read_sets(fem, "watch");
  if (fem.has("loads")) {
    for (const Node& load : fem.list("loads")) params.loads.push_back(read_load(load));
  }
  if (fem.has("changes")) {
    for (const Node& change : fem.list("changes")) params.changes.push_back(read_change(change));
  }
  params.initial_velocity = read_initial_velocity(fem.section("initial_velocity"));
  params.nodal = fem.text("coupling") == "nodal";
  if (!root.has("ports")) return params;
  for (const scenario::PortParams& port : scenario::read_ports(root)) {
    if (params.nodal) {
      params.node_ports.push_back({port.name, port.place});
      continue;
    }
    require(!port.node_set.empty(), port.place.text() + ": port '" + port.name +
                                        "' needs node_set: its nodes of the mesh.");
    PortSet set{.name = port.name,
                .set = {port.node_set, port.place},
                .p_WP = std::nullopt,
                .attachment = port.attachment};
    if (!port.at_body_frame) set.p_WP = port.p_WP;
    params.ports.push_back(std::move(set));
  }
  return params;
}

}  // namespace tandem::fem

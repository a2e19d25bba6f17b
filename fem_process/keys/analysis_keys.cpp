#include "fem_process/keys/analysis_keys.h"

#include <utility>

namespace tandem::fem {

namespace {

scenario::Key motions_key() {
  scenario::Section motion;
  motion.title = "Moved set";
  motion.doc =
      "A node set that moves rigidly in a transient or quasi-static analysis: its frame, at first "
      "at about_m with world axes, goes by s(t) translation_m and turns by s(t) rotation_rad, s "
      "the law.";
  motion.keys = {
      scenario::text("set").must().doc_is("Node set of the mesh; a port's, or another."),
      scenario::reals("translation_m", "m")
          .count(3)
          .by_default("[0, 0, 0]")
          .doc_is("Displacement for a value 1 of the law."),
      scenario::reals("rotation_rad", "rad")
          .count(3)
          .by_default("[0, 0, 0]")
          .doc_is("Rotation vector for a value 1 of the law."),
      scenario::reals("about_m", "m")
          .count(3)
          .doc_is("Origin of the set's frame at t = 0: rotations and torques are about it. Left "
                  "out: the mean of the nodes."),
      scenario::law("law", "").must().doc_is("Factor s(t); 0 at t = 0."),
  };
  return scenario::sections("motions", std::move(motion))
      .doc_is(
          "Transient, quasi-static: node sets with prescribed motion. The results have the "
          "wrenches on their frames.");
}

std::vector<SetMotion> read_motions(const scenario::Node& analysis) {
  std::vector<SetMotion> motions;
  if (!analysis.has("motions")) return motions;
  for (const scenario::Node& node : analysis.list("motions")) {
    SetMotion motion{.set = {node.text("set"), node.place("set")},
                     .translation_m = node.vector3("translation_m"),
                     .rotation_rad = node.vector3("rotation_rad"),
                     .about_m = std::nullopt,
                     .law = scenario::read_law(node.section("law"))};
    if (node.has("about_m")) motion.about_m = node.vector3("about_m");
    if (motion.law(0.0) != 0.0) {
      node.fail("law", "is not 0 at t = 0, where the set stands as the mesh has it. Use a ramp.");
    }
    motions.push_back(std::move(motion));
  }
  return motions;
}

}  // namespace

scenario::Key analysis_keys() {
  scenario::Section analysis;
  analysis.title = "Analysis";
  analysis.doc =
      "What `tandem fem` computes of the flexible body alone, port nodes and fixed sets held at "
      "their initial positions unless `motions` moves them. That command needs `name` and `fem` "
      "only, and `run` for a transient or quasi-static analysis; coupled runs pass this section "
      "over.";
  analysis.keys = {
      scenario::choice("kind", {"static", "quasi_static", "modes", "transient"})
          .by_default("static")
          .doc_is("Equilibrium under growing loads, equilibria over time at given motions and "
                  "loads, eigenfrequencies, or motion."),
      scenario::integer("load_steps")
          .at_least(1)
          .by_default("10")
          .doc_is("Static: equal steps of the load factor up to 1."),
      scenario::reals("load_factors", "")
          .at_least_count(1)
          .doc_is("Static: the factors of all loads and gravity, in place of load_steps."),
      scenario::real("tolerance", "")
          .above(0)
          .below(1)
          .by_default("1e-8")
          .doc_is("Static: residual of an equilibrium, relative to the load."),
      scenario::integer("max_iterations")
          .at_least(1)
          .by_default("100")
          .doc_is("Static: linear solves for one increment before it is given up."),
      scenario::boolean("safeguards")
          .by_default("true")
          .doc_is("Static: line search, then cutting of the load, where the plain iteration "
                  "stalls."),
      scenario::real("law_time_s", "s")
          .by_default("0")
          .doc_is("Static: time at which the laws of the loads are read."),
      scenario::integer("modes").at_least(1).by_default("10").doc_is(
          "Modes: how many of the lowest eigenfrequencies."),
      motions_key(),
  };
  return scenario::section("analysis", std::move(analysis))
      .by_default("{}")
      .doc_is("What `tandem fem` computes.");
}

AnalysisParams read_analysis(const scenario::Node& root) {
  const scenario::Node node = root.section("fem").section("analysis");
  AnalysisParams params;
  params.kind = node.text("kind");
  params.motions = read_motions(node);
  params.modes = static_cast<int>(node.integer("modes"));
  StaticParams& statics = params.statics;
  if (node.has("load_factors")) {
    statics.load_factors = node.reals("load_factors");
  } else {
    const std::int64_t n = node.integer("load_steps");
    statics.load_factors.clear();
    for (std::int64_t i = 1; i <= n; ++i) {
      statics.load_factors.push_back(static_cast<double>(i) / static_cast<double>(n));
    }
  }
  statics.tolerance = node.real("tolerance");
  statics.max_iterations = static_cast<int>(node.integer("max_iterations"));
  statics.safeguards = node.boolean("safeguards");
  statics.law_time_s = node.real("law_time_s");
  return params;
}

}  // namespace tandem::fem

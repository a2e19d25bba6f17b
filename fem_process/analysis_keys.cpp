#include "fem_process/analysis_keys.h"

#include <utility>

namespace tandem::fem {

scenario::Key analysis_keys() {
  scenario::Section analysis;
  analysis.title = "Analysis";
  analysis.doc =
      "What `tandem fem` computes of the flexible body alone, port nodes and fixed sets held at "
      "their initial positions. That command needs `name` and `fem` only, and `run` for a "
      "transient analysis; coupled runs pass this section over.";
  analysis.keys = {
      scenario::choice("kind", {"static", "modes", "transient"})
          .by_default("static")
          .doc_is("Equilibrium under growing loads, eigenfrequencies, or motion under the loads."),
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
  };
  return scenario::section("analysis", std::move(analysis))
      .by_default("{}")
      .doc_is("What `tandem fem` computes.");
}

AnalysisParams read_analysis(const scenario::Node& root) {
  const scenario::Node node = root.section("fem").section("analysis");
  AnalysisParams params;
  params.kind = node.text("kind");
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

#include "fem_process/keys/craig_bampton_keys.h"

#include <utility>

namespace tandem::fem {

scenario::Key craig_bampton_key() {
  scenario::Section reduction;
  reduction.title = "Craig-Bampton";
  reduction.doc =
      "Component mode synthesis: six constraint modes for every port, and for the fixed nodes "
      "together, plus normal modes of the body with all these held, in a floating frame. For "
      "formulation: craig_bampton; others pass it over. The linear solver's section is not used.";
  reduction.keys = {
      scenario::integer("modes").at_least(0).by_default("20").doc_is(
          "How many of the lowest normal modes."),
      scenario::real("frequency_limit_Hz", "Hz")
          .above(0)
          .doc_is("All normal modes up to this frequency, in place of modes."),
      scenario::text("frame").by_default("mean").doc_is(
          "What carries the floating frame: the mean motion of all ports and the fixed nodes, a "
          "port by its name, or world for a frame at rest."),
  };
  return scenario::section("craig_bampton", std::move(reduction))
      .by_default("{}")
      .doc_is("Modes of the reduced body.");
}

CraigBamptonParams read_craig_bampton(const scenario::Node& node) {
  CraigBamptonParams reduction;
  reduction.modes = static_cast<int>(node.integer("modes"));
  if (node.has("frequency_limit_Hz")) {
    reduction.frequency_limit_Hz = node.real("frequency_limit_Hz");
  }
  reduction.frame = {node.text("frame"), node.place("frame")};
  return reduction;
}

}  // namespace tandem::fem

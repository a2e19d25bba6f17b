#pragma once

#include <string>
#include <vector>

#include "fem_process/ports/set_motion.h"
#include "fem_process/transient/static_analysis.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// What `tandem fem` computes.
struct AnalysisParams {
  std::string kind = "static";  ///< static, quasi_static, modes or transient
  std::vector<SetMotion> motions;
  StaticParams statics;
  int modes = 10;  ///< lowest eigenfrequencies
};

/// Section `fem.analysis`: the flexible body alone.
[[nodiscard]] scenario::Key analysis_keys();
[[nodiscard]] AnalysisParams read_analysis(const scenario::Node& root);

}  // namespace tandem::fem

#include "fem_process/sides/make_model.h"

#include "fem_process/ancf/make_beam_side.h"
#include "fem_process/sides/make_side.h"

namespace tandem::fem {

std::unique_ptr<FemSide> make_model(const scenario::Node& root,
                                    const std::filesystem::path& directory) {
  if (root.section("fem").text("model") == "ancf") return ancf::make_beam_side(root, directory);
  return make_side(root, directory);
}

}  // namespace tandem::fem

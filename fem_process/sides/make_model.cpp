#include "fem_process/sides/make_model.h"

#include "fem_process/ancf/make_beam_side.h"
#include "fem_process/sides/make_side.h"

namespace tandem::fem {

std::unique_ptr<FemSide> make_model(const scenario::Node& root,
                                    const std::filesystem::path& directory) {
  if (root.section("fem").text("model") == "ancf") return ancf::make_beam_side(root, directory);
  return make_side(root, directory);
}

std::filesystem::path folder_of(const std::filesystem::path& run_folder, const scenario::Node& root,
                                std::size_t bodies) {
  if (run_folder.empty() || bodies == 1) return run_folder;
  return run_folder / root.section("fem").text("name");
}

}  // namespace tandem::fem

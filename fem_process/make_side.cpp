#include "fem_process/make_side.h"

#include "fem_process/fem_keys.h"

namespace tandem::fem {

std::unique_ptr<FlexibleBody> make_side(const scenario::Node& root,
                                        const std::filesystem::path& /*directory*/) {
  return std::make_unique<FlexibleBody>(read_params(root));
}

}  // namespace tandem::fem

#include "fem_process/make_side.h"

#include "fem_process/fem_keys.h"
#include "fem_process/vtu_writer.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::fem {

std::unique_ptr<FlexibleBody> make_side(const scenario::Node& root,
                                        const std::filesystem::path& directory) {
  auto body = std::make_unique<FlexibleBody>(read_params(root));
  const std::int64_t every_steps = scenario::read_output(root).vtu_every_steps;
  if (directory.empty() || every_steps == 0) return body;

  // shared_ptr: std::function must be copyable, although this one never is copied. The model lives
  // as long as the body, which owns the function.
  auto vtu = std::make_shared<VtuWriter>(body->model(), directory / "fem", "fem", every_steps);
  body->on_accepted([vtu](const State& state) { vtu->write(state); });
  return body;
}

}  // namespace tandem::fem

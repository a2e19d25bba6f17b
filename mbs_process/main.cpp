// tandem-mbs: the multibody process. Runs the scheme, or serves the process that does.

#include <utility>

#include "mbs_process/make_side.h"
#include "mbs_process/mbs_keys.h"
#include "protocol/driver/side_process.h"

int main(int argc, char** argv) {
  using namespace tandem;
  const SideProgram program{
      .self = wire::Process::Mbs,
      .name = "tandem-mbs",
      .description = "Multibody process of a coupled run: rigid bodies and joints on ODE.",
      .keys = mbs::mbs_keys()};
  return run_side_process(program, argc, argv, [](SideContext& context) {
    const std::filesystem::path folder =
        mbs::folder_of(context.directory, context.scenario.root, context.worlds.size());
    auto side = mbs::make_side(context.scenario.root, folder);
    if (context.driver == context.bus.options().self) {
      return drive_from_mbs(context, std::move(side));
    }
    serve_side(context, *side);
    return 0;
  });
}

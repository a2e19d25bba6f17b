// tandem-fem: the flexible-body process. Serves the process that runs the scheme.

#include "fem_process/keys/fem_keys.h"
#include "fem_process/sides/make_model.h"
#include "protocol/driver/side_process.h"
#include "protocol/schemes/transmission_line.h"

int main(int argc, char** argv) {
  using namespace tandem;
  const SideProgram program{
      .self = wire::Process::Fem,
      .name = "tandem-fem",
      .description =
          "Flexible-body process of a coupled run: finite elements of a solid, or an ANCF chain.",
      .keys = fem::fem_keys()};
  return run_side_process(program, argc, argv, [](SideContext& context) {
    const std::filesystem::path folder =
        fem::folder_of(context.directory, context.scenario.root, context.bodies.size());
    const auto side = prepared_for(read_coupling(context.scenario.root),
                                   fem::make_model(context.scenario.root, folder));
    serve_side(context, *side);
    return 0;
  });
}

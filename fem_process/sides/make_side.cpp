#include "fem_process/sides/make_side.h"

#include "fem_process/keys/fem_keys.h"
#include "fem_process/output/vtu_writer.h"
#include "fem_process/output/watch_csv.h"
#include "fem_process/reduced/reduced_body.h"
#include "fem_process/sides/flexible_body.h"
#include "fem_process/sides/nodal_body.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::fem {
namespace {

/// The files of a run. The model lives as long as the body, which owns the function that uses them.
struct Files {
  std::optional<VtuWriter> vtu;
  std::optional<WatchCsv> watch;
};

void require_rigid(const Params& params, const std::string& cause, const std::string& choice) {
  for (const PortSet& port : params.ports) {
    require(!port.attachment.loose(),
            (port.set.place.file.empty() ? "fem" : port.set.place.text()) + ": port '" + port.name +
                "' is not rigid, and " + cause + ". Set attachment: rigid, or choose " + choice +
                ".");
  }
}

}  // namespace

std::unique_ptr<FlexibleSide> make_body(Params params) {
  if (params.nodal) {
    require_rigid(params, "with fem.coupling: nodal every node is a port of its own",
                  "fem.coupling: ports");
    return std::make_unique<NodalBody>(std::move(params));
  }
  if (params.formulation == FormulationKind::CraigBampton) {
    require(params.changes.empty(),
            "fem: fem.changes needs the full body: the modes of craig_bampton belong to the sets "
            "that are held at t = 0. Choose another fem.formulation.");
    require_rigid(params, "the constraint modes of craig_bampton move every port's nodes rigidly",
                  "another fem.formulation");
    return std::make_unique<ReducedBody>(std::move(params));
  }
  return std::make_unique<FlexibleBody>(std::move(params));
}

std::unique_ptr<FlexibleSide> make_side(const scenario::Node& root,
                                        const std::filesystem::path& directory) {
  const Params params = read_params(root);
  std::unique_ptr<FlexibleSide> body = make_body(params);
  if (directory.empty()) return body;

  // shared_ptr: std::function must be copyable, although this one never is copied.
  auto files = std::make_shared<Files>();
  const std::int64_t every_steps = scenario::read_output(root).vtu_every_steps;
  if (!params.watch.empty()) std::filesystem::create_directories(directory);
  if (every_steps > 0) files->vtu.emplace(body->model(), directory / "fem", "fem", every_steps);
  if (!params.watch.empty()) files->watch.emplace(directory / "watch.csv", names_of(params.watch));
  const SimTime end = scenario::read_run(root).duration;
  body->on_accepted([files, end, &model = body->model()](const State& state) {
    if (files->vtu) files->vtu->write(state);
    if (!files->watch) return;
    files->watch->write(model, state);
    if (state.time >= end) files->watch->finish();
  });
  return body;
}

}  // namespace tandem::fem

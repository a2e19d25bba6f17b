#include "mbs_process/make_side.h"

#include "mbs_process/bodies_csv.h"
#include "mbs_process/mbs_keys.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::mbs {

std::unique_ptr<RigidWorld> make_side(const scenario::Node& root,
                                      const std::filesystem::path& directory) {
  auto world = std::make_unique<RigidWorld>(read_params(root));
  const std::int64_t every_steps = scenario::read_output(root).bodies_every_steps;
  if (directory.empty() || every_steps == 0) return world;

  std::vector<std::string> names;
  for (const BodyParams& body : world->params().bodies) names.push_back(body.name);
  std::filesystem::create_directories(directory);
  // shared_ptr: std::function must be copyable, although this one never is copied.
  auto csv = std::make_shared<BodiesCsv>(directory / "bodies.csv", names, every_steps);
  const SimTime end = scenario::read_run(root).duration;
  world->on_accepted_state([csv, end](const State& state) {
    csv->write(state);
    if (state.time >= end) csv->finish();
  });
  return world;
}

std::filesystem::path folder_of(const std::filesystem::path& run_folder, const scenario::Node& root,
                                std::size_t worlds) {
  if (run_folder.empty() || worlds == 1) return run_folder;
  return run_folder / root.section("mbs").text("name");
}

}  // namespace tandem::mbs

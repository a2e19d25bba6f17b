#include "orchestrator/model.h"

#include <utility>

#include "fem_process/make_model.h"
#include "fem_process/mesh.h"
#include "mbs_process/make_side.h"
#include "orchestrator/nodal_scenario.h"
#include "orchestrator/scenario_table.h"
#include "protocol/schemes/transmission_line.h"

namespace tandem::orchestrator {

namespace {

/// Also with the mesh's fingerprint, so that a run folder tells which mesh it is about.
scenario::Loaded load_with_checksum(const std::filesystem::path& file,
                                    std::vector<scenario::Override> overrides) {
  overrides = with_nodes(file, std::move(overrides));
  scenario::Loaded loaded = scenario::load(file, scenario_table(), overrides);
  const scenario::Node fem = loaded.root.section("fem");
  if (!fem.has("mesh") || fem.section("mesh").has("checksum")) return loaded;
  const std::string checksum = fem::mesh_checksum(fem.section("mesh").path("file"));
  if (checksum.empty()) return loaded;
  // In quotes: digits alone would be a number.
  overrides.push_back({"fem.mesh.checksum", "'" + checksum + "'"});
  return scenario::load(file, scenario_table(), overrides);
}

}  // namespace

Model load_model(const std::filesystem::path& file,
                 const std::vector<scenario::Override>& overrides) {
  Model model{.scenario = load_with_checksum(file, overrides)};
  const scenario::Node& root = model.scenario.root;
  model.name = root.text("name");
  model.run = scenario::read_run(root);
  model.coupling = read_coupling(root);
  model.wire = read_wire(root);
  for (const scenario::PortParams& port : scenario::read_ports(root)) {
    model.port_names.push_back(port.name);
  }
  return model;
}

std::unique_ptr<MbsSide> make_mbs(const Model& model, const std::filesystem::path& directory) {
  return mbs::make_side(model.scenario.root, directory);
}

std::unique_ptr<FemSide> make_fem(const Model& model, const std::filesystem::path& directory) {
  return prepared_for(model.coupling, fem::make_model(model.scenario.root, directory));
}

}  // namespace tandem::orchestrator

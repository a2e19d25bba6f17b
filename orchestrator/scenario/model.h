#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/driver/wire_params.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/multibody_worlds.h"
#include "protocol/scenario/scenario_file.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem::orchestrator {

/// A validated scenario and its parts that the orchestrator itself uses.
struct Model {
  scenario::Loaded scenario;
  std::string name;
  scenario::RunParams run;
  CouplingParams coupling;
  WireParams wire;
  std::vector<std::string> port_names;
  std::vector<scenario::BodyPorts> table;        ///< of the flexible bodies
  std::vector<scenario::FlexibleBody> bodies;    ///< the same, each with its part of the scenario
  std::vector<scenario::BodyPorts> world_table;  ///< of the multibody worlds
  std::vector<scenario::MultibodyWorld> worlds;  ///< the same, each with its part of the scenario
  std::vector<scenario::Override> chosen;  ///< what the scenario left open, see chosen_settings()
};

/// Whether some of its frames have no mass: those need a scheme that iterates.
[[nodiscard]] bool has_junctions(const Model& model);

/// Names of the single worlds where there are several, then of the flexible bodies where there are:
/// the parts of SideEnergies.
[[nodiscard]] std::vector<std::string> part_names(const Model& model);

/// The section `mbs` of every world.
[[nodiscard]] std::vector<scenario::Node> mbs_sections(const Model& model);

/// The model as if this body were the only flexible one; itself where it is.
[[nodiscard]] Model part_of(const Model& model, std::size_t body);

/// Loads and validates with the whole key table; makes bodies and ports of nodes where the scenario
/// couples them (see nodal_scenario.h).
[[nodiscard]] Model load_model(const std::filesystem::path& file,
                               const std::vector<scenario::Override>& overrides);

/// The sides as objects of this process. `directory`: run folder for their files; empty = none.
[[nodiscard]] std::unique_ptr<MbsSide> make_mbs(const Model& model,
                                                const std::filesystem::path& directory);
[[nodiscard]] std::unique_ptr<FemSide> make_fem(const Model& model,
                                                const std::filesystem::path& directory);
/// The side of one of several worlds, and of one of several flexible bodies.
[[nodiscard]] std::unique_ptr<MbsSide> make_mbs(const Model& model,
                                                const scenario::MultibodyWorld& world,
                                                const std::filesystem::path& directory);
[[nodiscard]] std::unique_ptr<FemSide> make_fem(const Model& model,
                                                const scenario::FlexibleBody& body,
                                                const std::filesystem::path& directory);

}  // namespace tandem::orchestrator

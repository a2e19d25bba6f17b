#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocol/driver/wire_params.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/multibody_worlds.h"
#include "protocol/scenario/scenario_file.h"
#include "protocol/schemes/coupling_params.h"
#include "protocol/wire/bus.h"
#include "protocol/wire/liveness.h"

namespace tandem {

inline constexpr const char* kTandemVersion = "0.1.0";

/// What makes tandem-mbs and tandem-fem different from each other.
struct SideProgram {
  wire::Process self;       ///< Mbs or Fem
  std::string name;         ///< "tandem-fem"
  std::string description;  ///< for --help
  scenario::Key keys;       ///< the scenario section of this side
};

/// What a side process has in hand once it has joined its run.
struct SideContext {
  /// As this side reads it: of several flexible bodies or worlds its own alone.
  scenario::Loaded scenario;
  scenario::RunParams run;
  WireParams wire;
  std::vector<std::string> port_names;      ///< of the run
  std::vector<scenario::BodyPorts> bodies;  ///< the flexible ones of the run
  std::vector<scenario::BodyPorts> worlds;  ///< the multibody ones of the run
  std::filesystem::path directory;  ///< run folder for files of this side; empty = write none
  wire::Bus& bus;
  wire::Heartbeat& heartbeat;
  wire::LivenessMonitor& monitor;
  wire::Process driver;  ///< the process that runs the scheme
};

/// main() of a side process: command line, scenario, bus, heartbeat, `body`, and the translation of
/// errors into messages to the partners and exit codes. Returns the exit code; `body` returns its
/// own.
int run_side_process(const SideProgram& program, int argc, char** argv,
                     const std::function<int(SideContext&)>& body);

/// Serves `side` to the driver of the run until it says bye.
void serve_side(SideContext& context, MbsSide& side);
void serve_side(SideContext& context, FemSide& side);

/// Runs the scheme here, with `mbs` as the local side, the first of several worlds, and tandem-fem
/// and the other worlds behind LCM; journals every macro step to the orchestrator. Returns the exit
/// code of the run.
int drive_from_mbs(SideContext& context, std::unique_ptr<MbsSide> mbs);

}  // namespace tandem

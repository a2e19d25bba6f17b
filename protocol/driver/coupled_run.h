#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "protocol/driver/command_source.h"
#include "protocol/driver/metered_side.h"
#include "protocol/driver/run_report.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/schemes/coupling_params.h"
#include "protocol/schemes/scheme.h"
#include "protocol/wire/journal.h"

namespace tandem {

/// Takes the journal of each macro step, in order, macro step 0 (initialization) first.
class StepSink {
 public:
  virtual ~StepSink() = default;
  /// Returns the seconds it was blocked (credit of the recorder): booked as wait, the rest as
  /// record.
  virtual double record(wire::StepJournal journal) = 0;
  /// Waits for at most so many seconds in a run that is held to the wall clock; throws where the
  /// run is to end meanwhile.
  virtual void rest(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  }
};

/// A side and where it computes.
template <class Side>
struct PlacedSide {
  Side& side;
  Locality locality = Locality::Here;
};

using SchemeMaker = std::function<std::unique_ptr<Scheme>(std::vector<PortInfo> ports)>;

struct CoupledRunParams {
  scenario::RunParams run;
  CouplingParams coupling;
  std::string scheme_name;
  SchemeMaker make_scheme;
  CommandSource* commands = nullptr;    ///< commands to the flexible side; null: none come
  std::int64_t energy_every_steps = 0;  ///< both sides' energies go with every n-th step; 0: none
};

/// The run with the scheme that `coupling` names.
[[nodiscard]] CoupledRunParams scheme_run(const scenario::RunParams& run,
                                          const CouplingParams& coupling);

/// The stepping loop of every coupled run, whatever the transport:
///   m_0 = M.initialize(0); λ_0 = Λ.initialize(m_0)
///   for n = 1 … N:  commands to the flexible side; checkpoint both; scheme makes the macro step;
///   check divergence; record
///   checkpoint both, or roll both back where the last macro step was not accepted; observe both
/// The ports' lengths come from the flexible side. Throws only what the sides and the sink throw; a
/// numerical end is a status of the report, and every macro step made has been recorded.
[[nodiscard]] RunReport run_coupled(const CoupledRunParams& params, PlacedSide<MbsSide> mbs,
                                    PlacedSide<FemSide> fem, StepSink& sink);

}  // namespace tandem

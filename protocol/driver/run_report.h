#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contract/ledger.h"
#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"
#include "protocol/contract/subsystem.h"
#include "protocol/driver/energy_range.h"
#include "protocol/driver/pace.h"
#include "protocol/wire/journal.h"

namespace tandem {

/// How a run ended. Reaching an iteration cap, leaving the solution and a broken side are told
/// apart.
enum class RunStatus { Done, NotConverged, Diverged, SolverFailed };

/// The numbers of one coupled run, as the driver of the scheme knows them.
struct RunReport {
  RunStatus status = RunStatus::Done;
  /// The driver could not end the run (interrupted, a process failed): what only the end tells is
  /// not known, i.e. the sides' energies, the state's hash the rejected steps and
  /// those beyond the tolerance.
  bool broken_off = false;
  std::string message;  ///< empty when Done; else cause, place and remedy
  std::string scheme;
  std::int64_t macro_steps = 0;  ///< accepted
  SimTime simulated{};
  double wall_s = 0.0;  ///< of the stepping loop
  std::int64_t iterations_total = 0;
  std::int64_t iterations_max = 0;
  std::int64_t not_converged_steps = 0;
  std::string not_converged_message;        ///< of the first of them
  std::int64_t steps_out_of_budget = 0;     ///< ended by coupling.max_evaluations
  std::int64_t rejected_steps = 0;          ///< macro steps made again with a shorter one
  std::int64_t steps_beyond_tolerance = 0;  ///< adaptive ones that could not be made shorter
  double elastic_turn_rad = 0.0;            ///< largest, of a linear body; see Observation
  double residual_max_N = 0.0;  ///< that an accepted macro step of an iterating scheme has left
  double wrench_max_N = 0.0;    ///< norm of the largest accepted wrench
  JointGap widest_joint;        ///< largest part of its arm, at some times of the run
  std::optional<double> parasitic_mass_kg;  ///< of the line at each port, with tlm (largest)
  Ledger ledger;
  PaceReport pace;  ///< of runs that are held to the wall clock
  std::vector<double>
      exchange_us;  ///< per macro step: transfer time / exchanges (sorted at the end)
  double interface_defect_max_J = 0.0;  ///< largest |δE| of a macro step
  double interface_defect_sum_J = 0.0;  ///< Σ δE: net energy created by the interface
  double exchanged_work_J = 0.0;        ///< Σ H |λ·V|: what passed the interface, either way
  EnergyRange energy_range;             ///< at some times of the run
  double still_J = 0.0;                 ///< energies below this are round-off of a model at rest
  double largest_turn_rad = 0.0;        ///< that a port has made in a macro step
  std::string turning_port;             ///< that port
  SimTime largest_step{};               ///< H
  SideEnergies energy_start;
  SideEnergies energy_end;                                ///< of the last accepted state
  std::uint64_t state_hash = 0;                           ///< likewise
  std::vector<BodyObservation> bodies_start, bodies_end;  ///< of several flexible bodies, likewise
  std::vector<BodyObservation> worlds_start, worlds_end;  ///< of several multibody worlds, likewise
  std::vector<std::string> port_names;
  MotionSet motions;   ///< at the end
  WrenchSet wrenches;  ///< at the end

  /// Books what a macro step took, accepted or not: iterations and transfer time. Ledger and
  /// accepted state are the caller's to add.
  void book(const wire::StepRecord& step);

  /// Books that H was taken and how far the ports have turned in it, by their rates at its ends.
  void book_turn(SimTime H, const MotionSet& begin, const MotionSet& end);

  /// Books what the interface did in an accepted macro step: δE and H |λ·V|.
  void book_interface(double defect_J, double exchanged_J);

  [[nodiscard]] int exit_code() const { return status == RunStatus::Done ? 0 : 3; }
};

[[nodiscard]] std::string to_string(RunStatus status);

/// The keys of summary.json that the driver knows (units in the names). Dissipated energy is what
/// both sides booked, damping + numerical; balance_error is what the balance of all booked terms
/// lacks: see balance_error_J.
[[nodiscard]] nlohmann::ordered_json to_json(const RunReport& report);

}  // namespace tandem

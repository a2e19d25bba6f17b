#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/contract/cost.h"
#include "protocol/contract/energy.h"
#include "protocol/contract/port.h"
#include "protocol/contract/segment.h"
#include "protocol/contract/sim_time.h"

namespace tandem {

struct SubsystemInfo {
  std::string name;             ///< "mbs" or "fem"
  std::vector<PortInfo> ports;  ///< in the order of the scenario's port table
  SimTime micro_step{};        ///< the side's own integration step h, H = n h; 0: h = H, whatever H
  bool can_linearize = false;  ///< whether advance() honours `linearize`
};

/// d out / d in(end of segment) at the last advance, from the state at its beginning.
///   multibody side: 12P × 6P, rows as difference(), columns as stack()
///   flexible side:   6P × 12P, rows as stack(), columns as difference()
using InterfaceJacobian = Eigen::MatrixXd;

/// How an advance ended. An iteration cap that is reached is NotConverged, never Done.
enum class Outcome : std::int8_t {
  Done = 0,          ///< output is good
  NotConverged = 1,  ///< budget spent, output is there but not to tolerance
  Failed = 2,        ///< output is unusable; the state is that before the call
};

/// One macro step's order to a side.
template <class In>
struct StepRequest {
  SimTime step{};          ///< H, a whole multiple of the side's micro step
  Segment<In> input;       ///< at both ends of the step
  bool linearize = false;  ///< also return the interface Jacobian
};

template <class Out>
struct StepResult {
  Outcome outcome = Outcome::Failed;
  std::string message = "advance was not called";  ///< empty when Done
  Out output;                                      ///< at the end of the step
  /// What of it is the side's own where more was put into it (CounterInertia): what tolerances are
  /// relative to. Empty: all of it.
  Out own;
  std::optional<InterfaceJacobian> jacobian;  ///< when asked for and possible
  /// Norm of what the side's own solver has left of its equations, in the unit of the output's
  /// forces (N): the output is known to about this. 0: to round-off.
  double output_error_N = 0.0;
  std::int32_t solver_iterations = 0;  ///< inner iterations (PCG, Newton), 0 for direct
  CallCost cost;                       ///< where the time of this call went
};

/// How far a joint of the multibody side has come apart.
struct JointGap {
  double gap_m = 0.0;
  double part = 0.0;        ///< of the joint's arm
  std::int32_t joint = -1;  ///< in the order of the scenario; -1: none has
  std::int32_t world = 0;   ///< that holds it, of several
};

/// One of several flexible bodies or multibody worlds: its book and state at the time of the
/// observation.
struct BodyObservation {
  std::string name;
  EnergyBook energy;
  std::uint64_t state_hash = 0;
  double compute_s = 0.0;              ///< of all its advances since t = 0
  std::int64_t solver_iterations = 0;  ///< likewise
};

struct Observation {
  SimTime time{};
  EnergyBook energy;
  std::uint64_t state_hash = 0;  ///< of every bit that influences the future
  /// Largest elastic turn of an element since t = 0 (rad), of a body whose shapes add up linearly
  /// and which is therefore good for small ones only; 0: any turn is right.
  double elastic_turn_rad = 0.0;
  JointGap widest_joint;
  std::vector<BodyObservation> bodies;  ///< of several flexible ones, or of several worlds
};

/// How a side took a command.
struct CommandResult {
  bool accepted = false;
  std::string message;  ///< what was done, or why not
  CallCost cost;
};

/// One of the two sides of a coupled run. Causality is in the types: the multibody side maps
/// wrenches to motions, the flexible side maps motions to wrenches. A scheme cannot tell whether a
/// side is a local object, a proxy to a process, a recorded log or a mock.
///
/// Order of calls: info() any time; initialize() once; then for each macro step checkpoint(), and
/// one or more advance() with rollback() before each repetition; a last checkpoint() after the last
/// step. A side may act on accepted states (write files) in checkpoint(): the state then is final.
/// Errors of use and of transport throw tandem::Error; numerical ends are values in StepResult.
template <class In, class Out>
class Subsystem {
 public:
  virtual ~Subsystem() = default;

  [[nodiscard]] virtual const SubsystemInfo& info() const = 0;

  /// Consistent output at t = 0 for the given input.
  virtual Out initialize(const In& input) = 0;

  /// Advances the state by request.step. When Failed the state does not move.
  virtual StepResult<Out> advance(const StepRequest<In>& request) = 0;

  /// advance() in two halves, so that two sides can compute at the same time: a side in another
  /// process starts at begin_advance(), a side of this process computes in finish_advance(). No
  /// other call to this side may come between them.
  virtual void begin_advance(const StepRequest<In>& request) { begun_ = request; }
  virtual StepResult<Out> finish_advance() {
    return advance(std::exchange(begun_, std::nullopt).value());
  }

  /// Saves the complete and exact state; everything before it is accepted.
  virtual void checkpoint() = 0;

  /// Restores the last checkpoint bit for bit, any number of times.
  virtual void rollback() = 0;

  /// A change of the accepted state from outside, between macro steps: right before a checkpoint().
  /// What a side understands is its own; a refused command changes nothing.
  virtual CommandResult command(const std::string& text) {
    return {.message = info().name + ": takes no commands, not '" + text + "'.", .cost = {}};
  }

  /// Energies and state hash of the present state; changes nothing.
  virtual Observation observe() = 0;

 private:
  std::optional<StepRequest<In>> begun_;
};

using MbsSide = Subsystem<WrenchSet, MotionSet>;
using FemSide = Subsystem<MotionSet, WrenchSet>;

}  // namespace tandem

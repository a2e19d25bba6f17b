#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/wire/call_times.h"

namespace tandem {

/// One flexible body of several: its side, and where its ports stand in the table of all.
struct FemPart {
  std::string name;
  std::unique_ptr<FemSide> side;
  std::vector<std::size_t> ports;
  double compute_s = 0.0;              ///< of all advances
  std::int64_t solver_iterations = 0;  ///< likewise
};

/// Several flexible bodies as one flexible side, so that schemes, journal and monolithic step know
/// of one. Motions are scattered to the bodies, which compute at the same time where they are
/// processes; wrenches are gathered, and everything summed, in the order of the parts, whoever
/// answers first. What one body's ports do to another's is zero:
///   Λ(m) = [Λ_1(m_1) | Λ_2(m_2) | …],   ∂Λ/∂m block diagonal.
/// A macro step that one body fails is rolled back by all. Energies are sums; the state hash is
/// that of the parts' hashes. A command begins with the name of its body: "conrod fix HUB".
class CompositeFem final : public FemSide, public wire::TimedCalls {
 public:
  /// Every port of 0 … n−1 belongs to one part.
  explicit CompositeFem(std::vector<FemPart> parts);

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override;
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override;
  void begin_advance(const StepRequest<MotionSet>& request) override;
  StepResult<WrenchSet> finish_advance() override;
  void checkpoint() override;
  void rollback() override;
  CommandResult command(const std::string& text) override;
  Observation observe() override;

  /// One entry a part, in their order; of a command that of the part alone.
  void append_times(std::vector<wire::PartTimes>& to) const override;

  [[nodiscard]] const std::vector<FemPart>& parts() const { return parts_; }

 private:
  void gather(const FemPart& part, StepResult<WrenchSet>& from, StepResult<WrenchSet>& all) const;

  std::vector<FemPart> parts_;
  SubsystemInfo info_;
  bool linearizes_ = false;             ///< the advance that has begun
  std::vector<wire::PartTimes> times_;  ///< of the last call
};

/// The parts as one side: a single one as it is.
[[nodiscard]] std::unique_ptr<FemSide> composed(std::vector<FemPart> parts);

/// What belongs to a part of a set with an entry a port.
template <class Set>
[[nodiscard]] Set of_ports(const Set& all, const std::vector<std::size_t>& ports) {
  Set own;
  if (all.empty()) return own;
  own.reserve(ports.size());
  for (const std::size_t port : ports) own.push_back(all[port]);
  return own;
}

}  // namespace tandem

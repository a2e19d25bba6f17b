#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "protocol/contract/subsystem.h"
#include "protocol/wire/call_times.h"

namespace tandem {

/// One flexible body of several, or one multibody world: its side, and where its ports stand in the
/// table of all.
template <class In, class Out>
struct SidePart {
  std::string name;
  std::unique_ptr<Subsystem<In, Out>> side;
  std::vector<std::size_t> ports;
  double compute_s = 0.0;              ///< of all advances
  std::int64_t solver_iterations = 0;  ///< likewise
};

/// Several flexible bodies as one flexible side, or several multibody worlds as one multibody side,
/// so that schemes, journal and monolithic step know of one. Inputs are scattered to the parts,
/// which compute at the same time where they are processes; outputs are gathered, and everything
/// summed, in the order of the parts, whoever answers first. What one part's ports do to another's
/// is zero:
///   Λ(m) = [Λ_1(m_1) | Λ_2(m_2) | …],   ∂Λ/∂m block diagonal by body,
///   M(λ) = [M_1(λ_1) | M_2(λ_2) | …],   ∂M/∂λ block diagonal by world.
/// A macro step that one part fails is rolled back by all. Energies are sums; the state hash is
/// that of the parts' hashes. A command begins with the name of its flexible body:
/// "conrod fix HUB"; worlds take none.
template <class In, class Out>
class CompositeSide final : public Subsystem<In, Out>, public wire::TimedCalls {
 public:
  using Part = SidePart<In, Out>;

  /// Every port of 0 … n−1 belongs to one part.
  explicit CompositeSide(std::vector<Part> parts);

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  Out initialize(const In& input) override;
  StepResult<Out> advance(const StepRequest<In>& request) override;
  void begin_advance(const StepRequest<In>& request) override;
  StepResult<Out> finish_advance() override;
  void checkpoint() override;
  void rollback() override;
  CommandResult command(const std::string& text) override;
  Observation observe() override;

  /// One entry a part, in their order; of a command that of the part alone.
  void append_times(std::vector<wire::PartTimes>& to) const override;

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }

 private:
  void gather(const Part& part, StepResult<Out>& from, StepResult<Out>& all) const;

  std::vector<Part> parts_;
  SubsystemInfo info_;
  bool linearizes_ = false;             ///< the advance that has begun
  std::vector<wire::PartTimes> times_;  ///< of the last call
};

using FemPart = SidePart<MotionSet, WrenchSet>;
using MbsPart = SidePart<WrenchSet, MotionSet>;
using CompositeFem = CompositeSide<MotionSet, WrenchSet>;
using CompositeMbs = CompositeSide<WrenchSet, MotionSet>;

/// The parts as one side: a single one as it is.
template <class In, class Out>
[[nodiscard]] std::unique_ptr<Subsystem<In, Out>> composed(std::vector<SidePart<In, Out>> parts) {
  if (parts.size() == 1) return std::move(parts.front().side);
  return std::make_unique<CompositeSide<In, Out>>(std::move(parts));
}

/// What belongs to a part of a set with an entry a port.
template <class Set>
[[nodiscard]] Set of_ports(const Set& all, const std::vector<std::size_t>& ports) {
  Set own;
  if (all.empty()) return own;
  own.reserve(ports.size());
  for (const std::size_t port : ports) own.push_back(all[port]);
  return own;
}

extern template class CompositeSide<MotionSet, WrenchSet>;
extern template class CompositeSide<WrenchSet, MotionSet>;

}  // namespace tandem

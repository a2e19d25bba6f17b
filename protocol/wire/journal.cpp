#include "protocol/wire/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>

namespace tandem::wire {
namespace {

/// Whether input and output of a call have the sizes that its kind asks for.
template <class In, class Out>
bool fits(const CallRecord& call, const Segment<In>& input, const Segment<Out>& output,
          std::size_t ports, bool may_lack_begin) {
  const bool advances = call.kind == CallKind::Advance;
  const std::size_t given = call.kind == CallKind::Command ? 0 : ports;
  const std::size_t begins = advances ? ports : 0;
  // A side that failed may not have got as far as its output.
  const bool may_lack = advances && call.outcome == Outcome::Failed;
  const bool begin_fits = input.begin.size() == begins || (may_lack_begin && input.begin.empty());
  return begin_fits && input.end.size() == given && output.begin.empty() &&
         (output.end.size() == given || (may_lack && output.end.empty()));
}

/// Zero when both hold the same bits (−0 differs from 0, a NaN equals itself).
std::uint64_t differing_bits(std::span<const double> a, std::span<const double> b) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    bits |= std::bit_cast<std::uint64_t>(a[i]) ^ std::bit_cast<std::uint64_t>(b[i]);
  }
  return bits;
}

template <class Vector>
std::uint64_t differing_bits(const Vector& a, const Vector& b) {
  constexpr auto kSize = static_cast<std::size_t>(Vector::SizeAtCompileTime);
  return differing_bits(std::span(a.data(), kSize), std::span(b.data(), kSize));
}

std::uint64_t differing_bits(const Motion& a, const Motion& b) {
  return differing_bits(a.p_WP, b.p_WP) | differing_bits(a.q_WP.coeffs(), b.q_WP.coeffs()) |
         differing_bits(a.v_WP, b.v_WP) | differing_bits(a.w_WP, b.w_WP);
}

std::uint64_t differing_bits(const Wrench& a, const Wrench& b) {
  return differing_bits(a.f_P_W, b.f_P_W) | differing_bits(a.t_P_W, b.t_P_W);
}

template <class Set>
bool same_bits(const Set& a, const Set& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return differing_bits(x, y) == 0; });
}

/// Initialize and Advance have an input, which the side went on from when the call was accepted.
bool accepts_input(const CallRecord& call) {
  return call.accepted && call.kind != CallKind::Command;
}

}  // namespace

bool AcceptedInputs::is_begin_of(const CallRecord& call) const {
  if (call.kind != CallKind::Advance) return false;
  if (call.side == SideName::Mbs) {
    return !wrenches_.empty() && same_bits(call.wrenches.begin, wrenches_);
  }
  return !motions_.empty() && same_bits(call.motions.begin, motions_);
}

void AcceptedInputs::complete(CallRecord& call) const {
  if (call.kind != CallKind::Advance) return;
  if (call.side == SideName::Mbs && call.wrenches.begin.empty()) call.wrenches.begin = wrenches_;
  if (call.side == SideName::Fem && call.motions.begin.empty()) call.motions.begin = motions_;
}

void AcceptedInputs::follow(const CallRecord& call) {
  if (!accepts_input(call)) return;
  if (call.side == SideName::Mbs) wrenches_ = call.wrenches.end;
  if (call.side == SideName::Fem) motions_ = call.motions.end;
}

void AcceptedInputs::follow(CallRecord&& call) {
  if (!accepts_input(call)) return;
  if (call.side == SideName::Mbs) wrenches_ = std::move(call.wrenches.end);
  if (call.side == SideName::Fem) motions_ = std::move(call.motions.end);
}

std::string misfit(const CallRecord& call, std::size_t ports, bool may_lack_begin) {
  const bool good = call.side == SideName::Mbs
                        ? fits(call, call.wrenches, call.motions, ports, may_lack_begin)
                        : fits(call, call.motions, call.wrenches, ports, may_lack_begin);
  if (good) return {};
  return fmt::format(
      "a call of {} (macro step {}, iteration {}) holds {} and {} motions, {} and {} wrenches at "
      "its beginning and end; the run has {} ports",
      text_of(call.side), call.macro_step, call.iteration, call.motions.begin.size(),
      call.motions.end.size(), call.wrenches.begin.size(), call.wrenches.end.size(), ports);
}

std::size_t unrecorded_bytes(int receive_buffer_bytes) {
  constexpr int kAskedFor = 2 * 4194304;  // as the kernel counts it
  // It books some 67 kB for the 65 kB of a full part, and other messages come as well.
  return static_cast<std::size_t>(receive_buffer_bytes > 0 ? receive_buffer_bytes : kAskedFor) / 4 *
         3;
}

}  // namespace tandem::wire

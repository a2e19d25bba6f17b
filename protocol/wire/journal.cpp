#include "protocol/wire/journal.h"

#include <fmt/format.h>

namespace tandem::wire {
namespace {

/// Whether input and output of a call have the sizes that its kind asks for.
template <class In, class Out>
bool fits(const CallRecord& call, const Segment<In>& input, const Segment<Out>& output,
          std::size_t ports) {
  const bool advances = call.kind == CallKind::Advance;
  const std::size_t given = call.kind == CallKind::Command ? 0 : ports;
  const std::size_t begins = advances ? ports : 0;
  // A side that failed may not have got as far as its output.
  const bool may_lack = advances && call.outcome == Outcome::Failed;
  return input.begin.size() == begins && input.end.size() == given && output.begin.empty() &&
         (output.end.size() == given || (may_lack && output.end.empty()));
}

}  // namespace

std::string misfit(const CallRecord& call, std::size_t ports) {
  const bool good = call.side == SideName::Mbs ? fits(call, call.wrenches, call.motions, ports)
                                               : fits(call, call.motions, call.wrenches, ports);
  if (good) return {};
  return fmt::format(
      "a call of {} (macro step {}, iteration {}) holds {} and {} motions, {} and {} wrenches at "
      "its beginning and end; the run has {} ports",
      text_of(call.side), call.macro_step, call.iteration, call.motions.begin.size(),
      call.motions.end.size(), call.wrenches.begin.size(), call.wrenches.end.size(), ports);
}

std::size_t unrecorded_bytes(int receive_buffer_bytes) {
  constexpr int kAskedFor = 2 * 4194304;  // as the kernel counts it
  // It books some 65 KiB for the 59 kB of a full part, and other messages come as well.
  return static_cast<std::size_t>(receive_buffer_bytes > 0 ? receive_buffer_bytes : kAskedFor) / 4 *
         3;
}

}  // namespace tandem::wire

#include "protocol/wire/codec.h"

namespace tandem::wire::codec {
bool size_fits(ByteView message, std::size_t fixed_bytes,
               std::initializer_list<std::size_t> element_bytes) {
  if (message.size() < kHeaderEnd + 4 * element_bytes.size()) return false;
  std::size_t total = fixed_bytes;
  std::size_t n = 0;
  for (const std::size_t bytes : element_bytes) {
    const std::size_t elements = count_at(message, n++);
    if (elements > kMaxMessageBytes) return false;  // negative, as lcm-gen reads it, or absurd
    total += elements * bytes;
  }
  return total == message.size();
}

tandem_wire::header_t pack(const Header& header) {
  tandem_wire::header_t packed;
  packed.checksum = 0;  // written by seal()
  packed.run_id = static_cast<std::int64_t>(header.run_id);
  packed.sequence = header.sequence;
  packed.macro_step = header.macro_step;
  packed.iteration = header.iteration;
  packed.kind = static_cast<std::int32_t>(header.kind);
  packed.attempt = header.attempt;
  packed.sender = static_cast<std::int32_t>(header.sender);
  packed.time_us = header.time_us;
  return packed;
}

Header unpack(const tandem_wire::header_t& packed) {
  Header header;
  header.checksum = static_cast<std::uint32_t>(packed.checksum);
  header.run_id = static_cast<std::uint64_t>(packed.run_id);
  header.sequence = packed.sequence;
  header.macro_step = packed.macro_step;
  header.iteration = packed.iteration;
  header.kind = static_cast<Kind>(packed.kind);
  header.attempt = packed.attempt;
  header.sender = static_cast<Process>(packed.sender);
  header.time_us = packed.time_us;
  return header;
}

}  // namespace tandem::wire::codec

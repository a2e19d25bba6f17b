#include <tandem_wire/chunk_t.hpp>
#include <tandem_wire/missing_t.hpp>

#include "protocol/wire/codec.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

using codec::count;
using codec::count_at;
using codec::from_bytes;
using codec::pack;
using codec::to_bytes;
using codec::unpack;

void encode_head(const Chunk& chunk, std::size_t size, std::span<std::uint8_t, kChunkHead> head) {
  tandem_wire::chunk_t fixed{};
  fixed.header = pack(chunk.header);
  fixed.whole_kind = static_cast<std::int32_t>(chunk.whole_kind);
  fixed.whole_checksum = static_cast<std::int32_t>(chunk.whole_checksum);
  fixed.whole_bytes = chunk.whole_bytes;
  fixed.index = chunk.index;
  fixed.count = chunk.count;
  fixed.ends_burst = chunk.ends_burst ? 1 : 0;
  fixed.encode(head.data(), 0, static_cast<int>(head.size()));
  codec::write_counts({{size, 1}}, head.data());
}

std::optional<Chunk> decode_chunk(ByteView message) {
  const auto fixed = codec::fixed_part<tandem_wire::chunk_t>(message, {1});
  if (!fixed) return std::nullopt;
  Chunk chunk;
  chunk.header = unpack(fixed->header);
  chunk.whole_kind = static_cast<Kind>(fixed->whole_kind);
  chunk.whole_checksum = static_cast<std::uint32_t>(fixed->whole_checksum);
  chunk.whole_bytes = fixed->whole_bytes;
  chunk.index = fixed->index;
  chunk.count = fixed->count;
  chunk.ends_burst = fixed->ends_burst != 0;
  chunk.bytes = message.last(count_at(message, 0));
  return chunk;
}

Bytes encode(const Missing& missing) {
  tandem_wire::missing_t packed;
  packed.header = pack(missing.header);
  packed.whole_kind = static_cast<std::int32_t>(missing.whole_kind);
  packed.whole_checksum = static_cast<std::int32_t>(missing.whole_checksum);
  packed.wanted = missing.wanted;
  packed.n_wanted = count(packed.wanted);
  return to_bytes(packed);
}

std::optional<Missing> decode_missing(ByteView message) {
  const auto packed = from_bytes(message, tandem_wire::missing_t{}, {4});
  if (!packed) return std::nullopt;
  return Missing{.header = unpack(packed->header),
                 .whole_kind = static_cast<Kind>(packed->whole_kind),
                 .whole_checksum = static_cast<std::uint32_t>(packed->whole_checksum),
                 .wanted = packed->wanted};
}

}  // namespace tandem::wire

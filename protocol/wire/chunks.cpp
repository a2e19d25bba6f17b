#include "protocol/wire/chunks.h"

#include <algorithm>

namespace tandem::wire {
namespace {

constexpr std::size_t kChunkData = 59000;
constexpr std::size_t kMaxMessage = 64U << 20U;

}  // namespace

std::vector<Bytes> cut(const Bytes& message, std::int32_t attempt) {
  const auto header = open_seal(message);
  require(header.has_value() && message.size() <= kMaxMessage,
          "wire: a message of " + std::to_string(message.size()) +
              " bytes cannot be sent: it is not sealed or larger than 64 MiB");
  Chunk chunk;
  chunk.header = *header;
  chunk.header.kind = Kind::Chunk;
  chunk.whole_kind = header->kind;
  chunk.whole_checksum = header->checksum;
  chunk.whole_bytes = static_cast<std::int32_t>(message.size());
  chunk.count = static_cast<std::int32_t>((message.size() + kChunkData - 1) / kChunkData);
  std::vector<Bytes> parts;
  for (std::size_t begin = 0; begin < message.size(); begin += kChunkData) {
    const std::size_t size = std::min(kChunkData, message.size() - begin);
    chunk.bytes.assign(message.data() + begin, message.data() + begin + size);
    parts.push_back(encode(chunk));
    seal(parts.back(), attempt);
    ++chunk.index;
  }
  return parts;
}

std::optional<Bytes> Assembler::add(const Chunk& chunk) {
  // Sizes follow from the size of the whole: whatever does not fit is not one of ours.
  if (chunk.whole_bytes <= 0) return std::nullopt;
  const auto whole = static_cast<std::size_t>(chunk.whole_bytes);
  const std::size_t count = (whole + kChunkData - 1) / kChunkData;
  if (whole > kMaxMessage || chunk.count < 0 || static_cast<std::size_t>(chunk.count) != count ||
      chunk.index < 0 || static_cast<std::size_t>(chunk.index) >= count) {
    return std::nullopt;
  }
  const auto index = static_cast<std::size_t>(chunk.index);
  const std::size_t begin = index * kChunkData;
  if (chunk.bytes.size() != std::min(kChunkData, whole - begin)) return std::nullopt;

  Open& message = entry(chunk);
  if (message.here[index]) return std::nullopt;
  std::copy(chunk.bytes.begin(), chunk.bytes.end(),
            message.bytes.begin() + static_cast<std::ptrdiff_t>(begin));
  message.here[index] = true;
  if (--message.missing > 0) return std::nullopt;
  Bytes done = std::move(message.bytes);
  open_.erase(std::find_if(open_.begin(), open_.end(),
                           [&](const Open& other) { return &other == &message; }));
  return done;
}

Assembler::Open& Assembler::entry(const Chunk& chunk) {
  const auto whole = static_cast<std::size_t>(chunk.whole_bytes);
  const auto found = std::find_if(open_.begin(), open_.end(), [&](const Open& other) {
    return other.sender == chunk.header.sender && other.kind == chunk.whole_kind &&
           other.sequence == chunk.header.sequence && other.checksum == chunk.whole_checksum &&
           other.bytes.size() == whole;
  });
  if (found != open_.end()) return *found;
  if (open_.size() >= kMaxOpen) open_.pop_front();
  const auto count = static_cast<std::size_t>(chunk.count);
  return open_.emplace_back(Open{chunk.header.sender, chunk.whole_kind, chunk.header.sequence,
                                 chunk.whole_checksum, Bytes(whole), std::vector<bool>(count),
                                 count});
}

}  // namespace tandem::wire

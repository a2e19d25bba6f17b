#include "protocol/wire/chunks.h"

#include <algorithm>
#include <array>
#include <utility>

#include "protocol/wire/crc32.h"

namespace tandem::wire {
namespace {

constexpr std::size_t kChunkData = 59000;
constexpr std::size_t kMaxMessage = 64U << 20U;

}  // namespace

namespace {

/// CRC-32 of each part and of the whole.
std::vector<std::uint32_t> checksums_of(ByteView message, std::uint32_t& whole) {
  std::vector<std::uint32_t> parts;
  whole = 0;
  for (std::size_t begin = 0; begin < message.size(); begin += kChunkData) {
    const std::size_t size = std::min(kChunkData, message.size() - begin);
    parts.push_back(crc32(0, message.subspan(begin, size)));
    whole = crc32_joined(whole, parts.back(), size);
  }
  return parts;
}

}  // namespace

void cut(Bytes& message, std::int32_t attempt, const std::function<void(ByteView)>& send) {
  require(message.size() >= kHeaderEnd && message.size() <= kMaxMessage,
          "wire: a message of " + std::to_string(message.size()) +
              " bytes cannot be sent: it is larger than 64 MiB");
  Chunk chunk;
  chunk.header = header_of(message);
  chunk.whole_kind = chunk.header.kind;
  chunk.header.kind = Kind::Chunk;
  chunk.whole_bytes = static_cast<std::int32_t>(message.size());
  set_checksum(message, 0);
  const std::vector<std::uint32_t> checksums = checksums_of(message, chunk.whole_checksum);
  chunk.count = static_cast<std::int32_t>(checksums.size());
  std::array<std::uint8_t, kChunkHead> head{};
  std::array<std::uint8_t, kChunkHead> covered{};
  for (const std::uint32_t checksum : checksums) {
    const std::size_t begin = static_cast<std::size_t>(chunk.index) * kChunkData;
    const std::size_t size = std::min(kChunkData, message.size() - begin);
    encode_head(chunk, size, head);
    seal(head, attempt, checksum, size);
    if (begin == 0) {
      Bytes first(head.begin(), head.end());
      first.insert(first.end(), message.begin(),
                   message.begin() + static_cast<std::ptrdiff_t>(size));
      send(first);
    } else {
      std::uint8_t* at = message.data() + begin - kChunkHead;
      std::copy_n(at, kChunkHead, covered.begin());
      std::copy_n(head.begin(), kChunkHead, at);
      send({at, kChunkHead + size});
      std::copy_n(covered.begin(), kChunkHead, at);
    }
    ++chunk.index;
  }
}

std::optional<ByteView> Assembler::add(const Chunk& chunk) {
  // Sizes follow from the size of the whole: whatever does not fit is not one of ours.
  if (chunk.whole_bytes < static_cast<std::int32_t>(kHeaderEnd)) return std::nullopt;
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
  std::copy(chunk.bytes.begin(), chunk.bytes.end(), message.memory.bytes.get() + begin);
  message.here[index] = true;
  if (--message.missing > 0) return std::nullopt;
  spare_ = std::exchange(whole_, std::move(message.memory));
  open_.erase(std::find_if(open_.begin(), open_.end(),
                           [&](const Open& other) { return &other == &message; }));
  set_checksum({whole_.bytes.get(), whole}, chunk.whole_checksum);
  return ByteView(whole_.bytes.get(), whole);
}

Assembler::Open& Assembler::entry(const Chunk& chunk) {
  const auto whole = static_cast<std::size_t>(chunk.whole_bytes);
  const auto found = std::find_if(open_.begin(), open_.end(), [&](const Open& other) {
    return other.sender == chunk.header.sender && other.kind == chunk.whole_kind &&
           other.sequence == chunk.header.sequence && other.checksum == chunk.whole_checksum &&
           other.size == whole;
  });
  if (found != open_.end()) return *found;
  const auto total = [this] {
    std::size_t sum = 0;
    for (const Open& open : open_) sum += open.size;
    return sum;
  };
  while (open_.size() >= kMaxOpen || total() + whole > 2 * kMaxMessage) open_.pop_front();
  const auto count = static_cast<std::size_t>(chunk.count);
  // Not filled: what a message claims to be takes no memory before its parts are here.
  Memory memory = std::exchange(spare_, {});
  if (memory.capacity < whole) {
    memory = {std::make_unique_for_overwrite<std::uint8_t[]>(whole), whole};
  }
  return open_.emplace_back(Open{chunk.header.sender, chunk.whole_kind, chunk.header.sequence,
                                 chunk.whole_checksum, whole, std::move(memory),
                                 std::vector<bool>(count), count});
}

}  // namespace tandem::wire

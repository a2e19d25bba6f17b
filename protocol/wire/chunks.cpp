#include "protocol/wire/chunks.h"

#include <algorithm>
#include <utility>

namespace tandem::wire {

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

  const Key key{chunk.header.sender, chunk.whole_kind, chunk.header.sequence, chunk.whole_checksum,
                whole};
  if (whole_key_ == key) {
    if (index != 0 || !chunk.ends_burst) return std::nullopt;
    return ByteView(*whole_);
  }
  last_ = key;
  Open& message = entry(key, count);
  if (message.here[index]) return std::nullopt;
  std::copy(chunk.bytes.begin(), chunk.bytes.end(), message.memory->data() + begin);
  message.here[index] = true;
  if (--message.missing > 0) return std::nullopt;
  spare_ = std::exchange(whole_, std::move(message.memory));
  whole_key_ = std::exchange(last_, std::nullopt);
  open_.erase(std::find_if(open_.begin(), open_.end(),
                           [&](const Open& other) { return &other == &message; }));
  set_checksum(*whole_, chunk.whole_checksum);
  return ByteView(*whole_);
}

std::optional<Assembler::Lacking> Assembler::lacks(std::size_t most) const {
  const auto open = std::find_if(open_.begin(), open_.end(),
                                 [this](const Open& other) { return last_ == other.key; });
  if (open == open_.end()) return std::nullopt;
  Lacking request;
  request.sender = open->key.sender;
  request.missing.header.sequence = open->key.sequence;
  request.missing.whole_kind = open->key.kind;
  request.missing.whole_checksum = open->key.checksum;
  for (std::size_t i = 0; i < open->here.size() && request.missing.wanted.size() < most; ++i) {
    if (!open->here[i]) request.missing.wanted.push_back(static_cast<std::int32_t>(i));
  }
  return request;
}

Assembler::Open& Assembler::entry(const Key& key, std::size_t count) {
  const auto found =
      std::find_if(open_.begin(), open_.end(), [&](const Open& other) { return other.key == key; });
  if (found != open_.end()) return *found;
  const auto total = [this] {
    std::size_t sum = 0;
    for (const Open& open : open_) sum += open.key.size;
    return sum;
  };
  while (open_.size() >= kMaxOpen || total() + key.size > 2 * kMaxMessage) open_.pop_front();
  // Not filled: what a message claims to be takes no memory before its parts are here.
  std::shared_ptr<Bytes> memory = std::exchange(spare_, {});
  if (!memory || memory.use_count() > 1) memory = std::make_shared<Bytes>();
  memory->clear();  // nothing to be taken along into larger memory
  memory->resize(key.size);
  return open_.emplace_back(Open{key, std::move(memory), std::vector<bool>(count), count});
}

}  // namespace tandem::wire

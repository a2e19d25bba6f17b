#include "protocol/wire/chunks_sent.h"

#include <algorithm>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/wire/chunks.h"
#include "protocol/wire/crc32.h"

namespace tandem::wire {
namespace {

// The kernel books some 67 kB for a datagram of a full part.
constexpr int kBookedBytes = 70000;

}  // namespace

std::size_t burst_of(int receive_buffer_bytes) {
  if (receive_buffer_bytes <= 0) return 8;
  return static_cast<std::size_t>(std::max(1, receive_buffer_bytes / kBookedBytes / 2));
}

SentMessage::SentMessage(ByteView message, Bytes memory) : message_(std::move(memory)) {
  require(message.size() >= kHeaderEnd && message.size() <= kMaxMessage,
          "wire: a message of " + std::to_string(message.size()) +
              " bytes cannot be sent: it is larger than 64 MiB");
  header_ = header_of(message);
  message_.clear();  // nothing to be taken along into larger memory
  message_.resize(kChunkHead + message.size());
  const std::span<std::uint8_t> copy = std::span(message_).subspan(kChunkHead);
  // Part by part: what was just copied is still in the cache when its checksum is taken.
  for (std::size_t begin = 0; begin < copy.size(); begin += kChunkData) {
    const std::span<std::uint8_t> part =
        copy.subspan(begin, std::min(kChunkData, copy.size() - begin));
    std::copy_n(message.begin() + static_cast<std::ptrdiff_t>(begin), part.size(), part.begin());
    if (begin == 0) set_checksum(part, 0);
    checksums_.push_back(crc32(0, part));
    checksum_ = crc32_joined(checksum_, checksums_.back(), part.size());
  }
}

bool SentMessage::is(const Missing& missing) const {
  return header_.kind == missing.whole_kind && header_.sequence == missing.header.sequence &&
         checksum_ == missing.whole_checksum;
}

void SentMessage::send(std::size_t index, bool ends_burst, std::int32_t attempt, const Send& send) {
  Chunk chunk;
  chunk.header = header_;
  chunk.header.kind = Kind::Chunk;
  chunk.whole_kind = header_.kind;
  chunk.whole_checksum = checksum_;
  chunk.whole_bytes = static_cast<std::int32_t>(bytes());
  chunk.index = static_cast<std::int32_t>(index);
  chunk.count = static_cast<std::int32_t>(checksums_.size());
  chunk.ends_burst = ends_burst;
  const std::size_t begin = index * kChunkData;
  const std::size_t size = std::min(kChunkData, bytes() - begin);
  std::array<std::uint8_t, kChunkHead> head{};
  encode_head(chunk, size, head);
  seal(head, attempt, checksums_[index], size);
  std::array<std::uint8_t, kChunkHead> covered{};
  std::uint8_t* at = message_.data() + begin;
  std::copy_n(at, kChunkHead, covered.begin());
  std::copy_n(head.begin(), kChunkHead, at);
  send({at, kChunkHead + size});
  std::copy_n(covered.begin(), kChunkHead, at);
}

SentMessages::Entry& SentMessages::keep(const std::string& channel, ByteView message) {
  const Header header = header_of(message);
  const std::int64_t sequence = header.sequence;
  // Who sends the next request or reply has heard that the last one was taken in whole.
  const bool one_open = header.kind == Kind::Request || header.kind == Kind::Reply;
  const std::size_t most = one_open ? 1 : kMost;
  Bytes memory;
  std::size_t total = message.size();
  std::size_t of_channel = 0;
  for (const Entry& entry : entries_) {
    total += entry.message.bytes();
    of_channel += entry.channel == channel ? 1 : 0;
  }
  // The memory of one that goes serves the new one: those of a channel are much alike in size.
  const auto drop = [&](const auto& which) {
    const auto entry = std::find_if(entries_.begin(), entries_.end(), which);
    if (entry == entries_.end()) return;
    total -= entry->message.bytes();
    memory = entry->message.release();
    entries_.erase(entry);
  };
  drop([&](const Entry& entry) {
    return entry.channel == channel && entry.message.header().sequence == sequence;
  });
  if (memory.empty() && of_channel >= most) {
    drop([&](const Entry& entry) { return entry.channel == channel; });
  }
  while (!entries_.empty() && total > kMostBytes) drop([](const Entry&) { return true; });
  return entries_.emplace_back(Entry{channel, SentMessage(message, std::move(memory))});
}

SentMessages::Entry* SentMessages::find(const Missing& missing) {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.message.is(missing); });
  return found == entries_.end() ? nullptr : &*found;
}

}  // namespace tandem::wire

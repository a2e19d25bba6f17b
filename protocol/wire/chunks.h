#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Messages up to this size go in one datagram (LCM's limit is 65,499 bytes with the channel).
inline constexpr std::size_t kMaxWhole = 60000;

/// Cuts an encoded message into sealed chunk messages of at most kMaxWhole bytes each and hands
/// each to `send`. Cutting the same message again gives the same bytes but for `attempt`. The
/// message's own checksum is written into each chunk and is zero in the message itself. A part is
/// sent from where it lies in the message, behind a header that stands there meanwhile.
void cut(Bytes& message, std::int32_t attempt, const std::function<void(ByteView)>& send);

/// Puts chunks together again, in any order, repeated or interleaved with those of other messages.
/// Chunks of a repetition of the same message complete each other. Memory is bounded by what has
/// come in, and by 128 MiB: messages have at most 64 MiB, and the oldest unfinished one is given up
/// for a new one when there are kMaxOpen, or they claim more than that together.
class Assembler {
 public:
  static constexpr std::size_t kMaxOpen = 8;

  /// The whole message, with its checksum in place, once its last part is here. It lives until the
  /// next call. Each chunk has a seal of its own: the whole need not be checked once more.
  [[nodiscard]] std::optional<ByteView> add(const Chunk& chunk);

 private:
  struct Memory {
    std::unique_ptr<std::uint8_t[]> bytes;
    std::size_t capacity = 0;
  };
  struct Open {
    Process sender{};
    Kind kind{};
    std::int64_t sequence = 0;
    std::uint32_t checksum = 0;
    std::size_t size = 0;
    Memory memory;
    std::vector<bool> here;
    std::size_t missing = 0;
  };
  Open& entry(const Chunk& chunk);

  std::deque<Open> open_;
  Memory whole_;  ///< the message handed out
  Memory spare_;  ///< of the one before
};

}  // namespace tandem::wire

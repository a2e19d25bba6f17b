#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Messages up to this size go in one datagram (LCM's limit is 65,499 bytes with the channel).
inline constexpr std::size_t kMaxWhole = 60000;

/// Cuts a sealed message into sealed chunk messages of at most kMaxWhole bytes each.
[[nodiscard]] std::vector<Bytes> cut(const Bytes& message, std::int32_t attempt = 0);

/// Puts chunks together again, in any order, repeated or interleaved with those of other messages.
/// Chunks of a repetition of the same message complete each other. Memory is bounded: messages of
/// at most 64 MiB, the oldest of kMaxOpen unfinished ones is given up.
class Assembler {
 public:
  static constexpr std::size_t kMaxOpen = 8;

  /// The whole message (its own seal still to be opened) once its last part is here.
  [[nodiscard]] std::optional<Bytes> add(const Chunk& chunk);

 private:
  struct Open {
    Process sender{};
    Kind kind{};
    std::int64_t sequence = 0;
    std::uint32_t checksum = 0;
    Bytes bytes;
    std::vector<bool> here;
    std::size_t missing = 0;
  };
  Open& entry(const Chunk& chunk);

  std::deque<Open> open_;
};

}  // namespace tandem::wire

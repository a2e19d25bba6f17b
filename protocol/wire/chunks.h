#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Bytes of the whole in each chunk but the last one, and the largest whole. Together with the head
/// and a channel's name below what LCM puts into one datagram (65,499 bytes).
inline constexpr std::size_t kChunkData = 65200;
inline constexpr std::size_t kMaxMessage = 64U << 20U;

/// Puts chunks together again, in any order, repeated or interleaved with those of other messages.
/// Chunks of a repetition of the same message complete each other. Memory is bounded by what has
/// come in, and by 128 MiB: messages have at most 64 MiB, and the oldest unfinished one is given up
/// for a new one when there are kMaxOpen, or they claim more than that together.
class Assembler {
 public:
  static constexpr std::size_t kMaxOpen = 8;

  /// The whole message, with its checksum in place, once its last part is here. It lives until the
  /// next call. Each chunk has a seal of its own: the whole need not be checked once more. The
  /// first part alone of the message handed out last is its sender's repetition: it is handed out
  /// again.
  [[nodiscard]] std::optional<ByteView> add(const Chunk& chunk);

  /// The message that add() handed out last, for those who need it for longer: its memory is then
  /// not used again.
  [[nodiscard]] const std::shared_ptr<Bytes>& whole() const { return whole_; }

  /// What is missing of the message to which a chunk was added last, at most so many parts; nothing
  /// when it is whole. The header is the caller's to fill in.
  struct Lacking {
    Process sender{};
    Missing missing;
  };
  [[nodiscard]] std::optional<Lacking> lacks(std::size_t most) const;

 private:
  /// What tells one message from another.
  struct Key {
    Process sender{};
    Kind kind{};
    std::int64_t sequence = 0;
    std::uint32_t checksum = 0;
    std::size_t size = 0;
    bool operator==(const Key&) const = default;
  };
  struct Open {
    Key key;
    std::shared_ptr<Bytes> memory;
    std::vector<bool> here;
    std::size_t missing = 0;
  };
  Open& entry(const Key& key, std::size_t count);

  std::deque<Open> open_;
  std::optional<Key> last_;  ///< the chunk added last was part of this one
  std::optional<Key> whole_key_;
  std::shared_ptr<Bytes> whole_;  ///< the message handed out
  std::shared_ptr<Bytes> spare_;  ///< the one before
};

}  // namespace tandem::wire

#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/wire/messages.h"

namespace tandem::wire {

/// Messages up to this size go in one datagram (LCM's limit is 65,499 bytes with the channel).
inline constexpr std::size_t kMaxWhole = 60000;

/// Parts that a receive buffer of so many bytes surely holds, beside what else may be in it; 0 = a
/// size that is not known.
[[nodiscard]] std::size_t burst_of(int receive_buffer_bytes);

/// A message above kMaxWhole, in sealed chunk messages. The message's own checksum is written into
/// each chunk and is zero in the message itself. A part is sent from where it lies, behind a header
/// that stands there meanwhile; before the first part there is room for one.
class SentMessage {
 public:
  using Send = std::function<void(ByteView)>;

  /// Copies `message`, which has a header and at most 64 MiB, into `memory`.
  explicit SentMessage(ByteView message, Bytes memory = {});
  /// The memory, for another message.
  [[nodiscard]] Bytes release() { return std::move(message_); }

  /// Whether it is the one of which the parts are missing.
  [[nodiscard]] bool is(const Missing& missing) const;
  [[nodiscard]] const Header& header() const { return header_; }
  [[nodiscard]] std::size_t bytes() const { return message_.size() - kChunkHead; }
  [[nodiscard]] std::size_t parts() const { return checksums_.size(); }

  /// Hands a part to `send`; `ends_burst` says that no more come before they are asked for. The
  /// same part has the same bytes but for these and `attempt`.
  void send(std::size_t index, bool ends_burst, std::int32_t attempt, const Send& send);

 private:
  Header header_;
  Bytes message_;  ///< behind kChunkHead bytes of room
  std::uint32_t checksum_ = 0;
  std::vector<std::uint32_t> checksums_;  ///< CRC-32 of each part
};

/// The messages in chunks that a process has sent last, so that parts can be sent once more.
class SentMessages {
 public:
  static constexpr std::size_t kMost = 4;  ///< of a channel; one of requests and of replies
  static constexpr std::size_t kMostBytes = 128U << 20U;

  struct Entry {
    std::string channel;
    SentMessage message;
  };
  /// Keeps a copy; one of the same channel and number is replaced, the oldest may go.
  Entry& keep(const std::string& channel, ByteView message);
  /// The one of which parts are missing; null when it is kept no more.
  [[nodiscard]] Entry* find(const Missing& missing);

 private:
  std::deque<Entry> entries_;
};

}  // namespace tandem::wire

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tandem::wire {

/// Leaves bytes that a vector grows by as they are: messages are written right after their memory
/// was made, and to fill it with zeros first would be one more pass over it.
template <class T>
struct Unfilled : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = Unfilled<U>;
  };
  template <class U, class... Given>
  void construct(U* at, Given&&... given) {
    if constexpr (sizeof...(Given) == 0) {
      ::new (static_cast<void*>(at)) U;
    } else {
      std::construct_at(at, std::forward<Given>(given)...);
    }
  }
};

using Bytes = std::vector<std::uint8_t, Unfilled<std::uint8_t>>;
using ByteView = std::span<const std::uint8_t>;

/// What a message is. Numbers are part of the wire format: never reuse one.
enum class Kind : std::int32_t {
  Hello = 1,
  Welcome = 2,
  Request = 3,
  Reply = 4,
  Closed = 5,
  Alive = 6,
  Abort = 7,
  Journal = 8,
  Credit = 9,
  Finished = 10,
  Chunk = 11,
  Call = 12,
  Step = 13,
  Scenario = 14,
  SelfTest = 15,
  Control = 16,
  Controlled = 17,
  Missing = 18,
  Requests = 19,
};
inline constexpr std::size_t kKinds = 20;
[[nodiscard]] const char* text_of(Kind kind);  ///< "request": last part of the channel's name

/// The processes of a run. Where it has several flexible bodies, each has one of its own, and there
/// is no Fem: see body_process(). Fem's channels are then those of all of them. Likewise of several
/// multibody worlds: see world_process().
enum class Process : std::int32_t { Mbs = 0, Fem = 1, Orchestrator = 2, Tool = 3 };
inline constexpr std::size_t kFirstBody = 4;
inline constexpr std::size_t kMostBodies = 60;
inline constexpr std::size_t kFirstWorld = kFirstBody + kMostBodies;
inline constexpr std::size_t kMostWorlds = 32;
inline constexpr std::size_t kProcesses = kFirstWorld + kMostWorlds;
/// That of the flexible body of this number, of so many.
[[nodiscard]] constexpr Process body_process(std::size_t body, std::size_t bodies) {
  return bodies == 1 ? Process::Fem : static_cast<Process>(kFirstBody + body);
}
/// That of the multibody world of this number, of so many.
[[nodiscard]] constexpr Process world_process(std::size_t world, std::size_t worlds) {
  return worlds == 1 ? Process::Mbs : static_cast<Process>(kFirstWorld + world);
}
[[nodiscard]] constexpr bool is_multibody(Process process) {
  return process == Process::Mbs || static_cast<std::size_t>(process) >= kFirstWorld;
}
[[nodiscard]] constexpr bool is_flexible(Process process) {
  return process == Process::Fem ||
         (static_cast<std::size_t>(process) >= kFirstBody && !is_multibody(process));
}
/// First part of a channel's name: "mbs", "fem"; "fem1", "fem2" … of several flexible bodies,
/// "mbs1", "mbs2" … of several multibody worlds.
[[nodiscard]] std::string text_of(Process process);

/// First member of every message; types/header.lcm says what each field means.
struct Header {
  std::uint32_t checksum = 0;
  std::uint64_t run_id = 0;
  std::int64_t sequence = 0;
  std::int64_t macro_step = 0;
  std::int32_t iteration = 0;
  Kind kind = Kind::Hello;
  std::int32_t attempt = 0;
  Process sender = Process::Tool;
  std::int64_t time_us = 0;
};

/// Offset (bytes) of the first byte behind the header: 8 bytes fingerprint, 52 bytes header.
inline constexpr std::size_t kHeaderEnd = 60;

/// Writes `attempt` and the checksum into an encoded message.
void seal(Bytes& message, std::int32_t attempt = 0);

/// The same for a message of which `head` is the beginning and the CRC-32 of the rest is known.
void seal(std::span<std::uint8_t> head, std::int32_t attempt, std::uint32_t rest_crc,
          std::size_t rest_bytes);

/// CRC-32 (zlib) of an encoded message with its checksum field taken as zero.
[[nodiscard]] std::uint32_t checksum_of(ByteView message);

/// The header, or nothing when the message is too short or its checksum does not fit: damaged
/// messages are dropped here, before anything is decoded.
[[nodiscard]] std::optional<Header> open_seal(ByteView message);

/// The header of an encoded message, unchecked; the message has at least kHeaderEnd bytes and a
/// valid sender.
[[nodiscard]] Header header_of(ByteView message);
void set_checksum(std::span<std::uint8_t> message, std::uint32_t checksum);

/// Writes all of `header` but its checksum into an encoded message, and then the checksum.
void seal_as(const Header& header, std::span<std::uint8_t> message);

/// Overwrites one double (big endian, as lcm-gen writes it) of a not yet sealed message.
void patch_double(Bytes& message, std::size_t offset, double value);

}  // namespace tandem::wire

#include "protocol/wire/seal.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "protocol/wire/crc32.h"

namespace tandem::wire {
namespace {

constexpr std::size_t kChecksumAt = 8;
constexpr std::size_t kRunAt = 12;
constexpr std::size_t kSequenceAt = 20;
constexpr std::size_t kMacroStepAt = 28;
constexpr std::size_t kIterationAt = 36;
constexpr std::size_t kKindAt = 40;
constexpr std::size_t kAttemptAt = 44;
constexpr std::size_t kSenderAt = 48;
constexpr std::size_t kTimeAt = 52;

// lcm-gen writes all numbers big endian.
template <class Word>
Word read_word(ByteView message, std::size_t offset) {
  Word word = 0;
  for (std::size_t i = 0; i < sizeof(Word); ++i) {
    word = static_cast<Word>((word << 8U) | message[offset + i]);
  }
  return word;
}

template <class Word>
void write_word(std::span<std::uint8_t> message, std::size_t offset, Word word) {
  for (std::size_t i = 0; i < sizeof(Word); ++i) {
    message[offset + i] = static_cast<std::uint8_t>(word >> (8U * (sizeof(Word) - 1 - i)));
  }
}

}  // namespace

const char* text_of(Kind kind) {
  switch (kind) {
    case Kind::Hello:
      return "hello";
    case Kind::Welcome:
      return "welcome";
    case Kind::Request:
      return "request";
    case Kind::Reply:
      return "reply";
    case Kind::Closed:
      return "closed";
    case Kind::Alive:
      return "alive";
    case Kind::Abort:
      return "abort";
    case Kind::Journal:
      return "journal";
    case Kind::Credit:
      return "credit";
    case Kind::Finished:
      return "finished";
    case Kind::Chunk:
      return "chunk";
    case Kind::Call:
      return "call";
    case Kind::Step:
      return "step";
    case Kind::Scenario:
      return "scenario";
    case Kind::SelfTest:
      return "selftest";
    case Kind::Control:
      return "control";
    case Kind::Controlled:
      return "controlled";
    case Kind::Missing:
      return "missing";
    case Kind::Requests:
      return "requests";
  }
  return "unknown";
}

std::string text_of(Process process) {
  switch (process) {
    case Process::Mbs:
      return "mbs";
    case Process::Fem:
      return "fem";
    case Process::Orchestrator:
      return "orchestrator";
    case Process::Tool:
      return "tool";
  }
  const auto number = static_cast<std::size_t>(process);
  if (is_multibody(process)) return "mbs" + std::to_string(number - kFirstWorld + 1);
  return "fem" + std::to_string(number - kFirstBody + 1);
}

std::uint32_t checksum_of(ByteView message) {
  // The first 16 bytes hold the checksum itself: taken from a copy where it is zero.
  std::array<std::uint8_t, 16> head{};
  std::memcpy(head.data(), message.data(), head.size());
  std::fill_n(head.begin() + kChecksumAt, 4, std::uint8_t{0});
  return crc32(crc32(0, head), message.subspan(head.size()));
}

void seal(Bytes& message, std::int32_t attempt) {
  write_word(message, kAttemptAt, static_cast<std::uint32_t>(attempt));
  write_word(message, kChecksumAt, checksum_of(message));
}

void seal(std::span<std::uint8_t> head, std::int32_t attempt, std::uint32_t rest_crc,
          std::size_t rest_bytes) {
  write_word(head, kAttemptAt, static_cast<std::uint32_t>(attempt));
  write_word(head, kChecksumAt, crc32_joined(checksum_of(head), rest_crc, rest_bytes));
}

Header header_of(ByteView message) {
  Header header;
  header.checksum = read_word<std::uint32_t>(message, kChecksumAt);
  header.run_id = read_word<std::uint64_t>(message, kRunAt);
  header.sequence = static_cast<std::int64_t>(read_word<std::uint64_t>(message, kSequenceAt));
  header.macro_step = static_cast<std::int64_t>(read_word<std::uint64_t>(message, kMacroStepAt));
  header.iteration = static_cast<std::int32_t>(read_word<std::uint32_t>(message, kIterationAt));
  header.kind = static_cast<Kind>(read_word<std::uint32_t>(message, kKindAt));
  header.attempt = static_cast<std::int32_t>(read_word<std::uint32_t>(message, kAttemptAt));
  header.sender = static_cast<Process>(read_word<std::uint32_t>(message, kSenderAt));
  header.time_us = static_cast<std::int64_t>(read_word<std::uint64_t>(message, kTimeAt));
  return header;
}

std::optional<Header> open_seal(ByteView message) {
  if (message.size() < kHeaderEnd) return std::nullopt;
  if (read_word<std::uint32_t>(message, kChecksumAt) != checksum_of(message)) return std::nullopt;
  if (read_word<std::uint32_t>(message, kSenderAt) >= kProcesses) return std::nullopt;
  return header_of(message);
}

void set_checksum(std::span<std::uint8_t> message, std::uint32_t checksum) {
  write_word(message, kChecksumAt, checksum);
}

void seal_as(const Header& header, std::span<std::uint8_t> message) {
  write_word(message, kRunAt, header.run_id);
  write_word(message, kSequenceAt, static_cast<std::uint64_t>(header.sequence));
  write_word(message, kMacroStepAt, static_cast<std::uint64_t>(header.macro_step));
  write_word(message, kIterationAt, static_cast<std::uint32_t>(header.iteration));
  write_word(message, kKindAt, static_cast<std::uint32_t>(header.kind));
  write_word(message, kAttemptAt, static_cast<std::uint32_t>(header.attempt));
  write_word(message, kSenderAt, static_cast<std::uint32_t>(header.sender));
  write_word(message, kTimeAt, static_cast<std::uint64_t>(header.time_us));
  write_word(message, kChecksumAt, checksum_of(message));
}

void patch_double(Bytes& message, std::size_t offset, double value) {
  write_word(message, offset, std::bit_cast<std::uint64_t>(value));
}

}  // namespace tandem::wire

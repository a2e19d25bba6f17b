#include "protocol/wire/chunks.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <random>

#include "protocol/wire/chunks_sent.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {
namespace {

Header some_header(Kind kind) {
  return {.run_id = 7, .sequence = 3, .macro_step = 5, .kind = kind, .sender = Process::Mbs};
}

// What liblcm puts into one datagram, and a channel of a run with the zero behind it.
constexpr std::size_t kLcmDatagram = 65499;
constexpr std::size_t kLongestChannel = sizeof("TANDEM_0123456789abcdef_orchestrator_controlled");

/// A sealed message of this size, with text that differs from byte to byte.
Bytes some_message(std::size_t size) {
  std::string text(size, ' ');
  std::mt19937 random(5);
  for (char& c : text) c = static_cast<char>(random());
  Finished finished{.exit_code = 0, .message = text, .summary_json = {}};
  const std::size_t more = encode(some_header(Kind::Finished), finished).size() - size;
  finished.message.resize(size - more);
  Bytes message = encode(some_header(Kind::Finished), finished);
  seal(message);
  return message;
}

std::vector<Bytes> parts_of(const Bytes& message, std::int32_t attempt = 0) {
  std::vector<Bytes> parts;
  SentMessage sent(message);
  for (std::size_t i = 0; i < sent.parts(); ++i) {
    sent.send(i, i + 1 == sent.parts(), attempt,
              [&parts](ByteView part) { parts.emplace_back(part.begin(), part.end()); });
  }
  return parts;
}

TEST(WireChunks, ReassembleInAnyOrderWithRepetitions) {
  const Bytes message = some_message(430000);
  std::vector<Bytes> parts = parts_of(message);
  for (const Bytes& part : parts_of(message, 1)) parts.push_back(part);
  ASSERT_GE(parts.size(), 8U);
  std::mt19937 random(11);
  for (int repetition = 0; repetition < 20; ++repetition) {
    std::shuffle(parts.begin(), parts.end(), random);
    Assembler assembler;
    int completed = 0;
    for (const Bytes& part : parts) {
      ASSERT_LE(part.size() + kLongestChannel, kLcmDatagram);
      ASSERT_TRUE(open_seal(part).has_value());
      if (const auto whole = assembler.add(*decode_chunk(part))) {
        ++completed;
        EXPECT_TRUE(std::equal(whole->begin(), whole->end(), message.begin(), message.end()));
      }
    }
    EXPECT_GE(completed, 1);
  }
}

TEST(WireChunks, IllFittingChunksAreRefused) {
  const Bytes message = some_message(130000);
  const Bytes second = parts_of(message)[1];
  const Chunk good = *decode_chunk(second);
  const auto refused = [](const Chunk& chunk) {
    Assembler assembler;
    return !assembler.add(chunk).has_value();
  };
  Chunk bad = good;
  bad.whole_bytes = std::numeric_limits<std::int32_t>::max();
  EXPECT_TRUE(refused(bad));
  for (const std::int32_t index : {-1, 3, std::numeric_limits<std::int32_t>::max()}) {
    bad = good;
    bad.index = index;
    EXPECT_TRUE(refused(bad));
  }
  bad = good;
  bad.bytes = good.bytes.first(good.bytes.size() - 1);
  EXPECT_TRUE(refused(bad));
}

/// A chunk of a whole of so many bytes, of which it is the first.
Chunk first_of(std::int32_t whole_bytes, std::int64_t sequence, ByteView bytes) {
  Chunk chunk;
  chunk.header = some_header(Kind::Chunk);
  chunk.header.sequence = sequence;
  chunk.whole_bytes = whole_bytes;
  constexpr auto kPart = static_cast<std::int32_t>(kChunkData);
  chunk.count = (whole_bytes + kPart - 1) / kPart;
  chunk.bytes = bytes.first(static_cast<std::size_t>(std::min(whole_bytes, kPart)));
  return chunk;
}

// The whole has a header, which is read once it is complete: sanitizers see a shorter one.
TEST(WireChunks, AWholeWithoutRoomForAHeaderIsRefused) {
  const Bytes bytes(60);
  Assembler assembler;
  for (std::int32_t size = 1; size < static_cast<std::int32_t>(kHeaderEnd); ++size) {
    EXPECT_FALSE(assembler.add(first_of(size, size, bytes)).has_value()) << size;
  }
  EXPECT_TRUE(assembler.add(first_of(kHeaderEnd, 60, bytes)).has_value());
}

/// Memory of this process that is in use (bytes).
std::int64_t resident_bytes() {
  std::int64_t all = 0;
  std::int64_t resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

// 24 first parts that claim 64 MiB each are 1.6 MB.
TEST(WireChunks, AClaimTakesNoMemoryBeforeItsPartsAreHere) {
  const Bytes bytes(kChunkData, 1);
  const std::int64_t before = resident_bytes();
  Assembler assembler;
  for (std::int64_t sequence = 1; sequence <= 24; ++sequence) {
    EXPECT_FALSE(assembler.add(first_of(64 << 20, sequence, bytes)).has_value());
  }
  EXPECT_LT(resident_bytes() - before, 8 << 20);
}

TEST(WireChunks, WhatIsMissingIsToldAndSentAlone) {
  const Bytes message = some_message(700000);
  const std::vector<Bytes> parts = parts_of(message);
  ASSERT_EQ(parts.size(), 11U);
  Assembler assembler;
  for (const std::size_t i : {0U, 1U, 2U, 5U}) {
    EXPECT_FALSE(assembler.add(*decode_chunk(parts[i])).has_value());
  }
  const auto request = assembler.lacks(4);
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->sender, Process::Mbs);
  EXPECT_EQ(request->missing.wanted, (std::vector<std::int32_t>{3, 4, 6, 7}));
  EXPECT_EQ(assembler.lacks(100)->missing.wanted,
            (std::vector<std::int32_t>{3, 4, 6, 7, 8, 9, 10}));

  Missing missing = request->missing;
  const Missing crossed = decode_missing(encode(missing)).value();
  EXPECT_EQ(crossed.wanted, missing.wanted);
  SentMessages sent;
  sent.keep("a", some_message(400000));
  sent.keep("b", message);
  SentMessages::Entry* entry = sent.find(crossed);
  ASSERT_NE(entry, nullptr);
  EXPECT_EQ(entry->channel, "b");
  ++missing.whole_checksum;
  EXPECT_EQ(sent.find(missing), nullptr);

  std::optional<ByteView> whole;
  for (const std::size_t i : {3U, 4U, 6U, 7U, 8U, 9U, 10U}) {
    whole = assembler.add(*decode_chunk(parts[i]));
  }
  ASSERT_TRUE(whole.has_value());
  EXPECT_TRUE(std::equal(whole->begin(), whole->end(), message.begin(), message.end()));
  EXPECT_FALSE(assembler.lacks(4).has_value());
}

// Of requests and replies the last one is kept alone, in the memory of the one before: whoever
// sends the next has heard that it was taken in.
TEST(WireChunks, TheNextRequestTakesThePlaceOfTheLast) {
  SentMessages sent;
  const auto request = [](std::int64_t sequence) {
    Request large;
    large.header = some_header(Kind::Request);
    large.header.sequence = sequence;
    large.command.resize(100000, static_cast<char>('a' + sequence));
    Bytes message = encode(large);
    seal(message);
    return message;
  };
  const auto is_kept = [&](const Bytes& message) {
    const Chunk first = decode_chunk(parts_of(message).front()).value();
    Missing missing{.header = first.header,
                    .whole_kind = first.whole_kind,
                    .whole_checksum = first.whole_checksum,
                    .wanted = {0}};
    return sent.find(missing) != nullptr;
  };
  sent.keep("a", request(1));
  EXPECT_TRUE(is_kept(request(1)));
  sent.keep("b", request(1));
  sent.keep("a", request(2));
  EXPECT_TRUE(is_kept(request(2)));
  EXPECT_TRUE(is_kept(request(1))) << "of the other channel";
  sent.keep("b", request(3));
  EXPECT_FALSE(is_kept(request(1)));
}

// A repetition is the first part alone: the receiver has the rest.
TEST(WireChunks, TheFirstPartOfTheLastMessageRepeatsIt) {
  const Bytes message = some_message(130000);
  Assembler assembler;
  for (const Bytes& part : parts_of(message)) (void)assembler.add(*decode_chunk(part));
  Bytes again;
  SentMessage(message).send(0, true, 1,
                            [&again](ByteView part) { again.assign(part.begin(), part.end()); });
  const auto whole = assembler.add(*decode_chunk(again));
  ASSERT_TRUE(whole.has_value());
  EXPECT_TRUE(std::equal(whole->begin(), whole->end(), message.begin(), message.end()));
}

}  // namespace
}  // namespace tandem::wire

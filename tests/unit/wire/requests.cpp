// Requests to several sides in one message.
#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/wire/messages.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

constexpr std::size_t kBodies = 3;

Bytes request_of(std::size_t body, std::uint64_t run_id = 7) {
  Request request;
  request.header = {.run_id = run_id,
                    .sequence = 100 + static_cast<std::int64_t>(body),
                    .macro_step = 5,
                    .iteration = 2,
                    .kind = Kind::Request,
                    .sender = Process::Mbs};
  request.call = RequestKind::Advance;
  request.rollback_first = body == 1;
  request.step = SimTime(1000000);
  request.motions.end = test::some_motions(body + 1, 0.5);
  return encode(request);
}

Bytes requests_of(std::initializer_list<std::size_t> bodies) {
  Bytes message;
  begin_requests(message);
  for (const std::size_t b : bodies) append(body_process(b, kBodies), request_of(b), message);
  end_requests({.run_id = 7, .sequence = 9, .kind = Kind::Requests, .sender = Process::Mbs},
               message);
  return message;
}

TEST(WireRequests, EachSideFindsItsOwnBytes) {
  Bytes message = requests_of({0, 1, 2});
  seal(message, 0);
  const auto header = open_seal(message);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->sequence, 9);
  EXPECT_EQ(header->kind, Kind::Requests);
  for (std::size_t b = 0; b < kBodies; ++b) {
    const auto own = request_to(body_process(b, kBodies), message);
    const Bytes expected = request_of(b);
    ASSERT_TRUE(own);
    EXPECT_TRUE(std::equal(own->begin(), own->end(), expected.begin(), expected.end())) << b;
    EXPECT_EQ(decode_request(*own)->header.sequence, 100 + static_cast<std::int64_t>(b));
  }
}

TEST(WireRequests, ASideThatIsNotAskedFindsNone) {
  const auto own = request_to(body_process(1, kBodies), requests_of({0, 2}));
  ASSERT_TRUE(own);
  EXPECT_TRUE(own->empty());
}

// Whatever a stranger sends: nothing is read behind the message's end.
TEST(WireRequests, WhatDoesNotAddUpIsRefused) {
  const Bytes whole = requests_of({0, 1, 2});
  const Process last = body_process(2, kBodies);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(request_to(last, ByteView(whole).first(size))) << size;
  }
  const Bytes head = requests_of({});
  for (std::size_t at = head.size(); at < head.size() + 8; ++at) {
    Bytes bent = whole;
    bent[at] = 0xff;
    const auto own = request_to(last, bent);
    // Another process for the first one leaves the rest as it is.
    EXPECT_EQ(own.has_value(), at < head.size() + 4) << at;
  }
  EXPECT_FALSE(request_to(last, request_of(2))) << "another message";
  EXPECT_FALSE(request_to(last, requests_of({2, 2}))) << "two for one side";
}

TEST(WireRequests, ARequestOfAnotherRunIsRefused) {
  Bytes message;
  begin_requests(message);
  append(body_process(0, kBodies), request_of(0, 8), message);
  end_requests({.run_id = 7, .kind = Kind::Requests, .sender = Process::Mbs}, message);
  EXPECT_FALSE(request_to(body_process(0, kBodies), message));
}

}  // namespace
}  // namespace tandem::wire

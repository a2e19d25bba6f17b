#include <gtest/gtest.h>

#include <string>

#include "protocol/wire/messages.h"

// The bytes of the wire are a contract with recorded logs and with other versions: whoever changes
// them must raise kProtocolVersion. Golden for the format only; the numbers are read off below.
namespace tandem::wire {
namespace {

std::string hex(ByteView bytes, std::size_t begin, std::size_t count) {
  std::string text;
  for (const std::uint8_t byte : bytes.subspan(begin, count)) {
    text += "0123456789abcdef"[byte >> 4U];
    text += "0123456789abcdef"[byte & 15U];
  }
  return text;
}

Bytes advance_request() {
  Request request;
  request.header = {.run_id = 0x0123456789abcdefULL,
                    .sequence = 258,
                    .macro_step = 3,
                    .iteration = 2,
                    .kind = Kind::Request,
                    .sender = Process::Mbs,
                    .time_us = 16};
  request.call = RequestKind::Advance;
  request.rollback_first = true;
  request.linearize = true;
  request.step = SimTime(1000000);
  request.wrenches.end.resize(1);
  request.wrenches.end[0].f_P_W = {1.0, -2.0, 0.5};
  request.wrenches.end[0].t_P_W = {-0.0, 1e300, 0.1};
  Bytes bytes = encode(request);
  seal(bytes, 1);
  return bytes;
}

TEST(WireBytes, RequestIsBigEndianInTheOrderOfItsFields) {
  ASSERT_EQ(kProtocolVersion, 9);
  const Bytes bytes = advance_request();
  ASSERT_EQ(bytes.size(), 8U + 52U + 5U * 4U + 4U + 3U + 8U + 48U);
  EXPECT_EQ(hex(bytes, 0, 8), "df504e2d8986e8ab");   // lcm-gen's hash of request_t and its members
  EXPECT_EQ(hex(bytes, 8, 4), "9519995a");           // CRC-32 with these four bytes zero
  EXPECT_EQ(hex(bytes, 12, 8), "0123456789abcdef");  // run id
  EXPECT_EQ(hex(bytes, 20, 8), "0000000000000102");  // sequence
  EXPECT_EQ(hex(bytes, 28, 8), "0000000000000003");  // macro step
  EXPECT_EQ(hex(bytes, 36, 4), "00000002");          // iteration
  EXPECT_EQ(hex(bytes, 40, 4), "00000003");          // kind: request
  EXPECT_EQ(hex(bytes, 44, 4), "00000001");          // attempt
  EXPECT_EQ(hex(bytes, 48, 4), "00000000");          // sender: mbs
  EXPECT_EQ(hex(bytes, 52, 8), "0000000000000010");  // time
  EXPECT_EQ(hex(bytes, 60, 20),
            "0000000000000000000000000000000100000000");  // counts: one wrench at end
  EXPECT_EQ(hex(bytes, 80, 4), "00000001");               // call: advance
  EXPECT_EQ(hex(bytes, 84, 3), "000101");                 // checkpoint, rollback, linearize
  EXPECT_EQ(hex(bytes, 87, 8), "00000000000f4240");       // 1,000,000 ns
  EXPECT_EQ(hex(bytes, 95, 8), "3ff0000000000000");       // f_P_W_N[0] = 1
  EXPECT_EQ(hex(bytes, 103, 8), "c000000000000000");
  EXPECT_EQ(hex(bytes, 111, 8), "3fe0000000000000");
  EXPECT_EQ(hex(bytes, 119, 8), "8000000000000000");  // t_P_W_Nm[0] = −0
  EXPECT_EQ(hex(bytes, 127, 8), "7e37e43c8800759c");  // 1e300
  EXPECT_EQ(hex(bytes, 135, 8), "3fb999999999999a");  // 0.1
}

// The fingerprint of every message type; a changed field, name or unit changes it.
TEST(WireBytes, SchemasAreThoseOfProtocolVersion9) {
  ASSERT_EQ(kProtocolVersion, 9);
  const auto fingerprint = [](const Bytes& bytes) { return hex(bytes, 0, 8); };
  Bytes requests;
  begin_requests(requests);
  EXPECT_EQ(fingerprint(requests), "759249ac1b961247");
  EXPECT_EQ(fingerprint(encode(Reply{})), "5d3393046ee02076");
  EXPECT_EQ(fingerprint(encode(Handshake{})), "2691dad80a2396d7");
  EXPECT_EQ(fingerprint(encode(Alive{})), "f0d489aa6829b5d5");
  EXPECT_EQ(fingerprint(encode(Abort{})), "dd62f9166681e6a3");
  EXPECT_EQ(fingerprint(encode(Credit{})), "b1ed2b80e28a8607");
  Bytes chunk(kChunkHead);
  encode_head(Chunk{}, 0, std::span<std::uint8_t, kChunkHead>(chunk));
  EXPECT_EQ(fingerprint(chunk), "172e07b7bf01c487");
  EXPECT_EQ(fingerprint(encode(Missing{})), "b9497ceb2c0c98cb");
  EXPECT_EQ(fingerprint(encode(Control{})), "ce97476618f21b03");
  EXPECT_EQ(fingerprint(encode(Controlled{})), "f3704e734223d909");
  EXPECT_EQ(fingerprint(encode(Header{}, CallRecord{})), "5ae6f6d23c8961e3");
  EXPECT_EQ(fingerprint(encode(Header{}, StepRecord{})), "e4ae41581e8d7e46");
  EXPECT_EQ(fingerprint(encode(Header{}, StepJournal{})), "10f0ceed0cf2971d");
  EXPECT_EQ(fingerprint(encode(Header{}, Finished{})), "0a57f30fdac9cf4f");
  EXPECT_EQ(fingerprint(encode(Header{}, ScenarioText{})), "868aa6e1b5982bba");
}

}  // namespace
}  // namespace tandem::wire

#include "protocol/wire/messages.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <tandem_wire/call_of_7_t.hpp>
#include <tandem_wire/request_t.hpp>

#include "protocol/wire/crc32.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

// Values that a careless conversion changes: NaNs with payloads (quiet and signalling), −0.0,
// denormals, infinities.
const std::vector<std::uint64_t> kOddBits{0x7ff8000000000123ULL, 0xfff0000000000001ULL,
                                          0x8000000000000000ULL, 0x0000000000000001ULL,
                                          0x7ff0000000000000ULL, 0x3ff0000000000001ULL};

MotionSet odd_motions() {
  MotionSet motions(2);
  std::size_t next = 0;
  for (Motion& motion : motions) {
    for (double* x : {motion.p_WP.data(), motion.q_WP.coeffs().data(), motion.v_WP.data(),
                      motion.w_WP.data()}) {
      for (int i = 0; i < (x == motion.q_WP.coeffs().data() ? 4 : 3); ++i) {
        x[i] = std::bit_cast<double>(kOddBits[next++ % kOddBits.size()]);
      }
    }
  }
  return motions;
}

WrenchSet odd_wrenches() {
  WrenchSet wrenches(3);
  std::size_t next = 2;
  for (Wrench& wrench : wrenches) {
    for (int i = 0; i < 3; ++i) {
      wrench.f_P_W[i] = std::bit_cast<double>(kOddBits[next++ % kOddBits.size()]);
      wrench.t_P_W[i] = std::bit_cast<double>(kOddBits[next++ % kOddBits.size()]);
    }
  }
  return wrenches;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
bool same_bits(const double* a, const double* b, Eigen::Index n) {
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!same_bits(a[i], b[i])) return false;
  }
  return true;
}
bool same_bits(const MotionSet& a, const MotionSet& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!same_bits(a[i].p_WP.data(), b[i].p_WP.data(), 3) ||
        !same_bits(a[i].q_WP.coeffs().data(), b[i].q_WP.coeffs().data(), 4) ||
        !same_bits(a[i].v_WP.data(), b[i].v_WP.data(), 3) ||
        !same_bits(a[i].w_WP.data(), b[i].w_WP.data(), 3)) {
      return false;
    }
  }
  return true;
}
bool same_bits(const WrenchSet& a, const WrenchSet& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!same_bits(a[i].f_P_W.data(), b[i].f_P_W.data(), 3) ||
        !same_bits(a[i].t_P_W.data(), b[i].t_P_W.data(), 3)) {
      return false;
    }
  }
  return true;
}

Header some_header(Kind kind) {
  return {.run_id = 0xfedcba9876543210ULL,
          .sequence = 42,
          .macro_step = 7,
          .iteration = 3,
          .kind = kind,
          .sender = Process::Fem,
          .time_us = 1234567890123};
}

TEST(WireMessages, RequestCrossesBitForBit) {
  Request request;
  request.header = some_header(Kind::Request);
  request.call = RequestKind::Advance;
  request.checkpoint_first = true;
  request.linearize = true;
  request.step = SimTime(std::numeric_limits<std::int64_t>::max());
  request.motions = {odd_motions(), test::some_motions(2, 0.1)};
  request.wrenches = {odd_wrenches(), odd_wrenches()};
  const auto back = decode_request(encode(request));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->header.run_id, request.header.run_id);
  EXPECT_EQ(back->header.sequence, 42);
  EXPECT_EQ(back->call, RequestKind::Advance);
  EXPECT_TRUE(back->checkpoint_first);
  EXPECT_FALSE(back->rollback_first);
  EXPECT_TRUE(back->linearize);
  EXPECT_EQ(back->step, request.step);
  EXPECT_TRUE(same_bits(back->motions.begin, request.motions.begin));
  EXPECT_TRUE(same_bits(back->motions.end, request.motions.end));
  EXPECT_TRUE(same_bits(back->wrenches.begin, request.wrenches.begin));
  EXPECT_TRUE(same_bits(back->wrenches.end, request.wrenches.end));
}

EnergyBook some_book() {
  return {.kinetic_J = 1.0,
          .potential_J = -0.0,
          .elastic_J = 3.0,
          .external_work_J = 4.0,
          .interface_work_J = -5.0,
          .damping_loss_J = 6.0,
          .numerical_loss_J = 0.7};
}

Reply some_reply() {
  Reply reply;
  reply.header = some_header(Kind::Reply);
  reply.cost = {0.1, 0.2, 0.3, 0.4};
  reply.duplicates = 5;
  reply.outcome = Outcome::NotConverged;
  reply.error = ErrorKind::NotSolved;
  reply.message = "‖r‖ = 3.1e-2 N";
  reply.solver_iterations = 12;
  reply.jacobian = Eigen::MatrixXd::Random(18, 36);
  (*reply.jacobian)(3, 4) = std::bit_cast<double>(kOddBits[1]);
  reply.observation = {SimTime(9), some_book(), 0x8000000000000001ULL, 0.3, {2e-3, 0.04, 7}};
  reply.motions = odd_motions();
  reply.wrenches = odd_wrenches();
  return reply;
}

TEST(WireMessages, ReplyCrossesBitForBit) {
  const Reply reply = some_reply();
  Bytes bytes = encode(reply);
  patch_double(bytes, kReplyEncodeAt, 0.75);  // the place that the server fills in afterwards
  const auto back = decode_reply(bytes);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->cost.compute_s, 0.1);
  EXPECT_EQ(back->cost.decode_s, 0.2);
  EXPECT_EQ(back->cost.encode_s, 0.75);
  EXPECT_EQ(back->cost.publish_s, 0.4);
  EXPECT_EQ(back->duplicates, 5);
  EXPECT_EQ(back->outcome, Outcome::NotConverged);
  EXPECT_EQ(back->error, ErrorKind::NotSolved);
  EXPECT_EQ(back->message, reply.message);
  EXPECT_EQ(back->solver_iterations, 12);
  ASSERT_TRUE(back->jacobian.has_value());
  ASSERT_EQ(back->jacobian->rows(), 18);
  ASSERT_EQ(back->jacobian->cols(), 36);
  EXPECT_TRUE(same_bits(back->jacobian->data(), reply.jacobian->data(), 18 * 36));
  EXPECT_EQ(back->observation.time, SimTime(9));
  EXPECT_EQ(back->observation.energy, some_book());
  EXPECT_TRUE(same_bits(back->observation.energy.potential_J, -0.0));
  EXPECT_EQ(back->observation.state_hash, 0x8000000000000001ULL);
  EXPECT_EQ(back->observation.elastic_turn_rad, 0.3);
  EXPECT_EQ(back->observation.widest_joint.gap_m, 2e-3);
  EXPECT_EQ(back->observation.widest_joint.part, 0.04);
  EXPECT_EQ(back->observation.widest_joint.joint, 7);
  EXPECT_TRUE(same_bits(back->motions, reply.motions));
  EXPECT_TRUE(same_bits(back->wrenches, reply.wrenches));
}

TEST(WireMessages, NoJacobianIsNotAnEmptyJacobian) {
  Reply reply;
  EXPECT_FALSE(decode_reply(encode(reply))->jacobian.has_value());
  reply.jacobian = Eigen::MatrixXd(0, 0);
  EXPECT_TRUE(decode_reply(encode(reply))->jacobian.has_value());
}

TEST(WireMessages, HandshakeKeepsPortTable) {
  Handshake handshake;
  handshake.header = some_header(Kind::Welcome);
  handshake.tandem_version = "0.1.0";
  handshake.scenario_hash = 0xffffffffffffffffULL;
  handshake.ports = {{"base", 0.25}, {"eye", -0.0}};
  handshake.micro_step = SimTime(500000);
  handshake.can_linearize = true;
  const auto back = decode_handshake(encode(handshake));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->tandem_version, "0.1.0");
  EXPECT_EQ(back->scenario_hash, handshake.scenario_hash);
  ASSERT_EQ(back->ports.size(), 2U);
  EXPECT_EQ(back->ports[1].name, "eye");
  EXPECT_TRUE(same_bits(back->ports[1].length_m, -0.0));
  EXPECT_EQ(back->micro_step, SimTime(500000));
  EXPECT_TRUE(back->can_linearize);
}

StepJournal some_journal() {
  StepJournal journal;
  journal.step.macro_step = 7;
  journal.step.time = SimTime(7000000);
  journal.step.step = SimTime(1000000);
  journal.step.iterations = 2;
  journal.step.residual_N = -0.0;
  journal.step.energy_defect_J = std::bit_cast<double>(kOddBits[0]);
  journal.step.outcome = Outcome::NotConverged;
  Ledger& ledger = journal.step.ledger;
  double value = 0.5;
  for (double* column :
       {&ledger.mbs_compute_s, &ledger.fem_compute_s, &ledger.encode_s, &ledger.decode_s,
        &ledger.publish_s, &ledger.transit_s, &ledger.wait_s, &ledger.scheme_s, &ledger.record_s,
        &ledger.other_s, &ledger.overlap_s, &ledger.discarded_s}) {
    *column = (value += 1.0);
  }
  std::int64_t number = 10;
  for (std::int64_t* column :
       {&ledger.messages, &ledger.bytes, &ledger.resent, &ledger.duplicates, &ledger.lost}) {
    *column = ++number;
  }
  CallRecord fem;
  fem.side = SideName::Fem;
  fem.kind = CallKind::Advance;
  fem.rollback_first = true;
  fem.accepted = true;
  fem.macro_step = 7;
  fem.iteration = 2;
  fem.step = SimTime(1000000);
  fem.motions = {odd_motions(), odd_motions()};
  fem.wrenches.end = odd_wrenches();
  fem.outcome = Outcome::NotConverged;
  fem.message = "60 iterations";
  fem.solver_iterations = 60;
  CallRecord mbs;
  mbs.checkpoint_first = true;
  mbs.macro_step = 7;
  mbs.wrenches = {odd_wrenches(), odd_wrenches()};
  mbs.motions.end = odd_motions();
  journal.calls = {mbs, fem};
  return journal;
}

TEST(WireMessages, JournalKeepsEnergiesWhereTheyWereObserved) {
  StepJournal journal = some_journal();
  journal.step.energy = SideEnergies{.mbs = some_book(),
                                     .fem = some_book() + some_book(),
                                     .parts = {some_book(), {}, some_book()}};
  const auto journals = decode_journal(encode(some_header(Kind::Journal), journal));
  ASSERT_TRUE(journals.has_value());
  EXPECT_EQ(journals->front().step.energy, journal.step.energy);
  const Bytes without = encode(some_header(Kind::Journal), some_journal());
  EXPECT_FALSE(decode_journal(without).value().front().step.energy.has_value());
}

TEST(WireMessages, JournalKeepsEveryFieldOfCallsAndStep) {
  const StepJournal journal = some_journal();
  const auto journals = decode_journal(encode(some_header(Kind::Journal), journal));
  ASSERT_TRUE(journals.has_value());
  ASSERT_EQ(journals->size(), 1U);
  const StepJournal* back = &journals->front();
  ASSERT_EQ(back->calls.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const CallRecord& a = journal.calls[i];
    const CallRecord& b = back->calls[i];
    EXPECT_EQ(a.side, b.side);
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.rollback_first, b.rollback_first);
    EXPECT_EQ(a.checkpoint_first, b.checkpoint_first);
    EXPECT_EQ(a.linearize, b.linearize);
    EXPECT_EQ(a.accepted, b.accepted);
    EXPECT_EQ(a.macro_step, b.macro_step);
    EXPECT_EQ(a.iteration, b.iteration);
    EXPECT_EQ(a.step, b.step);
    EXPECT_TRUE(same_bits(a.wrenches.begin, b.wrenches.begin));
    EXPECT_TRUE(same_bits(a.wrenches.end, b.wrenches.end));
    EXPECT_TRUE(same_bits(a.motions.begin, b.motions.begin));
    EXPECT_TRUE(same_bits(a.motions.end, b.motions.end));
    EXPECT_EQ(a.outcome, b.outcome);
    EXPECT_EQ(a.message, b.message);
    EXPECT_EQ(a.solver_iterations, b.solver_iterations);
  }
  // A second encoding gives the same bytes: no field of the step record is lost on the way.
  EXPECT_EQ(encode(some_header(Kind::Step), journal.step),
            encode(some_header(Kind::Step), back->step));
  EXPECT_EQ(back->step.ledger.lost, 15);
  EXPECT_EQ(back->step.ledger.overlap_s, 11.5);
  EXPECT_EQ(back->step.ledger.discarded_s, 12.5);
}

TEST(WireMessages, CallKeepsItsTimes) {
  CallRecord call = some_journal().calls.back();
  call.times = {.begin_s = 1.5,
                .end_s = 9.5,
                .parts = {{2.0, 3.0, 8.0, 1.7e15, 4.0, 0.25, 0.5}, {2.5, 8.0, 9.0, 0.0, 1.0}}};
  const auto back = decode_call(encode(some_header(Kind::Call), call));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->times.begin_s, 1.5);
  EXPECT_EQ(back->times.end_s, 9.5);
  ASSERT_EQ(back->times.parts.size(), 2U);
  const PartTimes& part = back->times.parts[0];
  EXPECT_EQ(part.sent_s, 2.0);
  EXPECT_EQ(part.awaited_s, 3.0);
  EXPECT_EQ(part.arrived_s, 8.0);
  EXPECT_EQ(part.side_us, 1.7e15);
  EXPECT_EQ(part.compute_s, 4.0);
  EXPECT_EQ(part.decode_s, 0.25);
  EXPECT_EQ(part.encode_s, 0.5);
  EXPECT_EQ(back->times.parts[1].awaited_s, 8.0);
  call.times = {};
  EXPECT_EQ(decode_call(encode(some_header(Kind::Call), call))->times.end_s, 0.0);
}

// Logs of protocol version 7 hold no times; the fingerprint is that of call_t then.
TEST(WireMessages, CallsOfVersion7AreRead) {
  tandem_wire::call_of_7_t old{};
  old.header.macro_step = 7;
  old.side = 1;
  old.call = 1;
  old.rollback_first = 1;
  old.step_ns = 1000000;
  old.n_message = 2;
  old.message = {'n', 'o'};
  Bytes bytes(static_cast<std::size_t>(old.getEncodedSize()));
  old.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  EXPECT_EQ(bytes[0], 0x62);
  EXPECT_EQ(bytes[1], 0x9f);
  const auto call = decode_call(bytes);
  ASSERT_TRUE(call.has_value());
  EXPECT_EQ(call->side, SideName::Fem);
  EXPECT_EQ(side_of_call(bytes), SideName::Fem);
  EXPECT_EQ(call->macro_step, 7);
  EXPECT_TRUE(call->rollback_first);
  EXPECT_EQ(call->message, "no");
  EXPECT_EQ(call->times.end_s, 0.0);
}

TEST(WireMessages, EveryFlippedBitBreaksTheSeal) {
  Bytes bytes = encode(some_reply());
  seal(bytes, 2);
  ASSERT_TRUE(open_seal(bytes).has_value());
  EXPECT_EQ(open_seal(bytes)->attempt, 2);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      bytes[at] ^= static_cast<std::uint8_t>(1U << bit);
      EXPECT_FALSE(open_seal(bytes).has_value()) << at;
      bytes[at] ^= static_cast<std::uint8_t>(1U << bit);
    }
  }
}

TEST(WireMessages, EveryShorterMessageIsRefused) {
  const Bytes bytes = encode(some_reply());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Bytes cut_short(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(decode_reply(cut_short).has_value()) << size;
  }
}

// The counts stand directly behind the header; 0x7fffffff motions would ask for 223 GB.
TEST(WireMessages, HugeAndNegativeCountsAreRefusedBeforeMemoryIsTaken) {
  const Bytes good = encode(some_reply());
  for (std::size_t field = 0; field < 4; ++field) {
    for (const std::uint32_t count : {0x7fffffffU, 0xffffffffU, 0x80000000U, 0x00ffffffU}) {
      Bytes bad = good;
      for (std::size_t i = 0; i < 4; ++i) {
        bad[kHeaderEnd + 4 * field + i] = static_cast<std::uint8_t>(count >> (24 - 8 * i));
      }
      EXPECT_FALSE(decode_reply(bad).has_value());
    }
  }
}

TEST(WireMessages, AnotherMessageTypeIsRefused) {
  EXPECT_FALSE(decode_request(encode(some_reply())).has_value());
  EXPECT_FALSE(decode_credit(encode(Alive{some_header(Kind::Alive), 1, ""})).has_value());
}

TEST(WireMessages, AJournalCarriesSeveralMacroStepsInOrder) {
  Bytes message;
  begin_journal(message);
  for (int n = 1; n <= 3; ++n) {
    StepJournal journal = some_journal();
    journal.step.macro_step = n;
    journal.calls.resize(static_cast<std::size_t>(n), journal.calls.front());
    append(journal, message);
  }
  end_journal(some_header(Kind::Journal), message);
  const auto journals = decode_journal(message);
  ASSERT_TRUE(journals.has_value());
  ASSERT_EQ(journals->size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ((*journals)[i].step.macro_step, static_cast<std::int64_t>(i + 1));
    EXPECT_EQ((*journals)[i].calls.size(), i + 1);
  }
}

// Arrays are written without lcm-gen's code; whoever decodes with it must find the same numbers.
TEST(WireMessages, ArraysLieAsTheGeneratedCodeLaysThem) {
  Request request;
  request.header = some_header(Kind::Request);
  request.call = RequestKind::Advance;
  request.motions.begin = {Motion{.p_WP = {1.0, -0.0, 3.0}}, Motion{.v_WP = {1e300, -2.0, 0.25}}};
  request.motions.end = {Motion{.q_WP = Eigen::Quaterniond(0.125, 0.25, 0.375, 0.5)}};
  request.wrenches.end = {Wrench{.f_P_W = {7.0, 8.0, 9.0}, .t_P_W = {-1.0, -2.0, -3.0}}};
  const Bytes message = encode(request);

  tandem_wire::request_t generated;
  const int size = static_cast<int>(message.size());
  ASSERT_EQ(generated.decode(message.data(), 0, size), size);
  ASSERT_EQ(generated.motions_begin.size(), 2U);
  EXPECT_EQ(generated.motions_begin[0].p_WP_m[2], 3.0);
  EXPECT_TRUE(std::signbit(generated.motions_begin[0].p_WP_m[1]));
  EXPECT_EQ(generated.motions_begin[1].v_WP_m_per_s[0], 1e300);
  ASSERT_EQ(generated.motions_end.size(), 1U);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(generated.motions_end[0].q_WP_wxyz[i], 0.125 * (i + 1));
  ASSERT_EQ(generated.wrenches_end.size(), 1U);
  EXPECT_EQ(generated.wrenches_end[0].f_P_W_N[1], 8.0);
  EXPECT_EQ(generated.wrenches_end[0].t_P_W_Nm[2], -3.0);

  Bytes encoded(message.size());
  ASSERT_EQ(generated.encode(encoded.data(), 0, size), size);
  EXPECT_EQ(encoded, message);
}

// Reference: zlib. All lengths around the 64-byte blocks and the 16-byte lanes, all alignments.
TEST(WireChecksum, IsThatOfZlibForEveryLengthAndAlignment) {
  std::mt19937 random(3);
  Bytes bytes(70000);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  const auto check = [&bytes](std::size_t at, std::size_t size, std::uint32_t start) {
    EXPECT_EQ(crc32(start, ByteView(bytes).subspan(at, size)),
              ::crc32_z(start, bytes.data() + at, size))
        << at << " " << size;
  };
  for (std::size_t size = 0; size < 300; ++size) check(size % 16, size, size % 2 == 0 ? 0 : 12345U);
  for (std::size_t at = 0; at < 16; ++at) check(at, 60000 + at, 0xdeadbeefU);
}

}  // namespace
}  // namespace tandem::wire

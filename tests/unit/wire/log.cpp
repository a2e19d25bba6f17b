#include <gtest/gtest.h>
#include <lcm/lcm.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "protocol/wire/event_log.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

class WireLog : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(testing::TempDir()) /
            ("wire_log_" + std::to_string(getpid()) + ".lcm");
  }
  void TearDown() override { std::filesystem::remove(file_); }

  static StepJournal journal(std::int64_t step) {
    StepJournal journal;
    journal.step.macro_step = step;
    journal.step.residual_N = 0.5 * static_cast<double>(step);
    CallRecord call;
    call.side = step % 2 == 0 ? SideName::Mbs : SideName::Fem;
    call.kind = CallKind::Advance;
    call.macro_step = step;
    call.motions.end = test::some_motions(1, 0.1 * static_cast<double>(step));
    journal.calls = {call, call};
    return journal;
  }

  void write(std::int64_t steps, bool finish = true) const {
    LogWriter log(file_, 0xabcdef0123456789ULL, {"name: lug\n", "tandem 0.1.0\n"});
    for (std::int64_t step = 1; step <= steps; ++step) log.write(journal(step));
    if (finish) log.write(Finished{3, "diverged", "{\"a\":1}"});
  }

  [[nodiscard]] std::string bytes() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void replace(const std::string& content) const {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << content;
  }

  std::filesystem::path file_;
};

TEST_F(WireLog, GivesBackWhatWasWritten) {
  write(3);
  LogReader log(file_);
  EXPECT_EQ(log.scenario().scenario_yaml, "name: lug\n");
  EXPECT_EQ(log.scenario().versions, "tandem 0.1.0\n");
  EXPECT_EQ(log.run_id(), 0xabcdef0123456789ULL);
  for (std::int64_t step = 1; step <= 3; ++step) {
    const auto back = log.next_step();
    ASSERT_TRUE(back.has_value());
    ASSERT_EQ(back->calls.size(), 2U);
    EXPECT_EQ(back->calls[1].motions.end.at(0).p_WP, journal(step).calls[1].motions.end[0].p_WP);
    EXPECT_EQ(back->step.residual_N, 0.5 * static_cast<double>(step));
  }
  EXPECT_FALSE(log.next_step().has_value());
  ASSERT_TRUE(log.finished().has_value());
  EXPECT_EQ(log.finished()->exit_code, 3);
  EXPECT_EQ(log.finished()->summary_json, "{\"a\":1}");
}

// The recorder writes what the driver encoded: the same file but for the time stamps.
TEST_F(WireLog, HoldsTheSameWhetherEncodedHereOrReceived) {
  const auto payloads = [this] {
    LogReader log(file_);
    std::vector<Bytes> events;
    while (auto event = log.next_raw()) {
      event->header.time_us = 0;
      seal_as(event->header, event->payload);
      events.push_back(event->payload);
    }
    return events;
  };
  write(3);
  const std::vector<Bytes> encoded = payloads();
  {
    LogWriter log(file_, 0xabcdef0123456789ULL, {"name: lug\n", "tandem 0.1.0\n"});
    auto message = std::make_shared<Bytes>();
    begin_journal(*message);
    for (std::int64_t step = 1; step <= 3; ++step) append(journal(step), *message);
    end_journal({.run_id = 5, .kind = Kind::Journal}, *message);
    const auto received = decode_journal(message);
    ASSERT_TRUE(received.has_value());
    ASSERT_EQ(received->size(), 3U);
    for (const StepJournal& step : *received) log.write(step);
    log.write(Finished{3, "diverged", "{\"a\":1}"});
  }
  EXPECT_EQ(payloads(), encoded);
}

TEST_F(WireLog, IsReadableByLiblcm) {
  write(3);
  lcm_eventlog_t* log = lcm_eventlog_create(file_.c_str(), "r");
  ASSERT_NE(log, nullptr);
  std::vector<std::string> channels;
  while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
    EXPECT_EQ(event->eventnum, static_cast<std::int64_t>(channels.size()));
    channels.emplace_back(event->channel, static_cast<std::size_t>(event->channellen));
    lcm_eventlog_free_event(event);
  }
  lcm_eventlog_destroy(log);
  ASSERT_EQ(channels.size(), 11U);
  EXPECT_EQ(channels[0], "TANDEM_abcdef0123456789_orchestrator_scenario");
  EXPECT_EQ(channels[1], "TANDEM_abcdef0123456789_fem_call");
  EXPECT_EQ(channels[3], "TANDEM_abcdef0123456789_orchestrator_step");
  EXPECT_EQ(channels[4], "TANDEM_abcdef0123456789_mbs_call");
  EXPECT_EQ(channels[10], "TANDEM_abcdef0123456789_orchestrator_finished");
}

// Calls that begin at the last accepted input of their side are logged without their begin, those
// that do not, with it; a reader gets all of them whole. A log that has every begin reads the same.
TEST_F(WireLog, GivesBackTheBeginsThatItLeavesOut) {
  const MotionSet a = test::some_motions(2, 0.1);
  const MotionSet b = test::some_motions(2, 0.2);
  const MotionSet c = test::some_motions(2, 0.3);
  CallRecord first;
  first.side = SideName::Fem;
  first.motions.end = a;
  first.accepted = true;
  CallRecord discarded = first;
  discarded.kind = CallKind::Advance;
  discarded.macro_step = 1;
  discarded.motions = {a, c};
  discarded.accepted = false;
  CallRecord known = discarded;
  known.motions = {a, b};
  known.accepted = true;
  CallRecord other = known;  // as after a change of the prediction: begins elsewhere
  other.macro_step = 2;
  other.motions = {c, a};
  StepJournal start;
  start.calls = {first};
  StepJournal one;
  one.step.macro_step = 1;
  one.calls = {discarded, known};
  StepJournal two;
  two.step.macro_step = 2;
  two.calls = {other};
  {
    LogWriter log(file_, 1, {"", ""});
    for (const StepJournal& journal : {start, one, two}) log.write(journal);
  }
  std::vector<std::size_t> begins;
  LogReader raw(file_);
  while (const auto event = raw.next_raw()) {
    if (const auto call = decode_call(event->payload)) begins.push_back(call->motions.begin.size());
  }
  EXPECT_EQ(begins, (std::vector<std::size_t>{0, 0, 0, 2}));
  LogReader log(file_);
  for (const StepJournal& journal : {start, one, two}) {
    const auto back = log.next_step();
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(encode({}, *back), encode({}, journal));
  }
}

// What a killed run leaves: everything up to the last whole event is there, at every cut.
TEST_F(WireLog, SurvivesACutAtEveryByteOfTheLastStep) {
  write(2, false);
  const std::size_t before = bytes().size();
  write(3, false);
  const std::string whole = bytes();
  for (std::size_t size = whole.size() - 1; size >= before; --size) {
    std::filesystem::resize_file(file_, size);
    LogReader log(file_);
    std::int64_t steps = 0;
    while (log.next_step()) ++steps;
    ASSERT_EQ(steps, 2) << "cut at byte " << size;
    ASSERT_TRUE(log.truncated());
  }
}

// A flip in the lengths of an event can make it reach behind the end of the file: then the log
// looks cut short, which is reported too. It never reads as a whole one.
TEST_F(WireLog, EveryFlippedByteIsNoticed) {
  write(1);
  const std::string whole = bytes();
  std::fstream bad(file_, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](std::size_t at, char byte) {
    bad.seekp(static_cast<std::streamoff>(at)).put(byte).flush();
  };
  for (std::size_t at = 0; at < whole.size(); ++at) {
    put(at, static_cast<char>(whole[at] ^ 0x10));
    bool noticed = false;
    try {
      LogReader log(file_);
      while (log.next()) {
      }
      noticed = log.truncated();
    } catch (const Error& error) {
      noticed = error.kind() == ErrorKind::Usage;
    }
    ASSERT_TRUE(noticed) << "flip at byte " << at;
    put(at, whole[at]);
  }
}

TEST_F(WireLog, DamageIsReportedAtItsEventAndMacroStep) {
  write(5);
  std::string content = bytes();
  // The first event behind the record of macro step 3 is number 10: scenario, 3 × (2 calls, step).
  std::size_t at = 0;
  for (int event = 0; event < 10; ++event) at = content.find("\xED\xA1\xDA\x01", at + 1);
  content[at + 150] = static_cast<char>(content[at + 150] ^ 1);
  replace(content);
  LogReader log(file_);
  for (int step = 1; step <= 3; ++step) ASSERT_TRUE(log.next_step().has_value());
  try {
    log.next_step();
    FAIL() << "damage not noticed";
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("event 10 (in macro step 4)"), std::string::npos) << text;
    EXPECT_NE(text.find("checksum"), std::string::npos) << text;
  }
}

TEST_F(WireLog, IsReadableUpToTheLastStepWithoutClosing) {
  LogWriter log(file_, 1, {"", ""});
  log.write(journal(1));
  LogReader reader(file_);
  EXPECT_TRUE(reader.next_step().has_value());
}

TEST_F(WireLog, AFullDiskIsAnErrorThatNamesTheFile) {
  try {
    LogWriter log("/dev/full", 1, {"", ""});
    FAIL() << "writing to a full disk went unnoticed";
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("/dev/full"), std::string::npos) << text;
    EXPECT_NE(text.find("No space left"), std::string::npos) << text;
  }
}

TEST_F(WireLog, OtherFilesAreRefused) {
  EXPECT_THROW(LogReader("/nonexistent.lcm"), Error);
  replace("macro_step_s,residual_N\n0,1\n0,1\n0,1\n");
  EXPECT_THROW(LogReader{file_}, Error);
  replace("");
  EXPECT_THROW(LogReader{file_}, Error);
}

}  // namespace
}  // namespace tandem::wire

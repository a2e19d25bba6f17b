#include "protocol/driver/control_inbox.h"

#include <gtest/gtest.h>

#include <set>

#include "protocol/contract/error.h"

namespace tandem {
namespace {

using wire::Kind;
using wire::Process;

class ControlInboxTest : public testing::Test {
 protected:
  /// Publishes a command and lets the inbox hear it.
  void send(std::int64_t number, const std::string& text) {
    wire::Bytes bytes =
        wire::encode(wire::Control{.header = tool.header(Kind::Control, number), .text = text});
    tool.publish(Process::Fem, Kind::Control, bytes);
    driver.pump(0.1);
  }

  std::uint64_t run = wire::random_run_id();
  int port = wire::free_port();
  wire::Bus driver{{.self = Process::Mbs, .run_id = run, .port = port}};
  wire::Bus tool{{.self = Process::Tool, .run_id = run, .port = port}};
  ControlInbox inbox{driver};
};

// Senders repeat their commands: those that find no room are made later.
TEST_F(ControlInboxTest, HoldsABoundedNumberAndLosesNoneThatIsRepeated) {
  constexpr std::int64_t kCommands = 200;
  std::set<std::int64_t> made;
  for (int round = 0; round < 4; ++round) {
    for (std::int64_t number = 1; number <= kCommands; ++number) send(number, "fix tip");
    const std::vector<Command> open = inbox.take();
    EXPECT_LE(open.size(), 64U);
    for (std::int64_t number = 1; number <= kCommands; ++number) send(number, "fix tip");
    EXPECT_TRUE(inbox.take().empty());  // as many as may be are open, or all were made
    for (const Command& command : open) {
      EXPECT_TRUE(made.insert(command.number).second) << command.number << " was made twice";
      inbox.answer(command, round, {.accepted = true, .message = "held", .cost = {}});
    }
  }
  EXPECT_EQ(made.size(), static_cast<std::size_t>(kCommands));
}

TEST_F(ControlInboxTest, ATextThatIsNoCommandIsDropped) {
  send(1, std::string(50000, 'x'));
  EXPECT_TRUE(inbox.take().empty());
  EXPECT_THROW(send_command(tool, std::string(5000, 'x'), 0.1), Error);
}

}  // namespace
}  // namespace tandem

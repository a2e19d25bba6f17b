#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <sstream>
#include <thread>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/wire/bus.h"
#include "protocol/wire/journal_receiver.h"
#include "protocol/wire/messages.h"
#include "protocol/wire/multicast_socket.h"
#include "tests/support/tandem_process.h"

// Messages on the bus of a real run that its processes did not send: whatever they are, the run
// ends with an exit code and a cause, or goes on.
namespace tandem::test {
namespace {

using wire::Kind;
using wire::Process;

/// A run that goes on, and a bus of its own on which to speak.
class RunStrangers : public testing::TestWithParam<std::string> {
 protected:
  void start(const std::string& driver) {
    run = std::make_unique<ChildProcess>(run_of(
        "two_masses", folder / "run", {"--set", "run.duration_s=10000", "--driver", driver}));
    for (int i = 0; i < 2000 && bus == nullptr; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const std::string text = read_file(folder / "run/bus.json");
      const auto address = nlohmann::json::parse(text, nullptr, false);
      if (address.is_discarded()) continue;
      bus = std::make_unique<wire::Bus>(
          wire::BusOptions{.self = Process::Tool,
                           .run_id = std::stoull(address.value("run_id", ""), nullptr, 16),
                           .port = address.value("port", 0)});
    }
    ASSERT_NE(bus, nullptr);
  }

  TemporaryFolder folder{"tandem_strangers"};
  std::unique_ptr<ChildProcess> run;
  std::unique_ptr<wire::Bus> bus;
};

// A bye that tandem-fem did not get from its driver: its answer has the number of the driver's next
// request, and no wrenches.
TEST_P(RunStrangers, AByeInMidRunEndsItWithTheCause) {
  start(GetParam());
  std::int64_t steps = 0;
  const auto requests =
      bus->subscribe(Process::Fem, Kind::Request, [&](const wire::Header& header, wire::ByteView) {
        if (++steps < 20) return;
        wire::Request bye{.header = bus->header(Kind::Request, header.sequence + 1),
                          .call = wire::RequestKind::Bye};
        wire::Bytes message = wire::encode(bye);
        bus->publish(Process::Fem, Kind::Request, message);
      });
  int code = -1;
  for (int i = 0; i < 2000 && code == -1; ++i) {
    bus->pump(0.01);
    code = run->wait(0.0);
  }
  EXPECT_EQ(code, 4) << run->output();
  EXPECT_NE(run->output().find("Is a second driver on this run?"), std::string::npos)
      << run->output();
  EXPECT_EQ(run->output().find("signal 11"), std::string::npos) << run->output();
  EXPECT_TRUE(processes_with(folder.path().string()).empty());
}

INSTANTIATE_TEST_SUITE_P(Drivers, RunStrangers, testing::Values("mbs", "orchestrator"),
                         [](const auto& test) { return test.param; });

/// Both sides of a run, started by hand, and a recorder in place of `tandem`, which says hello with
/// `version`, or not at all when it is empty.
class AnotherTandem : public testing::Test {
 protected:
  void expect_refusal(const std::string& version, int exit_code, const std::string& words) {
    ASSERT_EQ(run_command(run_of("two_masses", folder / "run",
                                 {"--set", "run.duration_s=0.003", "--transport", "inproc", "--set",
                                  "wire.start_timeout_s=1"}))
                  .code,
              0);
    wire::Bus bus({.self = Process::Orchestrator,
                   .run_id = wire::random_run_id(),
                   .port = wire::free_port()});
    const wire::Heartbeat heartbeat(bus, 5.0);
    const auto side = [&](const std::string& name) {
      return std::make_unique<ChildProcess>(std::vector<std::string>{
          TANDEM_BIN_DIR "/tandem-" + name, "--scenario", (folder / "run/scenario.yaml").string(),
          "--run", fmt_hex(bus.options().run_id), "--port", std::to_string(bus.options().port)});
    };
    const auto mbs = side("mbs");
    const auto fem = side("fem");
    wire::LivenessMonitor monitor(bus, {Process::Mbs, Process::Fem}, 10.0);
    wire::JournalReceiver receiver(bus, monitor, 64);
    const double end_s = now_s() + 10.0;
    int code = -1;
    while (code == -1 && now_s() < end_s) {
      if (!version.empty()) say_hello(bus, version);
      try {
        while (receiver.next(0.02)) receiver.recorded();
      } catch (const Error&) {  // it may say why before it goes
      }
      code = mbs->wait(0.0);
    }
    EXPECT_EQ(code, exit_code) << mbs->output();
    EXPECT_NE(mbs->output().find(words), std::string::npos) << mbs->output();
  }

 private:
  static std::string fmt_hex(std::uint64_t number) {
    std::ostringstream text;
    text << std::hex << number;
    return text.str();
  }
  static void say_hello(wire::Bus& bus, const std::string& version) {
    wire::Handshake hello;
    hello.header = bus.header(Kind::Hello, 1);
    hello.tandem_version = version;
    wire::Bytes bytes = wire::encode(hello);
    bus.publish(Process::Mbs, Kind::Hello, bytes);
  }

  TemporaryFolder folder{"tandem_another"};
};

TEST_F(AnotherTandem, OfAnotherVersionIsRefusedByTheDriver) {
  expect_refusal("0.0.9", 2, "Tandem 0.0.9 there, ");
}

TEST_F(AnotherTandem, ThatSaysNoHelloGetsNoStep) {
  expect_refusal("", 4, "lives, but has not said hello within 1 s");
}

}  // namespace
}  // namespace tandem::test

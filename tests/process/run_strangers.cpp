#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "protocol/wire/bus.h"
#include "protocol/wire/messages.h"
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

}  // namespace
}  // namespace tandem::test

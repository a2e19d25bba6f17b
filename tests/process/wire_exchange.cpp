#include <gtest/gtest.h>

#include <thread>

#include "protocol/wire/remote_side.h"
#include "protocol/wire/server.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

TEST(WireExchange, RemoteSideGivesTheBitsOfTheLocalSide) {
  const std::uint64_t run = random_run_id();
  const int port = free_port();
  test::CountingFem served;
  std::thread server([&] {
    Bus bus({.self = Process::Fem, .run_id = run, .port = port});
    Heartbeat heartbeat(bus, 5.0);
    LivenessMonitor monitor(bus, {Process::Mbs}, 5.0);
    serve(served, bus, monitor, {.heartbeat = &heartbeat});
  });
  Bus bus({.self = Process::Mbs, .run_id = run, .port = port});
  Heartbeat heartbeat(bus, 5.0);
  LivenessMonitor monitor(bus, {Process::Fem}, 5.0);
  RemoteFem fem(bus, monitor, {.port_names = {"p0", "p1"}});
  EXPECT_EQ(fem.info().name, "fem");
  const std::uint64_t remote = test::drive(fem, 200, 3);
  fem.close();
  server.join();

  test::CountingFem local;
  EXPECT_EQ(remote, test::drive(local, 200, 3));
  EXPECT_EQ(served.advances, local.advances);
  EXPECT_EQ(served.checkpoints, local.checkpoints);
  EXPECT_EQ(served.rollbacks, local.rollbacks);
}

}  // namespace
}  // namespace tandem::wire

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <lcm/lcm.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

#include "protocol/wire/remote_side.h"
#include "protocol/wire/server.h"
#include "tests/support/child_process.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

constexpr double kTimeout_s = 5.0;
const RemoteOptions kTwoPorts{.port_names = {"p0", "p1"}};

/// A served mock in a thread of its own.
class FemThread {
 public:
  FemThread(std::uint64_t run, int port)
      : thread_([this, run, port] {
          Bus bus({.self = Process::Fem, .run_id = run, .port = port});
          Heartbeat heartbeat(bus, kTimeout_s);
          LivenessMonitor monitor(bus, {Process::Mbs}, kTimeout_s);
          try {
            serve(side, bus, monitor, {.heartbeat = &heartbeat});
          } catch (const Error& caught) {
            error = caught.what();
          }
          counts = bus.counts();
        }) {}
  void join() { thread_.join(); }

  test::CountingFem side;
  BusCounts counts;
  std::string error;

 private:
  std::thread thread_;
};

/// The driver's end.
struct Driver {
  Driver(std::uint64_t run, int port)
      : bus({.self = Process::Mbs, .run_id = run, .port = port}),
        heartbeat(bus, kTimeout_s),
        monitor(bus, {Process::Fem}, kTimeout_s) {}
  Bus bus;
  Heartbeat heartbeat;
  LivenessMonitor monitor;
};

std::size_t threads_of_this_process() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
}

TEST(WireExchange, RemoteSideGivesTheBitsAndCallsOfTheLocalSide) {
  const std::uint64_t run = random_run_id();
  const int port = free_port();
  FemThread served(run, port);
  Driver driver(run, port);
  RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
  EXPECT_EQ(fem.info().name, "fem");
  EXPECT_EQ(fem.info().micro_step, SimTime(1000000));
  EXPECT_EQ(fem.info().ports.at(1).length_m, 0.25);
  EXPECT_TRUE(fem.info().can_linearize);
  const std::uint64_t remote = test::drive(fem, 200, 3);
  fem.close();
  served.join();

  test::CountingFem local;
  EXPECT_EQ(remote, test::drive(local, 200, 3));
  EXPECT_EQ(served.side.advances, local.advances);
  EXPECT_EQ(served.side.checkpoints, local.checkpoints);
  EXPECT_EQ(served.side.rollbacks, local.rollbacks);
}

// All calls of a side but initialize() may come in any order: what the flags carry must do the
// same.
TEST(WireExchange, RollbackBeforeCheckpointIsNotLost) {
  const std::uint64_t run = random_run_id();
  const int port = free_port();
  FemThread served(run, port);
  Driver driver(run, port);
  RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
  test::CountingFem local;
  const auto play = [](FemSide& side) {
    const MotionSet motions = test::some_motions(2, 0.3);
    const StepRequest<MotionSet> step{.step = SimTime(1000000), .input = {motions, motions}};
    side.initialize(motions);
    side.checkpoint();
    side.advance(step);
    side.rollback();
    side.checkpoint();
    side.rollback();
    side.advance(step);
    side.checkpoint();
    side.advance(step);
    side.rollback();
    return side.observe().state_hash;
  };
  EXPECT_EQ(play(fem), play(local));
  fem.close();
  served.join();
}

// The parts of one exchange's cost are durations and add up to what the caller waited.
TEST(WireExchange, CostOfACallAddsUpToItsWallTime) {
  const std::uint64_t run = random_run_id();
  const int port = free_port();
  FemThread served(run, port);
  served.side.on_advance = [](std::int64_t) {
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  };
  Driver driver(run, port);
  RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
  const MotionSet motions = test::some_motions(2, 0.3);
  fem.initialize(motions);
  double wall_s = 0.0;
  CallCost cost;
  for (int i = 0; i < 50; ++i) {
    const double begin_s = now_s();
    cost += fem.advance({.step = SimTime(1000000), .input = {motions, motions}}).cost;
    wall_s += now_s() - begin_s;
  }
  fem.close();
  served.join();
  EXPECT_GE(cost.compute_s, 0.15);
  const double named_s =
      cost.compute_s + cost.encode_s + cost.decode_s + cost.publish_s + cost.transit_s;
  // Left out: copying the inputs into the request and the result out of the reply.
  EXPECT_NEAR(named_s, wall_s, 0.02 * wall_s);
  EXPECT_GE(cost.messages, 100);
}

TEST(WireExchange, TwoRunsOnOnePortDoNotDisturbEachOther) {
  const int port = free_port();
  const std::uint64_t run_a = random_run_id();
  const std::uint64_t run_b = random_run_id();
  FemThread served_a(run_a, port);
  FemThread served_b(run_b, port);
  std::uint64_t hash_b = 0;
  std::thread driver_b([&] {
    Driver driver(run_b, port);
    RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
    hash_b = test::drive(fem, 150, 2);
    fem.close();
  });
  Driver driver(run_a, port);
  RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
  const std::uint64_t hash_a = test::drive(fem, 100, 3);
  fem.close();
  driver_b.join();
  served_a.join();
  served_b.join();
  test::CountingFem local;
  EXPECT_EQ(hash_a, test::drive(local, 100, 3));
  EXPECT_EQ(hash_b, test::drive(local, 150, 2));
  EXPECT_EQ(served_a.side.advances, 300);
  EXPECT_EQ(served_b.side.advances, 300);
  EXPECT_GT(served_a.counts.foreign, 0);
}

// Requests of an old run, put on the channel of a live one as lcm-logplayer or a mistaken tool may:
// their run id gives them away.
TEST(WireExchange, ReplayedRequestsOfAnOldRunAreNotExecuted) {
  const int port = free_port();
  const std::uint64_t run = random_run_id();
  FemThread served(run, port);
  Driver driver(run, port);
  RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
  fem.initialize(test::some_motions(2, 0.1));

  Request old;
  old.call = RequestKind::Advance;
  old.header = driver.bus.header(Kind::Request);
  old.header.run_id = run + 1;
  for (std::int64_t sequence = 1; sequence <= 50; ++sequence) {
    old.header.sequence = sequence;
    Bytes message = encode(old);
    driver.bus.publish(Process::Fem, Kind::Request, message);
  }
  const auto result =
      fem.advance({.step = SimTime(1000000),
                   .input = {test::some_motions(2, 0.1), test::some_motions(2, 0.2)}});
  EXPECT_EQ(result.outcome, Outcome::Done);
  fem.close();
  served.join();
  EXPECT_EQ(served.side.advances, 1);
  EXPECT_GE(served.counts.foreign, 50);
}

TEST(WireExchange, AGapInTheRequestNumbersEndsTheServer) {
  const int port = free_port();
  const std::uint64_t run = random_run_id();
  FemThread served(run, port);
  Driver driver(run, port);
  RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
  Request ahead;
  ahead.header = driver.bus.header(Kind::Request, 7);
  Bytes message = encode(ahead);
  driver.bus.publish(Process::Fem, Kind::Request, message);
  served.join();
  EXPECT_NE(served.error.find("request 7 (macro step 0) arrived after request 0"),
            std::string::npos)
      << served.error;
  EXPECT_EQ(served.side.advances, 0);
}

// With short time-outs a heartbeat comes more often than a wait for one takes.
TEST(WireLiveness, TheHeartbeatOfOnePartnerDoesNotHideTheSilenceOfAnother) {
  constexpr double kShort_s = 0.5;
  const std::uint64_t run = random_run_id();
  const int port = free_port();
  Bus fem({.self = Process::Fem, .run_id = run, .port = port});
  const Heartbeat heartbeat(fem, kShort_s);
  Bus bus({.self = Process::Mbs, .run_id = run, .port = port});
  LivenessMonitor monitor(bus, {Process::Fem, Process::Orchestrator}, kShort_s);
  std::string error;
  for (const double end_s = now_s() + 5.0; error.empty() && now_s() < end_s;) {
    try {
      monitor.wait(0.2);
    } catch (const Error& caught) {
      error = caught.what();
    }
  }
  EXPECT_NE(error.find("tandem (the orchestrator) has not been heard within 0.5 s"),
            std::string::npos)
      << error;
}

TEST(WireExchange, LeavesNoThreadBehind) {
  const std::size_t before = threads_of_this_process();
  {
    const std::uint64_t run = random_run_id();
    const int port = free_port();
    FemThread served(run, port);
    Driver driver(run, port);
    RemoteFem fem(driver.bus, driver.monitor, kTwoPorts);
    EXPECT_GT(threads_of_this_process(), before);
    fem.close();
    served.join();
  }
  EXPECT_EQ(threads_of_this_process(), before);
}

// We receive through our own socket: any LCM program must hear us and be heard.
TEST(WireBus, SpeaksWithPlainLiblcmBothWays) {
  const int port = free_port();
  const std::string url = "udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0";
  lcm_t* other = lcm_create(url.c_str());
  ASSERT_NE(other, nullptr);
  Bytes heard_there;
  const auto listen = [](const lcm_recv_buf_t* received, const char*, void* user) {
    const auto* data = static_cast<const std::uint8_t*>(received->data);
    static_cast<Bytes*>(user)->assign(data, data + received->data_size);
  };
  ASSERT_NE(lcm_subscribe(other, "TANDEM_0000000000000007_mbs_credit", listen, &heard_there),
            nullptr);

  Bus bus({.self = Process::Mbs, .run_id = 7, .port = port});
  Bytes message = encode(Credit{bus.header(Kind::Credit, 3), 4, 5});
  bus.publish(Process::Mbs, Kind::Credit, message);
  for (int i = 0; i < 20 && heard_there.empty(); ++i) lcm_handle_timeout(other, 100);
  EXPECT_EQ(heard_there, message);

  std::int64_t heard_here = 0;
  const Subscription subscription =
      bus.subscribe(Process::Fem, Kind::Credit, [&](const Header& header, ByteView bytes) {
        EXPECT_EQ(header.sequence, 3);
        heard_here = decode_credit(bytes)->recorded_through;
      });
  lcm_publish(other, "TANDEM_0000000000000007_fem_credit", message.data(),
              static_cast<unsigned>(message.size()));
  for (int i = 0; i < 20 && heard_here == 0; ++i) bus.pump(0.1);
  EXPECT_EQ(heard_here, 4);
  lcm_destroy(other);
}

TEST(WireBus, ReportsTheReceiveBufferThatWasGranted) {
  const Bus bus({.self = Process::Mbs, .run_id = 1, .port = free_port()});
  // The kernel books twice what was asked for, at most twice net.core.rmem_max.
  EXPECT_GT(bus.receive_buffer_bytes(), 0);
  EXPECT_LE(bus.receive_buffer_bytes(), 2 * bus.options().receive_buffer_bytes);
}

TEST(WireBus, DoesNotHearItselfAfterOpening) {
  Bus bus({.self = Process::Mbs, .run_id = 1, .port = free_port()});
  int heard = 0;
  const Subscription subscription =
      bus.subscribe(Process::Mbs, Kind::Credit, [&](const Header&, ByteView) { ++heard; });
  Bytes message = encode(Credit{bus.header(Kind::Credit, 1), 0, 0});
  bus.publish(Process::Mbs, Kind::Credit, message);
  while (bus.pump(0.05)) {
  }
  EXPECT_EQ(heard, 0);
}

TEST(WireBus, APortThatIsTakenIsAUsageError) {
  const int port = free_port();
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  try {
    const Bus bus({.self = Process::Mbs, .run_id = 1, .port = port});
    ADD_FAILURE() << "opened on a port that another program holds";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(std::strstr(error.what(), "another program holds the port"), nullptr);
  }
  close(fd);
}

/// Interfaces of this network namespace that have joined LCM's group.
std::vector<std::string> joined_interfaces() {
  std::vector<std::string> joined;
  std::ifstream table("/proc/net/igmp");
  std::string interface;
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::string first, second;
    words >> first >> second;
    if (line.starts_with('\t')) {
      if (first == "434CFFEF") joined.push_back(interface);  // 239.255.76.67, low byte first
    } else {
      interface = second;
    }
  }
  return joined;
}

// Time to live 0: neither do messages leave the host, nor are any heard from outside, although the
// group's route leads to a network card.
TEST(WireBus, ThatStaysOnTheHostListensOnTheLoopbackInterfaceAlone) {
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWNET) != 0) _exit(77);
    const char* network =
        "ip link set lo up && ip link add card type veth peer name other && ip addr add "
        "10.9.0.1/24 "
        "dev card && ip link set card up && ip link set other up && ip route add 224.0.0.0/4 dev "
        "card";
    if (std::system(network) != 0) _exit(77);
    bool here = true;
    for (const Receive receive : {Receive::Own, Receive::Lcm}) {
      const Bus bus({.self = Process::Mbs, .run_id = 1, .port = 20000, .receive = receive});
      here = here && joined_interfaces() == std::vector<std::string>{"lo"};
    }
    const Bus wide({.self = Process::Mbs, .run_id = 1, .port = 20000, .ttl = 1});
    const bool there = joined_interfaces().size() == 2;
    _exit((here ? 0 : 1) + (there ? 0 : 2));
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "no network namespace with a card can be made";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

// In an empty network namespace there is no route at all.
TEST(WireBus, AMissingRouteIsTheMachinesErrorWithTheRemedy) {
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) _exit(77);
    try {
      const Bus bus({.self = Process::Mbs, .run_id = 1, .port = 20000});
    } catch (const Error& error) {
      const bool tells = std::strstr(error.what(), "ip route add 224.0.0.0/4 dev lo") != nullptr;
      _exit(tells && error.kind() == ErrorKind::System ? 0 : 1);
    }
    _exit(2);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "network namespaces are not permitted here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace tandem::wire

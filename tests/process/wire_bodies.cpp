// Several bodies behind one driver: one message asks all of them, each call is made once whoever
// answers first, a late one is asked again alone, and who is missing is named.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <thread>

#include "protocol/contract/error.h"
#include "protocol/driver/composite_side.h"
#include "protocol/driver/remote_bodies.h"
#include "protocol/wire/server.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

void pause_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

struct Bodies {
  explicit Bodies(std::size_t count) {
    for (std::size_t b = 0; b < count; ++b) {
      table.push_back({"body" + std::to_string(b + 1), {2 * b, 2 * b + 1}});
      port_names.insert(port_names.end(), {"p0", "p1"});
    }
  }
  [[nodiscard]] Process process(std::size_t b) const { return body_process(b, table.size()); }
  [[nodiscard]] BusOptions bus(Process self) const {
    return {.self = self, .run_id = run, .port = port, .names = process_names(table, {})};
  }

  std::vector<scenario::BodyPorts> table;
  std::vector<std::string> port_names;
  std::uint64_t run = random_run_id();
  int port = free_port();
};

/// A body served in a thread of its own.
class BodyThread {
 public:
  BodyThread(const Bodies& all, std::size_t number,
             std::function<void(BodyThread&, std::int64_t)> on_advance)
      : thread_([this, &all, number, on_advance = std::move(on_advance)] {
          Bus bus(all.bus(all.process(number)));
          heartbeat.emplace(bus, 1.0);
          LivenessMonitor monitor(bus, {Process::Mbs}, 5.0);
          side.on_advance = [&](std::int64_t n) { on_advance(*this, n); };
          try {
            serve(side, bus, monitor, {});
          } catch (const Error& error) {
            said = error.what();
          }
          heartbeat.reset();
        }) {}
  ~BodyThread() { thread_.join(); }

  test::CountingFem side;
  std::optional<Heartbeat> heartbeat;
  std::string said;

 private:
  std::thread thread_;
};

/// The driver's end.
struct Driver {
  explicit Driver(const Bodies& all, double timeout_s = 5.0)
      : bus(all.bus(Process::Mbs)),
        heartbeat(bus, 1.0),
        monitor(bus, processes_of(all.table), timeout_s),
        fem(bus, monitor, all.table, {.port_names = all.port_names}) {}
  Bus bus;
  Heartbeat heartbeat;
  LivenessMonitor monitor;
  RemoteBodies fem;
};

/// Counts what the driver sends.
class Listener {
 public:
  explicit Listener(const Bodies& all)
      : bus_(all.bus(Process::Tool)), thread_([this, &all] { listen(all); }) {
    while (!listens_) pause_s(0.001);
  }
  void stop() {
    stop_ = true;
    thread_.join();
  }
  std::int64_t together = 0;
  std::int64_t alone = 0;  ///< of those that are no repetitions

 private:
  void listen(const Bodies& all) {
    std::vector<Subscription> heard;
    heard.push_back(bus_.subscribe(Process::Fem, Kind::Requests,
                                   [this](const Header&, ByteView) { ++together; }));
    for (std::size_t b = 0; b < all.table.size(); ++b) {
      heard.push_back(bus_.subscribe(
          all.process(b), Kind::Request,
          [this](const Header& header, ByteView) { alone += header.attempt == 0 ? 1 : 0; }));
    }
    listens_ = true;
    while (bus_.pump(0.02) || !stop_) {
    }
  }
  Bus bus_;
  std::atomic<bool> listens_{false}, stop_{false};
  std::thread thread_;
};

std::uint64_t drive_here(std::size_t count, int steps, int iterations) {
  std::vector<FemPart> parts;
  for (std::size_t b = 0; b < count; ++b) {
    parts.push_back({"body" + std::to_string(b + 1),
                     std::make_unique<test::CountingFem>(),
                     {2 * b, 2 * b + 1}});
  }
  CompositeFem local(std::move(parts));
  return test::drive(local, steps, iterations);
}

TEST(WireBodies, AnsweringInAnyOrderHaveTheBitsOfLocalOnes) {
  constexpr std::size_t kCount = 4;
  constexpr int kSteps = 30, kIterations = 3;
  const Bodies all(kCount);
  std::mutex mutex;
  std::vector<std::size_t> order;
  std::set<std::size_t> first;  // bodies that were the first to answer
  Listener listener(all);
  std::vector<std::unique_ptr<BodyThread>> served;
  for (std::size_t b = 0; b < kCount; ++b) {
    auto random = std::make_shared<std::mt19937>(static_cast<unsigned>(b + 1));
    served.push_back(std::make_unique<BodyThread>(all, b, [&, random, b](BodyThread&, auto) {
      pause_s(1e-6 * static_cast<double>((*random)() % 3000U));
      const std::lock_guard lock(mutex);
      if (order.size() % kCount == 0) first.insert(b);
      order.push_back(b);
    }));
  }
  std::uint64_t hash = 0;
  {
    Driver driver(all);
    hash = test::drive(driver.fem.side(), kSteps, kIterations);
    driver.fem.close();
  }
  served.clear();
  listener.stop();
  EXPECT_EQ(hash, drive_here(kCount, kSteps, kIterations));
  EXPECT_EQ(first.size(), kCount) << "each of them answered first in one of 90 evaluations";
  EXPECT_EQ(order.size(), kCount * kSteps * kIterations) << "no call was made twice";
  EXPECT_EQ(listener.together, kSteps * kIterations);
  EXPECT_EQ(listener.alone, static_cast<std::int64_t>(3 * kCount)) << "initialize, observe, bye";
}

/// A body that does not hear what is sent to all, as if the network had lost it.
class DeafBody {
 public:
  DeafBody(const Bodies& all, std::size_t number)
      : thread_([this, &all, number] { answer(all, number); }) {}
  ~DeafBody() {
    stop_ = true;
    thread_.join();
  }
  std::atomic<int> advances{0}, first_attempts{0};

 private:
  void answer(const Bodies& all, std::size_t number) {
    const Process self = all.process(number);
    Bus bus(all.bus(self));
    const Heartbeat heartbeat(bus, 1.0);
    const test::CountingFem side;
    const HelloServer hello(bus, side.info(), 0, {});
    const Subscription requests =
        bus.subscribe(self, Kind::Request, [&](const Header& header, ByteView message) {
          const auto request = decode_request(message);
          Reply reply;
          reply.header = bus.header(Kind::Reply, header.sequence);
          reply.header.macro_step = header.macro_step;
          reply.header.iteration = header.iteration;
          if (request->call == RequestKind::Advance) {
            ++advances;
            first_attempts += header.attempt == 0 ? 1 : 0;
          }
          if (request->call <= RequestKind::Advance) reply.wrenches.resize(2);
          Bytes bytes = encode(reply);
          bus.publish(self, Kind::Reply, bytes);
        });
    while (!stop_) bus.pump(0.02);
  }
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// Body 1 computes for long; what body 2 has lost is sent again meanwhile, and to it alone.
TEST(WireBodies, ALateOneIsAskedAgainWhileAnotherIsWaitedFor) {
  const Bodies all(3);
  DeafBody deaf(all, 1);
  std::atomic<int> heard_before_first{-1};
  BodyThread slow(all, 0, [&](BodyThread&, std::int64_t) {
    pause_s(0.4);
    heard_before_first = deaf.advances.load();
  });
  BodyThread quick(all, 2, [](BodyThread&, std::int64_t) {});
  Listener listener(all);
  Driver driver(all);
  FemSide& fem = driver.fem.side();
  const MotionSet motions = test::some_motions(6, 0.5);
  (void)fem.initialize(motions);
  fem.checkpoint();
  const auto result = fem.advance({.step = SimTime(1000000), .input = {motions, motions}});
  EXPECT_EQ(result.outcome, Outcome::Done);
  EXPECT_GE(heard_before_first, 1);
  EXPECT_EQ(deaf.first_attempts, 0);
  driver.fem.close();
  listener.stop();
  EXPECT_EQ(listener.together, 1);
  EXPECT_EQ(slow.side.advances, 1);
  EXPECT_EQ(quick.side.advances, 1);
}

TEST(WireBodies, AllWhoAreMissingAreNamedWithWhatTheyWereDoing) {
  const Bodies all(3);
  std::atomic<bool> over{false};
  const auto falls_silent = [&](BodyThread& body, std::int64_t n) {
    if (n < 2) return;
    body.heartbeat.reset();
    while (!over) pause_s(0.01);
  };
  BodyThread one(all, 0, falls_silent);
  BodyThread two(all, 1, [](BodyThread&, std::int64_t) {});
  BodyThread three(all, 2, falls_silent);
  std::string said;
  {
    Driver driver(all, 1.0);
    try {
      (void)test::drive(driver.fem.side(), 1, 3);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Partner);
      said = error.what();
    }
    publish_abort(driver.bus, 4, "ended");
  }
  over = true;
  for (const char* words : {"nothing heard from tandem-fem body", "is not heard either",
                            "tandem-fem body1", "tandem-fem body3", "tandem-fem body2 lives",
                            "has answered", "iteration 2, and has not answered"}) {
    EXPECT_NE(said.find(words), std::string::npos) << words << "\n" << said;
  }
}

}  // namespace
}  // namespace tandem::wire

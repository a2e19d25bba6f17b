#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "protocol/wire/remote_side.h"
#include "protocol/wire/server.h"
#include "tests/support/wire_mock_sides.h"

// Messages with a good seal that are not what the run's own processes would have sent: a second
// driver, a side of another build. Each end checks their sizes against the port table.
namespace tandem::wire {
namespace {

constexpr double kTimeout_s = 5.0;
const RemoteOptions kTwoPorts{.port_names = {"p0", "p1"}};

/// What the call of `use` threw; empty when it threw nothing.
std::string error_of(const std::function<void()>& use) {
  try {
    use();
    return {};
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Partner);
    return error.what();
  }
}

class WireStrangers : public testing::Test {
 protected:
  std::uint64_t run = random_run_id();
  int port = free_port();
  Bus mbs{{.self = Process::Mbs, .run_id = run, .port = port}};
  Heartbeat mbs_heartbeat{mbs, kTimeout_s};
  LivenessMonitor mbs_monitor{mbs, {Process::Fem}, kTimeout_s};
};

/// Answers the handshake, and each request by `answer`, until it goes out of scope.
class StrangeFem {
 public:
  StrangeFem(std::uint64_t run, int port, std::function<void(const Request&, Reply&)> answer)
      : thread_([this, run, port, answer = std::move(answer)] {
          Bus bus({.self = Process::Fem, .run_id = run, .port = port});
          const auto hello =
              bus.subscribe(Process::Fem, Kind::Hello, [&](const Header&, ByteView message) {
                Handshake welcome = decode_handshake(message).value();
                welcome.header = bus.header(Kind::Welcome, 1);
                welcome.can_linearize = true;
                Bytes bytes = encode(welcome);
                bus.publish(Process::Fem, Kind::Welcome, bytes);
              });
          const auto requests =
              bus.subscribe(Process::Fem, Kind::Request, [&](const Header&, ByteView message) {
                const Request request = decode_request(message).value();
                Reply reply;
                reply.header = bus.header(Kind::Reply, request.header.sequence);
                reply.header.macro_step = request.header.macro_step;
                reply.header.iteration = request.header.iteration;
                answer(request, reply);
                Bytes bytes = encode(reply);
                bus.publish(Process::Fem, Kind::Reply, bytes);
              });
          while (!stop_) bus.pump(0.01);
        }) {}
  ~StrangeFem() {
    stop_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

struct StrangeReply {
  std::string name;
  std::function<void(Reply&)> make;
  std::string words;
};
void PrintTo(const StrangeReply& reply, std::ostream* out) { *out << reply.name; }

class WireStrangeReply : public WireStrangers, public testing::WithParamInterface<StrangeReply> {};

TEST_P(WireStrangeReply, IsAPartnersError) {
  const StrangeFem fem(run, port, [](const Request& request, Reply& reply) {
    reply.wrenches.resize(2);
    if (request.call == RequestKind::Advance) GetParam().make(reply);
  });
  RemoteFem remote(mbs, mbs_monitor, kTwoPorts);
  const MotionSet motions = test::some_motions(2, 0.1);
  EXPECT_EQ(remote.initialize(motions).size(), 2U);
  const std::string error = error_of([&] {
    (void)remote.advance(
        {.step = SimTime(1000000), .input = {motions, motions}, .linearize = true});
  });
  EXPECT_NE(error.find("fem: reply 2 of tandem-fem"), std::string::npos) << error;
  EXPECT_NE(error.find(GetParam().words), std::string::npos) << error;
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, WireStrangeReply,
    testing::Values(
        StrangeReply{"NoWrenches", [](Reply& r) { r.wrenches.clear(); },
                     "holds 0 motions and 0 wrenches; the run has 2 ports"},
        StrangeReply{"TooManyWrenches", [](Reply& r) { r.wrenches.resize(3); }, "3 wrenches"},
        StrangeReply{"Motions", [](Reply& r) { r.motions.resize(2); }, "2 motions"},
        StrangeReply{"Jacobian", [](Reply& r) { r.jacobian = Eigen::MatrixXd::Zero(12, 12); },
                     "a Jacobian of 12 × 12 in place of 12 × 24"},
        StrangeReply{"AnotherStep", [](Reply& r) { r.header.macro_step = 7; },
                     "answers another request, of macro step 7"}),
    [](const auto& test) { return test.param.name; });

TEST_F(WireStrangers, AWelcomeWithoutThePortsIsRefused) {
  Bus fem({.self = Process::Fem, .run_id = run, .port = port});
  std::atomic<bool> stop{false};
  std::thread thread([&] {
    while (!stop) {
      Bytes bytes = encode(Handshake{.header = fem.header(Kind::Welcome, 1)});
      fem.publish(Process::Fem, Kind::Welcome, bytes);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  EXPECT_THROW(RemoteFem(mbs, mbs_monitor, kTwoPorts), Error);
  stop = true;
  thread.join();
}

struct StrangeRequest {
  std::string name;
  std::function<void(Request&)> make;
  std::string words;
};
void PrintTo(const StrangeRequest& request, std::ostream* out) { *out << request.name; }

class WireStrangeRequest : public WireStrangers,
                           public testing::WithParamInterface<StrangeRequest> {};

TEST_P(WireStrangeRequest, EndsTheServerBeforeItsSideIsAsked) {
  test::CountingFem side;
  std::string error;
  std::thread served([&] {
    Bus bus({.self = Process::Fem, .run_id = run, .port = port});
    const Heartbeat heartbeat(bus, kTimeout_s);
    LivenessMonitor monitor(bus, {Process::Mbs}, kTimeout_s);
    error = error_of([&] { serve(side, bus, monitor, {.linger_s = 0.1}); });
  });
  RemoteFem remote(mbs, mbs_monitor, kTwoPorts);
  remote.initialize(test::some_motions(2, 0.1));
  Request request;
  request.call = RequestKind::Advance;
  request.step = SimTime(1000000);
  request.header = mbs.header(Kind::Request, 2);
  request.motions = {test::some_motions(2, 0.1), test::some_motions(2, 0.2)};
  GetParam().make(request);
  Bytes bytes = encode(request);
  mbs.publish(Process::Fem, Kind::Request, bytes);
  served.join();
  EXPECT_NE(error.find("fem: request 2"), std::string::npos) << error;
  EXPECT_NE(error.find(GetParam().words), std::string::npos) << error;
  EXPECT_EQ(side.advances, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, WireStrangeRequest,
    testing::Values(
        StrangeRequest{"ThreePorts",
                       [](Request& r) {
                         r.motions = {test::some_motions(3, 0.1), test::some_motions(3, 0.2)};
                       },
                       "3 at its end; the run has 2 ports"},
        StrangeRequest{"NoEnd", [](Request& r) { r.motions.end.clear(); }, "0 at its end"},
        StrangeRequest{"NoInput", [](Request& r) { r.motions = {}; }, "0 at its end"},
        StrangeRequest{"NoTime", [](Request& r) { r.step = SimTime{}; }, "of 0 ns"},
        StrangeRequest{"Wrenches", [](Request& r) { r.wrenches.end.resize(2); },
                       "the run has 2 ports"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tandem::wire

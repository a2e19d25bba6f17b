#include "orchestrator/bench/exchange_benchmark.h"

#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "orchestrator/bench/ping_pong.h"
#include "orchestrator/process/child_function.h"
#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/driver/coupled_run.h"
#include "protocol/wire/arrays.h"
#include "protocol/wire/event_log.h"
#include "protocol/wire/journal_receiver.h"
#include "protocol/wire/journal_sender.h"
#include "protocol/wire/remote_side.h"
#include "protocol/wire/server.h"

namespace tandem::orchestrator {
namespace {

using wire::Process;

constexpr double kTimeout_s = 5.0;
constexpr int kCreditWindow = 64;
constexpr SimTime kStep{1000000};
constexpr const char* kVersion = "bench";

SubsystemInfo mock_info(const char* name, int nodes) {
  SubsystemInfo info{.name = name, .micro_step = kStep};
  for (int i = 0; i < nodes; ++i) info.ports.push_back({std::to_string(i), 0.1});
  return info;
}

/// A rigid side whose motions are there before they are asked for: other ones in every step.
class MockMbs final : public MbsSide {
 public:
  explicit MockMbs(int nodes) : info_(mock_info("mbs", nodes)) {
    for (int which = 0; which < 2; ++which) {
      MotionSet& motions = motions_.at(static_cast<std::size_t>(which));
      motions.resize(static_cast<std::size_t>(nodes));
      for (int i = 0; i < nodes; ++i) {
        const double x = std::sin(0.1 * i + which);
        Motion& motion = motions[static_cast<std::size_t>(i)];
        motion.p_WP = {x, 0.5 * x, -x};
        motion.v_WP = {-x, x / 3.0, x / 7.0};
      }
    }
  }
  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  MotionSet initialize(const WrenchSet&) override { return motions_[0]; }
  StepResult<MotionSet> advance(const StepRequest<WrenchSet>&) override {
    step_ ^= 1U;
    return {.outcome = Outcome::Done, .message = {}, .output = motions_.at(step_)};
  }
  void checkpoint() override { saved_ = step_; }
  void rollback() override { step_ = saved_; }
  Observation observe() override { return {}; }

 private:
  SubsystemInfo info_;
  std::array<MotionSet, 2> motions_;
  std::size_t step_ = 0, saved_ = 0;
};

/// A flexible side that answers with a fixed spring force at once.
class MockFem final : public FemSide {
 public:
  explicit MockFem(int nodes) : info_(mock_info("fem", nodes)), wrenches_(info_.ports.size()) {}
  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet&) override { return wrenches_; }
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override {
    for (std::size_t i = 0; i < wrenches_.size(); ++i) {
      wrenches_[i].f_P_W = -100.0 * request.input.end[i].p_WP;
    }
    return {.outcome = Outcome::Done, .message = {}, .output = wrenches_};
  }
  void checkpoint() override { saved_ = wrenches_; }
  void rollback() override { wrenches_ = saved_; }
  Observation observe() override { return {}; }

 private:
  SubsystemInfo info_;
  WrenchSet wrenches_, saved_;
};

/// Times each call of the remote flexible side, without what that side computes.
class TimedFem final : public FemSide {
 public:
  TimedFem(FemSide& inner, ExchangeSamples& samples) : inner_(inner), samples_(samples) {}
  [[nodiscard]] const SubsystemInfo& info() const override { return inner_.info(); }
  WrenchSet initialize(const MotionSet& input) override { return inner_.initialize(input); }
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override {
    const double begin_s = now_s();
    StepResult<WrenchSet> result = inner_.advance(request);
    samples_.exchange_us.push_back(1e6 * (now_s() - begin_s - result.cost.compute_s));
    samples_.resent += result.cost.resent;
    return result;
  }
  void checkpoint() override { inner_.checkpoint(); }
  void rollback() override { inner_.rollback(); }
  Observation observe() override { return inner_.observe(); }

 private:
  FemSide& inner_;
  ExchangeSamples& samples_;
};

/// Passes journals on, times that, and after each block of macro steps runs a block of both kinds
/// of ping-pong.
class TimedSink final : public StepSink {
 public:
  TimedSink(StepSink& inner, PingPong& pings, const ExchangeCase& which, ExchangeSamples& samples)
      : inner_(inner), pings_(pings), which_(which), samples_(samples) {}

  double record(wire::StepJournal journal) override {
    const std::int64_t step = journal.step.macro_step;
    const double begin_s = now_s();
    const double blocked_s = inner_.record(std::move(journal));
    const double end_s = now_s();
    if (step > 0) {
      samples_.record_us.push_back(1e6 * (end_s - begin_s));
      samples_.step_us.push_back(1e6 * (end_s - step_begin_s_));
    }
    if (step % which_.per_block == 0) {
      append(samples_.raw_tcp_us, pings_.tcp_us(which_.per_block));
      append(samples_.raw_udp_us, pings_.udp_us(which_.per_block));
    }
    step_begin_s_ = now_s();
    return blocked_s;
  }

 private:
  static void append(std::vector<double>& to, const std::vector<double>& more) {
    to.insert(to.end(), more.begin(), more.end());
  }
  StepSink& inner_;
  PingPong& pings_;
  const ExchangeCase& which_;
  ExchangeSamples& samples_;
  double step_begin_s_ = 0.0;
};

class SendingSink final : public StepSink {
 public:
  explicit SendingSink(wire::JournalSender& sender) : sender_(sender) {}
  double record(wire::StepJournal journal) override { return sender_.send(std::move(journal)); }

 private:
  wire::JournalSender& sender_;
};

class LogSink final : public StepSink {
 public:
  explicit LogSink(wire::LogWriter& log) : log_(log) {}
  double record(wire::StepJournal journal) override {
    log_.write(journal);
    return 0.0;
  }

 private:
  wire::LogWriter& log_;
};

nlohmann::json to_json(const ExchangeSamples& s) {
  return {s.raw_tcp_us, s.raw_udp_us, s.exchange_us, s.record_us, s.step_us, s.resent};
}

ExchangeSamples from_json(const nlohmann::json& json) {
  ExchangeSamples s;
  json.at(0).get_to(s.raw_tcp_us);
  json.at(1).get_to(s.raw_udp_us);
  json.at(2).get_to(s.exchange_us);
  json.at(3).get_to(s.record_us);
  json.at(4).get_to(s.step_us);
  json.at(5).get_to(s.resent);
  return s;
}

/// What the processes of one benchmark share.
class ExchangeBenchmark {
 public:
  explicit ExchangeBenchmark(const ExchangeCase& which)
      : which_(which),
        driver_(which.driver == DriverPlace::Mbs ? Process::Mbs : Process::Orchestrator),
        run_id_(wire::random_run_id() & ~std::uint64_t{0xff}),
        port_(wire::free_port()) {}

  ExchangeSamples run() {
    const ChildFunction fem([this] { return fem_process(); });
    const ChildFunction mbs([this] { return mbs_process(); });
    const ChildFunction orchestrator([this] { return orchestrator_process(); });
    const std::string result = orchestrator.result();
    return from_json(nlohmann::json::parse(result));
  }

 private:
  [[nodiscard]] PingPongSizes sizes() const {
    const auto nodes = static_cast<std::size_t>(which_.nodes);
    return {.there = nodes * wire::kMotionBytes, .back = nodes * wire::kWrenchBytes};
  }

  [[nodiscard]] wire::BusOptions join(Process self) const {
    const wire::Wait wait = wait_in_run(which_.wait, which_.placement, self, driver_);
    place_process(which_.placement, self, driver_, run_id_);
    return {
        .self = self, .run_id = run_id_, .port = port_, .receive = which_.receive, .wait = wait};
  }

  [[nodiscard]] wire::RemoteOptions remote(Process side) const {
    wire::RemoteOptions options{.side = side, .tandem_version = kVersion};
    for (int i = 0; i < which_.nodes; ++i) options.port_names.push_back(std::to_string(i));
    return options;
  }

  std::string fem_process() {
    const wire::BusOptions options = join(Process::Fem);
    answer_pings(sockets_, sizes());
    MockFem fem(which_.nodes);
    return serve(options, fem);
  }

  std::string mbs_process() {
    const wire::BusOptions options = join(Process::Mbs);
    MockMbs mbs(which_.nodes);
    if (driver_ != Process::Mbs) return serve(options, mbs);
    wire::Bus bus(options);
    wire::Heartbeat heartbeat(bus, kTimeout_s);
    wire::LivenessMonitor monitor(bus, {Process::Fem, Process::Orchestrator}, kTimeout_s);
    wire::RemoteFem fem(bus, monitor, remote(Process::Fem));
    wire::JournalSender sender(bus, monitor, kCreditWindow);
    SendingSink sink(sender);
    const std::string samples = drive({mbs, Locality::Here}, fem, sink);
    fem.close();
    monitor.release(Process::Fem);
    sender.finish({.exit_code = 0, .message = "done", .summary_json = samples});
    return {};
  }

  std::string orchestrator_process() {
    wire::Bus bus(join(Process::Orchestrator));
    wire::Heartbeat heartbeat(bus, kTimeout_s);
    wire::LivenessMonitor monitor(bus, {Process::Mbs, Process::Fem}, kTimeout_s);
    wire::LogWriter log(folder_.path() / "exchange.lcm", run_id_, {"bench", kVersion});
    if (driver_ == Process::Mbs) return record(bus, monitor, log);
    wire::RemoteMbs mbs(bus, monitor, remote(Process::Mbs));
    wire::RemoteFem fem(bus, monitor, remote(Process::Fem));
    LogSink sink(log);
    std::string samples = drive({mbs, Locality::Elsewhere}, fem, sink);
    fem.close();
    monitor.release(Process::Fem);
    mbs.close();
    return samples;
  }

  template <class Side>
  std::string serve(const wire::BusOptions& options, Side& side) const {
    wire::Bus bus(options);
    wire::Heartbeat heartbeat(bus, kTimeout_s);
    wire::LivenessMonitor monitor(bus, {driver_}, kTimeout_s);
    wire::serve(side, bus, monitor, {.tandem_version = kVersion, .heartbeat = &heartbeat});
    return {};
  }

  std::string drive(PlacedSide<MbsSide> mbs, FemSide& fem, StepSink& recording) const {
    ExchangeSamples samples;
    PingPong pings(sockets_, sizes());
    TimedFem timed(fem, samples);
    TimedSink sink(recording, pings, which_, samples);
    const std::int64_t steps = std::int64_t{which_.blocks} * which_.per_block;
    CouplingParams coupling{.scheme = SchemeKind::ExplicitSerial, .prediction = Prediction::Hold};
    const RunReport report =
        run_coupled(scheme_run({.duration = steps * kStep, .macro_step = kStep}, coupling), mbs,
                    {timed, Locality::Elsewhere}, sink);
    if (report.status != RunStatus::Done) throw Error(ErrorKind::NotSolved, report.message);
    return to_json(samples).dump();
  }

  std::string record(wire::Bus& bus, wire::LivenessMonitor& monitor, wire::LogWriter& log) const {
    wire::JournalReceiver receiver(bus, monitor, kCreditWindow);
    std::string samples;
    while (samples.empty()) {
      auto entry = receiver.next(0.1);
      if (!entry) continue;
      if (const auto* journal = std::get_if<wire::StepJournal>(&*entry)) {
        log.write(*journal);
      } else {
        samples = std::get<wire::Finished>(*entry).summary_json;
        monitor.release(Process::Mbs);
        monitor.release(Process::Fem);
      }
      receiver.recorded();
    }
    // The driver may not have heard the last credit: it asks again until it has.
    for (const double end_s = now_s() + 0.1; now_s() < end_s;) receiver.next(0.05);
    return samples;
  }

  const ExchangeCase& which_;
  Process driver_;
  std::uint64_t run_id_;  ///< its last byte is zero: every benchmark takes the same cores
  int port_;
  PingPongSockets sockets_;
  TemporaryFolder folder_;
};

}  // namespace

ExchangeSamples measure_exchange(const ExchangeCase& which) {
  return ExchangeBenchmark(which).run();
}

}  // namespace tandem::orchestrator

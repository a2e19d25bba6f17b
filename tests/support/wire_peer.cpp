// One process of a run with a mock side, for the process tests of the wire:
//   wire_peer fem|mbs|orchestrator run=… port=… [timeout_s=…] [key=value]…
// Prints "key=value" lines; ends with the exit code of the tandem::Error that ended it.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <map>
#include <string>
#include <thread>

#include "protocol/driver/journaled_side.h"
#include "protocol/wire/event_log.h"
#include "protocol/wire/journal_receiver.h"
#include "protocol/wire/journal_sender.h"
#include "protocol/wire/remote_side.h"
#include "protocol/wire/server.h"
#include "tests/support/wire_mock_sides.h"

namespace tandem::wire {
namespace {

struct Arguments {
  std::map<std::string, std::string> values;
  [[nodiscard]] std::string text(const std::string& key, const std::string& fallback) const {
    const auto found = values.find(key);
    return found == values.end() ? fallback : found->second;
  }
  [[nodiscard]] double number(const std::string& key, double fallback) const {
    return std::stod(text(key, std::to_string(fallback)));
  }
  [[nodiscard]] int integer(const std::string& key, int fallback) const {
    return std::stoi(text(key, std::to_string(fallback)));
  }
};

BusOptions bus_options(const Arguments& arguments, Process self) {
  return {.self = self,
          .run_id = std::stoull(arguments.text("run", "1")),
          .port = arguments.integer("port", 0),
          .receive = arguments.text("receive", "own") == "lcm" ? Receive::Lcm : Receive::Own};
}

std::vector<Process> partners(const Arguments& arguments, Process other) {
  std::vector<Process> list{other};
  if (arguments.integer("window", 0) > 0) list.push_back(Process::Orchestrator);
  return list;
}

void run_fem(const Arguments& arguments) {
  const double timeout_s = arguments.number("timeout_s", 5.0);
  Bus bus(bus_options(arguments, Process::Fem));
  Heartbeat heartbeat(bus, timeout_s);
  try {
    LivenessMonitor monitor(bus, partners(arguments, Process::Mbs), timeout_s,
                            arguments.integer("parent", 0));
    test::CountingFem fem(static_cast<std::size_t>(arguments.integer("ports", 2)));
    const int sleep_ms = arguments.integer("sleep_ms", 0);
    const int throw_at = arguments.integer("throw_at", 0);
    fem.on_advance = [&](std::int64_t n) {
      std::this_thread::sleep_for(std::chrono::milliseconds(sleep_ms));
      if (n == throw_at)
        throw Error(ErrorKind::NotSolved, "Newton stalled at t = 0.412 s. Halve h.");
    };
    serve(fem, bus, monitor,
          {.scenario_hash = static_cast<std::uint64_t>(arguments.integer("hash", 0)),
           .tandem_version = arguments.text("version", "1"),
           .heartbeat = &heartbeat});
    std::cout << "advances=" << fem.advances << "\ncheckpoints=" << fem.checkpoints
              << "\nrollbacks=" << fem.rollbacks << "\ndamaged=" << bus.counts().damaged << "\n";
  } catch (const Error& error) {
    publish_abort(bus, error.exit_code(), error.what());
    throw;
  }
}

void drive_journaled(const Arguments& arguments, Bus& bus, LivenessMonitor& monitor,
                     FemSide& remote) {
  JournalSender sender(bus, monitor, arguments.integer("window", 1));
  CallJournal journal;
  JournaledFem fem(remote, journal);
  const int steps = arguments.integer("steps", 100);
  MotionSet begin = test::some_motions(fem.info().ports.size(), 0.5);
  fem.initialize(begin);
  StepRecord record;
  const double begin_s = now_s();
  double blocked_s = sender.send({record, journal.take()});
  for (int step = 1; step <= steps; ++step) {
    fem.checkpoint();
    for (int k = 1; k <= 2; ++k) {
      if (k > 1) fem.rollback();
      const MotionSet end = test::some_motions(begin.size(), 0.01 * step + 0.001 * k);
      fem.advance({.step = SimTime(1000000), .input = {begin, end}});
    }
    record.macro_step = step;
    record.time += SimTime(1000000);
    record.iterations = 2;
    blocked_s += sender.send({record, journal.take()});
  }
  const double wall_s = now_s() - begin_s;
  sender.finish({.exit_code = 0, .message = "done", .summary_json = "{}"});
  std::cout << "us_per_step=" << 1e6 * wall_s / steps << "\nblocked_s=" << blocked_s
            << "\njournals_resent=" << sender.resent() << "\n";
}

void time_exchanges(const Arguments& arguments, FemSide& fem) {
  std::vector<double> times_us;
  const MotionSet motions = test::some_motions(fem.info().ports.size(), 0.3);
  for (int i = 0; i < arguments.integer("time", 0); ++i) {
    const double begin_s = now_s();
    fem.advance({.step = SimTime(1000000), .input = {motions, motions}});
    times_us.push_back(1e6 * (now_s() - begin_s));
  }
  std::sort(times_us.begin(), times_us.end());
  std::cout << "median_us=" << times_us[times_us.size() / 2]
            << "\np99_us=" << times_us[times_us.size() * 99 / 100] << "\n";
}

void run_mbs(const Arguments& arguments) {
  const double timeout_s = arguments.number("timeout_s", 5.0);
  Bus bus(bus_options(arguments, Process::Mbs));
  Heartbeat heartbeat(bus, timeout_s);
  try {
    LivenessMonitor monitor(bus, partners(arguments, Process::Fem), timeout_s);
    RemoteOptions options{.scenario_hash = static_cast<std::uint64_t>(arguments.integer("hash", 0)),
                          .tandem_version = arguments.text("version", "1")};
    for (int i = 0; i < arguments.integer("ports", 2); ++i) {
      options.port_names.push_back(std::string("p").append(std::to_string(i)));
    }
    heartbeat.set_phase("waiting for tandem-fem");
    RemoteFem fem(bus, monitor, options);
    heartbeat.set_phase("stepping");
    if (arguments.integer("time", 0) > 0) {
      time_exchanges(arguments, fem);
    } else if (arguments.integer("window", 0) > 0) {
      drive_journaled(arguments, bus, monitor, fem);
    } else {
      const auto hash =
          test::drive(fem, arguments.integer("steps", 100), arguments.integer("k", 3));
      std::cout << "hash=" << hash << "\n";
    }
    fem.close();
    const CallCost& cost = fem.total_cost();
    std::cout << "resent=" << cost.resent << "\nduplicates=" << cost.duplicates
              << "\ntransit_s=" << cost.transit_s << "\npublish_s=" << cost.publish_s
              << "\nencode_s=" << cost.encode_s << "\ndecode_s=" << cost.decode_s
              << "\nmessages=" << cost.messages << "\nbytes=" << cost.bytes << "\n";
  } catch (const Error& error) {
    publish_abort(bus, error.exit_code(), error.what());
    throw;
  }
}

void run_orchestrator(const Arguments& arguments) {
  const double timeout_s = arguments.number("timeout_s", 5.0);
  Bus bus(bus_options(arguments, Process::Orchestrator));
  Heartbeat heartbeat(bus, timeout_s);
  LivenessMonitor monitor(bus, {Process::Mbs, Process::Fem}, timeout_s);
  JournalReceiver receiver(bus, monitor, arguments.integer("window", 1));
  LogWriter log(arguments.text("log", "/dev/null"), bus.options().run_id, {"scenario", "versions"});
  std::int64_t expected = 0;
  for (bool finished = false; !finished;) {
    const auto entry = receiver.next(0.1);
    if (!entry) continue;
    if (const auto* journal = std::get_if<StepJournal>(&*entry)) {
      require(journal->step.macro_step == expected++, "a macro step is missing or out of order");
      log.write(*journal);
    } else {
      log.write(std::get<Finished>(*entry));
      finished = true;
    }
    receiver.recorded();
  }
  monitor.release(Process::Mbs);
  monitor.release(Process::Fem);
  // The driver may not have heard the last credit yet.
  for (const double end_s = now_s() + 0.5; now_s() < end_s;) receiver.next(0.05);
  std::cout << "journals=" << expected << "\nduplicates=" << receiver.duplicates()
            << "\nasked_again=" << receiver.asked_again() << "\n";
}

int run(const std::string& role, const Arguments& arguments) {
  try {
    if (role == "fem") run_fem(arguments);
    if (role == "mbs") run_mbs(arguments);
    if (role == "orchestrator") run_orchestrator(arguments);
    std::cout << "ended=" << role << "\n";
    return 0;
  } catch (const Error& error) {
    std::cout << "error=" << error.what() << "\n";
    return error.exit_code();
  }
}

}  // namespace
}  // namespace tandem::wire

int main(int argc, char** argv) {
  tandem::wire::Arguments arguments;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const auto equals = word.find('=');
    arguments.values[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return tandem::wire::run(argc > 1 ? argv[1] : "", arguments);
}

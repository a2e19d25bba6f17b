#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "orchestrator/commands/commands.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/scenario/option_checks.h"
#include "protocol/contract/error.h"
#include "protocol/driver/control_inbox.h"

namespace tandem::orchestrator {
namespace {

struct ControlCommand {
  std::string run;
  std::string run_id_hex;
  int port = 0;
  double timeout_s = 2.0;
  std::string verb;
  std::string set;
  std::string force;
  std::string body;

  [[nodiscard]] std::string text() const {
    const std::string to = body.empty() ? "" : body + " ";
    return verb == "force" ? fmt::format("{}force {} {}", to, set, force)
                           : fmt::format("{}{} {}", to, verb, set);
  }

  /// Where the run is heard: from its folder, or as given.
  [[nodiscard]] wire::BusOptions address() const {
    wire::BusOptions options;
    options.self = wire::Process::Tool;
    std::string id = run_id_hex;
    options.port = port;
    if (!run.empty()) {
      const RunDirectory directory = RunDirectory::open(run);
      if (std::filesystem::exists(directory.summary())) {
        throw Error(ErrorKind::Partner,
                    "control: no run answers at " + run + ": it has ended, as its summary says.");
      }
      std::ifstream stream(directory.bus());
      const auto bus = nlohmann::json::parse(stream, nullptr, false);
      require(!bus.is_discarded(),
              directory.bus().string() +
                  ": missing or damaged. Only runs over LCM take commands; a run in one process "
                  "can have fem.changes in its scenario.");
      id = bus.value("run_id", "");
      options.port = bus.value("port", 0);
      options.ttl = bus.value("ttl", 0);
    }
    require(!id.empty() && options.port > 0,
            "control: which run? Give its folder, or --run and "
            "--port.");
    const auto read = std::from_chars(id.data(), id.data() + id.size(), options.run_id, 16);
    require(read.ec == std::errc{} && read.ptr == id.data() + id.size(),
            "--run: '" + id + "' is not a hexadecimal number");
    return options;
  }

  void send() const {
    const wire::BusOptions options = address();
    const std::string where =
        run.empty() ? fmt::format("run {:016x}, port {}", options.run_id, options.port) : run;
    wire::Bus bus(options);
    wire::Controlled answer;
    try {
      answer = send_command(bus, text(), timeout_s);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::Partner && error.kind() != ErrorKind::NotSolved) throw;
      throw Error(ErrorKind::Partner,
                  fmt::format("control: no run answers at {}: it has ended, or is not stepping "
                              "({})",
                              where, error.what()));
    }
    require(answer.accepted, answer.message);
    std::printf("macro step %lld: %s\n", static_cast<long long>(answer.header.macro_step),
                answer.message.c_str());
  }
};

}  // namespace

void add_control(CLI::App& app) {
  auto command = std::make_shared<ControlCommand>();
  CLI::App* sub = app.add_subcommand(
      "control", "Change the flexible body of a running pair: release, fix, force");
  sub->add_option("RUN", command->run, "Run folder of the run that goes on");
  sub->add_option("--run", command->run_id_hex, "Run id, 16 hexadecimal digits, in place of RUN");
  sub->add_option("--port", command->port, "UDP port of the run, with --run");
  sub->add_option("--body", command->body,
                  "The flexible body that is meant, where there are several");
  sub->add_option("--timeout", command->timeout_s,
                  "Silence (s) after which the run counts as ended")
      ->check(number_above_zero())
      ->capture_default_str();
  sub->require_subcommand(1);
  const auto add = [&](const char* verb, const char* what) {
    CLI::App* action = sub->add_subcommand(verb, what);
    action->add_option("SET", command->set, "Node set of the mesh")->required();
    action->callback([command, verb] {
      command->verb = verb;
      command->send();
    });
    return action;
  };
  add("release", "Let the nodes of a fixed set move");
  add("fix", "Hold the nodes of a set where they are");
  add("force", "Put a total force on the nodes of a set, in place of the last one by command")
      ->add_option("FORCE", command->force, "FX,FY,FZ (N) in world axes; 0,0,0 ends it")
      ->required();
  sub->footer(
      "Takes effect before the next macro step, which is printed, and is recorded in the run's "
      "log.\n"
      "Exit codes: 0 done, 2 no such set or command, 4 no run answers.");
}

}  // namespace tandem::orchestrator

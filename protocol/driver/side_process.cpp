#include "protocol/driver/side_process.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <optional>

#include "protocol/contract/error.h"
#include "protocol/driver/process_memory.h"
#include "protocol/driver/remote_bodies.h"
#include "protocol/driver/remote_worlds.h"
#include "protocol/driver/standard_streams.h"
#include "protocol/wire/server.h"

namespace tandem {
namespace {

struct Options {
  std::string scenario;
  std::string run_id_hex;
  int port = 0;
  std::string directory;
  int parent_pid = 0;
  std::string part;  ///< name of the flexible body or world
};

void declare(CLI::App& app, const SideProgram& program, Options& options) {
  app.add_option("--scenario", options.scenario,
                 "Resolved scenario file (scenario.yaml of the run)")
      ->required();
  app.add_option("--run", options.run_id_hex, "Run id, 16 hexadecimal digits")->required();
  app.add_option("--port", options.port, "UDP port of the run's multicast group")
      ->required()
      ->check(CLI::Range(1024, 65535));
  app.add_option("--dir", options.directory, "Run folder for the files that this side writes");
  if (program.self == wire::Process::Fem) {
    app.add_option("--body", options.part,
                   "Name of the flexible body, where the scenario has several");
  } else {
    app.add_option("--world", options.part,
                   "Name of the multibody world, where the scenario has several");
  }
  app.add_option("--parent", options.parent_pid, "Pid of the starting process: end when it ends");
  app.footer(
      "Started by `tandem run`; by hand only for debugging, with the values that\n"
      "`tandem run --attach` prints. Exit codes: 0 done, 2 bad usage or scenario,\n"
      "3 not converged or diverged, 4 a process failed or stopped answering.");
}

std::uint64_t parse_run_id(const std::string& text) {
  std::size_t used = 0;
  std::uint64_t id = 0;
  try {
    id = std::stoull(text, &used, 16);
  } catch (const std::exception&) {
    used = 0;
  }
  require(used == text.size() && used > 0, "--run: '" + text + "' is not a hexadecimal number");
  return id;
}

/// The part of the key table that a side reads; the orchestrator has validated the rest.
scenario::Section side_table(const SideProgram& program) {
  scenario::Section table;
  table.title = program.name;
  table.keys = {scenario::run_keys(),
                scenario::ports_keys(),
                scenario::output_keys(),
                coupling_keys(),
                wire_keys(),
                program.keys};
  table.keys.push_back(program.self == wire::Process::Fem ? scenario::multibody_names_key()
                                                          : scenario::flexible_names_key());
  return table;
}

std::vector<std::string> port_names(const scenario::Node& root) {
  std::vector<std::string> names;
  for (const auto& port : scenario::read_ports(root)) names.push_back(port.name);
  return names;
}

/// What one process of a run is to know of all.
struct Table {
  std::vector<scenario::BodyPorts> worlds;
  std::vector<scenario::BodyPorts> bodies;
};

/// The partners whose silence ends this process: the driver, and the orchestrator that grants
/// steps; of the driver all flexible bodies and all other worlds.
std::vector<wire::Process> partners_of(wire::Process self, wire::Process driver,
                                       const Table& table) {
  using wire::Process;
  if (driver == Process::Orchestrator) return {Process::Orchestrator};
  std::vector<Process> partners{driver};
  if (driver == self) {
    partners = processes_of(table.bodies);
    const std::vector<Process> worlds = world_processes(table.worlds);
    partners.insert(partners.end(), worlds.begin() + 1, worlds.end());
  }
  partners.push_back(Process::Orchestrator);
  return partners;
}

/// Which of the `parts`, "flexible bodies" or "multibody worlds", a process is to be.
std::size_t part_of(const std::vector<scenario::BodyPorts>& parts, const std::string& name,
                    const char* option, const char* what) {
  if (parts.size() == 1) return 0;
  std::vector<std::string> names;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].name == name) return p;
    names.push_back(parts[p].name);
  }
  throw Error(ErrorKind::Usage,
              fmt::format("{}: {}. The scenario has several {}: {}.", option,
                          name.empty() ? "is missing" : "'" + name + "' is none of them", what,
                          fmt::join(names, ", ")));
}

/// Makes the scenario that of the part which this process is to be; says which process that is.
wire::Process become(const SideProgram& program, const std::string& name, const Table& table,
                     scenario::Loaded& loaded) {
  if (program.self == wire::Process::Fem) {
    const std::size_t own = part_of(table.bodies, name, "--body", "flexible bodies");
    loaded.root = scenario::flexible_bodies(loaded.root)[own].root;
    return wire::body_process(own, table.bodies.size());
  }
  const std::size_t own = part_of(table.worlds, name, "--world", "multibody worlds");
  loaded.root = scenario::multibody_worlds(loaded.root)[own].root;
  return wire::world_process(own, table.worlds.size());
}

/// Until every partner has been heard: starting takes longer than an answer in mid-run may.
void await(const std::vector<wire::Process>& partners, wire::Bus& bus, wire::Heartbeat& heartbeat,
           double start_timeout_s, int parent_pid) {
  wire::LivenessMonitor monitor(bus, partners, start_timeout_s, parent_pid);
  for (wire::Process partner : partners) {
    if (!monitor.heard_from(partner)) {
      heartbeat.set_phase("waiting for " + bus.program_of(partner));
    }
    while (!monitor.heard_from(partner)) monitor.wait(0.02);
  }
}

int join_run(const SideProgram& program, const Options& options,
             const std::function<int(SideContext&)>& body) {
  auto loaded =
      scenario::load(options.scenario, side_table(program), {}, scenario::UnknownKeys::Ignore);
  const Table table{scenario::world_table(loaded.root), scenario::body_table(loaded.root)};
  const std::vector<std::string> all_ports = port_names(loaded.root);
  const wire::Process self = become(program, options.part, table, loaded);
  const WireParams params = read_wire(loaded.root);
  wire::BusOptions bus_options;
  bus_options.self = self;
  bus_options.names = process_names(table.bodies, table.worlds);
  bus_options.run_id = parse_run_id(options.run_id_hex);
  bus_options.port = options.port;
  bus_options.ttl = static_cast<int>(params.ttl);
  bus_options.receive = params.receive;
  const wire::Process driver = driver_process(params.driver, table.worlds);
  bus_options.wait = wait_in_run(params.wait, params.placement, self, driver,
                                 table.bodies.size() + table.worlds.size() - 1);
  place_process(params.placement, self, driver, bus_options.run_id);
  wire::Bus bus(bus_options);
  try {
    wire::Heartbeat heartbeat(bus, params.timeout_s);
    const std::vector<wire::Process> partners = partners_of(self, driver, table);
    await(partners, bus, heartbeat, params.start_timeout_s, options.parent_pid);
    wire::LivenessMonitor monitor(bus, partners, params.timeout_s, options.parent_pid);
    SideContext context{.scenario = loaded,
                        .run = scenario::read_run(loaded.root),
                        .wire = params,
                        .port_names = all_ports,
                        .bodies = table.bodies,
                        .worlds = table.worlds,
                        .directory = options.directory,
                        .bus = bus,
                        .heartbeat = heartbeat,
                        .monitor = monitor,
                        .driver = driver};
    heartbeat.set_phase("loading its model");
    return body(context);
  } catch (const Error& error) {
    wire::publish_abort(bus, error.exit_code(), error.what());
    throw;
  } catch (const std::exception& error) {
    wire::publish_abort(bus, 4, error.what());
    throw;
  }
}

/// When the starting process dies, a process that is frozen must wake up to notice and to end.
/// Ctrl-C at a terminal reaches all processes: the starting one ends the run in order.
void follow_parent(int parent_pid) {
  if (parent_pid <= 0) return;
  prctl(PR_SET_PDEATHSIG, SIGCONT);
  std::signal(SIGINT, SIG_IGN);
}

}  // namespace

int run_side_process(const SideProgram& program, int argc, char** argv,
                     const std::function<int(SideContext&)>& body) {
  open_standard_streams();
  keep_freed_memory();
  CLI::App app(program.description, program.name);
  app.set_version_flag("--version", kTandemVersion);
  Options options;
  declare(app, program, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  follow_parent(options.parent_pid);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    return join_run(program, options, body);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.name.c_str(), error.what());
    return 4;
  }
}

namespace {

template <class Side>
void serve(SideContext& context, Side& side) {
  context.heartbeat.set_phase("waiting for " + context.bus.program_of(context.driver));
  wire::serve(side, context.bus, context.monitor,
              {.scenario_hash = context.scenario.hash,
               .tandem_version = kTandemVersion,
               .heartbeat = &context.heartbeat});
}

}  // namespace

void serve_side(SideContext& context, MbsSide& side) { serve(context, side); }
void serve_side(SideContext& context, FemSide& side) { serve(context, side); }

}  // namespace tandem

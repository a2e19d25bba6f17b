#include "protocol/scenario/common_keys.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string>
#include <system_error>

#include "protocol/contract/error.h"
#include "protocol/scenario/event_times.h"

namespace tandem::scenario {
namespace {

SimTime time_of(const Node& node, std::string_view key) {
  const double seconds = node.real(key);
  // Nanoseconds in 63 bits.
  if (std::abs(seconds) > 9.2e9) {
    node.fail(key, fmt::format("{:g} s is out of range. It must be below 9.2e9 s.", seconds));
  }
  try {
    return sim_time_from_seconds(seconds);
  } catch (const Error& error) {
    node.fail(key, error.what());
  }
}

/// Division rounds once: 11 ms reads 0.011, where count · 1e-9 reads 0.011000000000000001.
std::string seconds_text(SimTime t) {
  return fmt::format("{} s", static_cast<double>(t.count()) / 1e9);
}

constexpr double kSlowestPace = 1e-6;
constexpr double kFastestPace = 1e6;

/// 0: free.
double pace_of(const Node& run) {
  const std::string text = run.text("pace");
  if (text == "free") return 0.0;
  if (text == "real_time") return 1.0;
  double factor = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), factor);
  const bool number = error == std::errc{} && end == text.data() + text.size();
  if (number && factor >= kSlowestPace && factor <= kFastestPace) return factor;
  run.fail("pace", fmt::format("'{}' is no pace. Write free, real_time, or simulated seconds per "
                               "second of wall time, e.g. 0.5 ({:g} to {:g}).",
                               text, kSlowestPace, kFastestPace));
}

RunParams run_of(const Node& run) {
  const RunParams params{.duration = time_of(run, "duration_s"),
                         .macro_step = time_of(run, "macro_step_s"),
                         .pace = pace_of(run)};
  if (params.macro_step.count() == 0) run.fail("macro_step_s", "is below 1 ns. Raise it.");
  const SimTime rest = params.duration % params.macro_step;
  if (rest.count() == 0) return params;
  const SimTime below = params.duration - rest;
  const std::string shorter =
      below.count() > 0 ? fmt::format("{} or ", seconds_text(below)) : std::string();
  run.fail("duration_s", fmt::format("{} is not a whole number of macro steps of {}. Use {}{}.",
                                     seconds_text(params.duration), seconds_text(params.macro_step),
                                     shorter, seconds_text(below + params.macro_step)));
}

}  // namespace

std::vector<Key> root_keys() {
  return {
      name("name").must().doc_is("Name of the scenario; the run directory carries it."),
      text("description").doc_is("What the scenario shows, for readers and reports."),
  };
}

Key run_keys() {
  Section run;
  run.title = "Run";
  run.doc = "How long and in which steps the coupled system is integrated.";
  run.keys = {
      real("duration_s", "s")
          .must()
          .above(0)
          .doc_is("Simulated time, a whole number of macro steps."),
      real("macro_step_s", "s")
          .must()
          .above(0)
          .doc_is("Time between two exchanges of the sides, a whole number of nanoseconds."),
      real("accuracy", "")
          .above(0)
          .between(1e-12, 1e-3)
          .by_default("1e-6")
          .doc_is("Part of the largest wrench up to now that the iterations of a macro step may "
                  "leave in it. Tolerances and methods that the scenario leaves open follow from "
                  "it (docs/coupling.md); 1e-10 chooses what is exact, and slow."),
      text("pace").by_default("free").doc_is(
          "free: as fast as it can. real_time, or simulated seconds per second of wall "
          "time from 1e-6 to 1e6: macro steps wait until they are due, late ones are counted "
          "(`pace` in "
          "summary.json). The results have the same bits."),
  };
  run.check = [](const Node& node) { (void)run_of(node); };
  return section("run", std::move(run)).must().doc_is("Duration and macro step.");
}

RunParams read_run(const Node& root) {
  RunParams run = run_of(root.section("run"));
  run.events = event_times(root, run.duration);
  return run;
}

Key ports_keys() {
  Section port;
  port.title = "Port";
  port.doc =
      "A place where the sides meet: the frame P fixed to a rigid body, and the nodes of the "
      "flexible body that are attached to it.";
  port.keys = {
      name("name").must().doc_is("Name of the port in logs, errors and result files."),
      name("body").must().doc_is("Rigid body of the multibody side that carries the port."),
      text("node_set")
          .doc_is("Node set (physical group) of the mesh that is attached to the port; left out "
                  "where the "
                  "port's body is felt by contact alone (fem.model: ancf)."),
      name("flexible")
          .doc_is("Name of the flexible body that the port belongs to, where fem lists several."),
      reals("position_m", "m")
          .count(3)
          .doc_is("Position p_WP of the port's origin at t = 0 in world axes; left out: the port "
                  "is the "
                  "body's own frame."),
      reals("orientation_wxyz", "")
          .count(4)
          .of_unit_length()
          .by_default("[1, 0, 0, 0]")
          .doc_is("Rotation q_WP of the port frame at t = 0 as a quaternion [w, x, y, z]; used "
                  "with position_m."),
  };
  for (Key& key : attachment_keys()) port.keys.push_back(std::move(key));
  return sections("ports", std::move(port))
      .must()
      .at_least_count(1)
      .doc_is("Ports, in the order in which both sides number them.");
}

std::vector<PortParams> read_ports(const Node& root) {
  std::vector<PortParams> ports;
  for (const Node& node : root.list("ports")) {
    PortParams port;
    port.name = node.text("name");
    port.body = node.text("body");
    if (node.has("node_set")) port.node_set = node.text("node_set");
    if (node.has("flexible")) port.flexible = node.text("flexible");
    port.q_WP = node.quaternion_wxyz("orientation_wxyz");
    port.at_body_frame = !node.has("position_m");
    if (!port.at_body_frame) port.p_WP = node.vector3("position_m");
    port.attachment = read_attachment(node);
    port.place = node.place();
    ports.push_back(std::move(port));
  }
  return ports;
}

Key output_keys() {
  Section output;
  output.title = "Output";
  output.doc = "What the sides write while they run.";
  output.keys = {
      integer("vtu_every_steps")
          .at_least(0)
          .by_default("0")
          .doc_is("Mesh files (.vtu) every n-th macro step, 0 = none."),
      integer("bodies_every_steps")
          .at_least(0)
          .by_default("1")
          .doc_is("Rows of bodies.csv every n-th macro step, 0 = no file."),
      integer("energy_every_steps")
          .at_least(0)
          .by_default("0")
          .doc_is("Rows of energy.csv, both sides' energy books, every n-th macro step, 0 = no "
                  "file."),
      integer("log_every_steps")
          .at_least(0)
          .by_default("1")
          .doc_is("Macro steps in exchange.lcm: every n-th, 0 = none; those with a command or a "
                  "failure stand there in any case, unless 0. `tandem replay` needs 1."),
  };
  return section("output", std::move(output)).by_default("{}").doc_is("Files the sides write.");
}

OutputParams read_output(const Node& root) {
  const Node output = root.section("output");
  return {.vtu_every_steps = output.integer("vtu_every_steps"),
          .bodies_every_steps = output.integer("bodies_every_steps"),
          .energy_every_steps = output.integer("energy_every_steps"),
          .log_every_steps = output.integer("log_every_steps")};
}

}  // namespace tandem::scenario

#pragma once

#include <string>
#include <vector>

#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"
#include "protocol/scenario/attachment.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::scenario {

/// Keys of the root itself: `name` and `description`.
[[nodiscard]] std::vector<Key> root_keys();

/// Section `run`: how long, in which steps. Used by every process.
struct RunParams {
  SimTime duration{};
  SimTime macro_step{};
  double pace = 0.0;  ///< simulated over wall time that the run is held to; 0: as fast as it can
  /// Times within the run at which the scenario says that something begins or ends, in order: the
  /// corners of ramps and tables, and scheduled changes (`at_s`). Adaptive steps end there.
  std::vector<SimTime> events = {};
  [[nodiscard]] std::int64_t macro_steps() const { return duration / macro_step; }
};
[[nodiscard]] Key run_keys();
[[nodiscard]] RunParams read_run(const Node& root);

/// Section `ports`: one row per place where the sides meet.
struct PortParams {
  std::string name;
  std::string body;      ///< rigid body on the multibody side
  std::string node_set;  ///< node set (physical group) on the flexible side; empty: none given
  std::string flexible;  ///< the flexible body, of several; empty: there is one
  Eigen::Vector3d p_WP = Eigen::Vector3d::Zero();            ///< Po at t = 0 in W (m)
  Eigen::Quaterniond q_WP = Eigen::Quaterniond::Identity();  ///< P at t = 0 in W
  bool at_body_frame = true;  ///< no position given: P is the body's own frame
  Attachment attachment{};    ///< of the nodes, on the flexible side
  Place place;                ///< for errors of either side
};
[[nodiscard]] Key ports_keys();
[[nodiscard]] std::vector<PortParams> read_ports(const Node& root);

/// Section `output`, as far as the sides write files themselves.
struct OutputParams {
  std::int64_t vtu_every_steps = 0;     ///< 0 = no .vtu files
  std::int64_t bodies_every_steps = 1;  ///< rows of bodies.csv, 0 = no file
  std::int64_t energy_every_steps = 0;  ///< rows of energy.csv, 0 = no file
  std::int64_t log_every_steps = 1;     ///< macro steps in exchange.lcm, 0 = none; replays need 1
};
[[nodiscard]] Key output_keys();
[[nodiscard]] OutputParams read_output(const Node& root);

}  // namespace tandem::scenario

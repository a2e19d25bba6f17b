#pragma once

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orchestrator/run/run.h"
#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {

/// What the ports did in a run, one entry per macro step and one at t = 0.
using History = std::vector<AcceptedInterface>;

/// A time of now_s() that never comes.
inline constexpr double kNoDeadline = std::numeric_limits<double>::infinity();

/// The status of a run that was broken off at its deadline.
inline constexpr const char* kOutOfTime = "out_of_time";

/// A run made for a comparison.
struct ObservedRun {
  int exit_code = 0;         ///< 0, or 3: a numerical end, which is a result to show
  bool out_of_time = false;  ///< broken off at the deadline; the exit code is 3 then
  nlohmann::ordered_json summary;
  History history;
};

/// Runs the model into `folder` and says `title` on standard error; the run is broken off at the
/// first macro step after now_s() has reached `deadline_s`. Throws what keeps a comparison
/// from going on: bad input, a process that failed, an interruption.
[[nodiscard]] ObservedRun observe_run(const Model& model, Mode mode,
                                      const std::filesystem::path& folder, const std::string& title,
                                      double deadline_s = kNoDeadline);

/// The motions at time t, which lies within the history: between two macro steps the cubic Hermite
/// polynomial of positions and velocities and the slerp of rotations, at a macro step its own bits.
[[nodiscard]] MotionSet motions_at(const History& history, SimTime t);

/// Distances of two runs' port motions, over all ports and all macro steps of `run` that the
/// history of `reference` covers.
struct MotionDistance {
  double max_m = 0.0;     ///< of |p_WP|
  double rms_m = 0.0;     ///< root mean square over macro steps and ports
  double max_rad = 0.0;   ///< angle between the port frames
  double motion_m = 0.0;  ///< largest |Δp_WP| + L Δθ, L the port's length (0 without `ports`)
};
[[nodiscard]] MotionDistance motion_distance(const History& run, const History& reference,
                                             const std::vector<PortInfo>& ports = {});

/// Largest |Δp_WP| + L Δθ of any port from where it started: the scale of errors.
[[nodiscard]] double largest_travel_m(const History& history, const std::vector<PortInfo>& ports);

}  // namespace tandem::orchestrator

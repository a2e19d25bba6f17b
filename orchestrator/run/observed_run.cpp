#include "orchestrator/run/observed_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/contract/segment.h"

namespace tandem::orchestrator {

ObservedRun observe_run(const Model& model, Mode mode, const std::filesystem::path& folder,
                        const std::string& title, double deadline_s) {
  std::fprintf(stderr, "%s\n", title.c_str());
  const RunDirectory directory = RunDirectory::create(folder, model.name);
  ObservedRun run;
  RunOutcome outcome = run_model(
      model, directory,
      {.mode = mode, .silent = true, .watch = [&run, deadline_s](const AcceptedInterface& i) {
         if (!i.motions.empty()) run.history.push_back(i);
         run.out_of_time = now_s() >= deadline_s;
         if (run.out_of_time) throw Error(ErrorKind::NotSolved, "the wall time is spent.");
       }});
  // A numerical end (3) is a result to show; anything else means that nothing was measured.
  if (outcome.exit_code != 0 && outcome.exit_code != 3) {
    throw Error(outcome.exit_code == 2 ? ErrorKind::Usage : ErrorKind::Partner,
                outcome.summary.at("message").get<std::string>());
  }
  run.exit_code = outcome.exit_code;
  run.summary = std::move(outcome.summary);
  if (run.out_of_time) run.summary["status"] = kOutOfTime;
  return run;
}

MotionSet motions_at(const History& history, SimTime t) {
  const auto after = std::lower_bound(
      history.begin(), history.end(), t,
      [](const AcceptedInterface& entry, SimTime time) { return entry.time < time; });
  if (after == history.end()) throw std::out_of_range("motions_at: beyond the end of the history");
  if (after->time == t || after == history.begin()) return after->motions;
  const auto before = after - 1;
  const SimTime H = after->time - before->time;
  const double s = to_seconds(t - before->time) / to_seconds(H);
  return interpolate({before->motions, after->motions}, s, H);
}

MotionDistance motion_distance(const History& run, const History& reference,
                               const std::vector<PortInfo>& ports) {
  MotionDistance distance;
  double squares = 0.0;
  std::size_t count = 0;
  for (const AcceptedInterface& entry : run) {
    if (reference.empty() || entry.time > reference.back().time) break;
    const MotionSet there = motions_at(reference, entry.time);
    for (std::size_t i = 0; i < there.size(); ++i) {
      const double d_m = (entry.motions[i].p_WP - there[i].p_WP).norm();
      const double d_rad = entry.motions[i].q_WP.angularDistance(there[i].q_WP);
      distance.max_m = std::max(distance.max_m, d_m);
      distance.max_rad = std::max(distance.max_rad, d_rad);
      const double length_m = ports.empty() ? 0.0 : ports[i].length_m;
      distance.motion_m = std::max(distance.motion_m, d_m + length_m * d_rad);
      squares += d_m * d_m;
      ++count;
    }
  }
  if (count > 0) distance.rms_m = std::sqrt(squares / static_cast<double>(count));
  return distance;
}

double largest_travel_m(const History& history, const std::vector<PortInfo>& ports) {
  double largest = 0.0;
  for (const AcceptedInterface& entry : history) {
    for (std::size_t i = 0; i < entry.motions.size(); ++i) {
      const Motion& start = history.front().motions[i];
      largest = std::max(largest,
                         (entry.motions[i].p_WP - start.p_WP).norm() +
                             ports[i].length_m * entry.motions[i].q_WP.angularDistance(start.q_WP));
    }
  }
  return largest;
}

}  // namespace tandem::orchestrator

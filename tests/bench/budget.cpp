// What a bounded macro step costs in accuracy: the lug with ever fewer evaluations of the coupling
// and iterations of conjugate gradients, against the strict run, as the table of docs/real_time.md.
//   budget [SECONDS]      simulated time, 1 s by default

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "orchestrator/run/observed_run.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

using Overrides = std::vector<scenario::Override>;

struct Budget {
  int evaluations = 0;  ///< most of a macro step; 0: none
  int pcg = 0;          ///< most iterations of a solve; 0: none

  [[nodiscard]] Overrides overrides() const {
    Overrides all;
    if (evaluations > 0) all.push_back({"coupling.max_evaluations", std::to_string(evaluations)});
    if (pcg > 0) {
      all.push_back({"fem.solver", fmt::format("{{kind: pcg, max_iterations: {}, "
                                               "on_not_converged: accept}}",
                                               pcg)});
    }
    return all;
  }
};

std::string number(int most) { return most > 0 ? std::to_string(most) : "–"; }

ObservedRun run(const std::filesystem::path& folder, const std::string& name, double duration_s,
                Overrides overrides) {
  overrides.push_back({"run.duration_s", fmt::format("{}", duration_s)});
  const Model model = load_model(
      std::filesystem::path(TANDEM_SOURCE_DIR) / "examples/lug/scenario.yaml", overrides);
  return observe_run(model, Mode::Inproc, folder / name, name);
}

/// The longest way of a port from where it began (m).
double travel_of(const History& history) {
  double longest_m = 0.0;
  for (const AcceptedInterface& at : history) {
    for (std::size_t i = 0; i < at.motions.size(); ++i) {
      longest_m =
          std::max(longest_m, (at.motions[i].p_WP - history.front().motions[i].p_WP).norm());
    }
  }
  return longest_m;
}

void table(double duration_s) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("budget_{}", getpid());
  const ObservedRun strict = run(folder, "strict", duration_s, {{"run.accuracy", "1e-10"}});
  require(strict.exit_code == 0, "the strict run failed");
  const double travel_m = travel_of(strict.history);
  fmt::print(
      "| `coupling.max_evaluations` | PCG `max_iterations` | ms a step | evaluations | left of the "
      "wrench | ports off by, of their travel |\n|---|---|---|---|---|---|\n");
  for (const int evaluations : {0, 3, 2, 1}) {
    for (const int pcg : {0, 6, 3, 2, 1}) {
      const Budget budget{evaluations, pcg};
      const ObservedRun made =
          run(folder, fmt::format("{}_{}", evaluations, pcg), duration_s, budget.overrides());
      const auto& s = made.summary;
      const std::string row = fmt::format("| {} | {} |", number(evaluations), number(pcg));
      if (made.exit_code != 0) {
        fmt::print("{} {} | | | |\n", row, s.at("status").get<std::string>());
        continue;
      }
      fmt::print("{} {:.2f} | {:.2f} | {:.1e} | {:.1e} |\n", row,
                 1e3 * s.at("wall_s").get<double>() / s.at("macro_steps").get<double>(),
                 s.at("iterations").at("mean").get<double>(),
                 s.at("residual").at("part_of_wrench").get<double>(),
                 motion_distance(made.history, strict.history).max_m / travel_m);
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace tandem::orchestrator

int main(int count, char** arguments) {
  try {
    tandem::orchestrator::table(count > 1 ? std::stod(arguments[1]) : 1.0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "budget: %s\n", error.what());
    return 1;
  }
}

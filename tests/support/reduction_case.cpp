#include "tests/support/reduction_case.h"

#include <algorithm>

#include "protocol/contract/error.h"

namespace tandem::coupled_test {

double TipMotion::largest_m() const {
  double largest = 0.0;
  for (const Eigen::Vector3d& u : bending_m) largest = std::max(largest, u.norm());
  return largest;
}

TipMotion falling_beam(const std::string& formulation, double young_Pa, double duration_s,
                       int modes) {
  CoupledPair pair("pendulum_beam/scenario.yaml",
                   {{"fem.formulation", formulation},
                    {"fem.material.young_Pa", text_of(young_Pa)},
                    {"fem.craig_bampton.modes", std::to_string(modes)},
                    {"run.duration_s", text_of(duration_s)},
                    // Backward Euler leaves the circle by (H ω)²/2: 1e-6 of the length.
                    {"run.macro_step_s", "2.5e-4"},
                    // A stiff mesh leaves round-off in the residual that no iteration removes.
                    {"coupling.tolerance_N", "1e-6"}});
  TipMotion tip;
  Eigen::Vector3d arm_start = Eigen::Vector3d::Zero();
  const RunReport report = pair.run(orchestrator::Mode::Inproc, [&](const Sample& sample) {
    const Motion& hub = sample.motions.at(0);
    const Eigen::Vector3d arm =
        hub.q_WP.conjugate() * (pair.fem().mean_motion("tip").position_m - hub.p_WP);
    if (tip.bending_m.empty()) arm_start = arm;
    tip.bending_m.emplace_back(arm - arm_start);
  });
  require(report.status == RunStatus::Done, "falling_beam: " + report.message);
  return tip;
}

double largest_distance_m(const TipMotion& a, const TipMotion& b) {
  require(a.bending_m.size() == b.bending_m.size(), "falling_beam: runs of different length.");
  double largest = 0.0;
  for (std::size_t k = 0; k < a.bending_m.size(); ++k) {
    largest = std::max(largest, (a.bending_m[k] - b.bending_m[k]).norm());
  }
  return largest;
}

}  // namespace tandem::coupled_test

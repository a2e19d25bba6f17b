// A free body that tumbles: a block, soft or of steel, on a small body, spun about its middle axis.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

const std::string kScenario = "../tests/data/coupled/systems/tumbling.yaml";

struct Tumbling {
  double angular_momentum = 0.0;  ///< at the start (kg m²/s)
  double drift = 0.0;             ///< its largest change
  double linear_drift = 0.0;      ///< of the linear momentum (kg m/s)
  double tips_by = 0.0;           ///< how far the body's y axis leaves where it was (rad)
};

Tumbling tumble(CoupledPair::Overrides overrides, double H_s) {
  overrides.push_back({"run.macro_step_s", text_of(H_s)});
  CoupledPair pair(kScenario, overrides);
  Tumbling tumbling;
  Eigen::Vector3d start, linear;
  const RunReport report = pair.run(Mode::Inproc, [&](const Sample& sample) {
    const Eigen::Vector3d now = pair.angular_momentum();
    if (sample.applied.empty()) {
      start = now;
      linear = pair.linear_momentum();
      tumbling.angular_momentum = start.norm();
    }
    tumbling.drift = std::max(tumbling.drift, (now - start).norm());
    tumbling.linear_drift =
        std::max(tumbling.linear_drift, (pair.linear_momentum() - linear).norm());
    const Eigen::Vector3d axis = sample.motions[0].q_WP * Eigen::Vector3d::UnitY();
    tumbling.tips_by = std::max(tumbling.tips_by, std::acos(std::clamp(axis.y(), -1.0, 1.0)));
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  return tumbling;
}

CoupledPair::Overrides of(const char* young_Pa) { return {{"fem.material.young_Pa", young_Pa}}; }

// The rigid body is a ball, so all of the tumbling is the flexible body's own: the first-order pair
// keeps its momenta to what the scheme leaves of the wrench in steps of 10 mrad.
TEST(Tumbling, KeepsItsMomentaWithTheDefaultIntegrators) {
  for (const char* young_Pa : {"2e5", "2e9"}) {
    const Tumbling tumbling = tumble(of(young_Pa), 1e-3);
    EXPECT_GT(tumbling.tips_by, 1.0) << young_Pa;
    EXPECT_LT(tumbling.drift, 1e-9 * tumbling.angular_momentum) << young_Pa;
    EXPECT_LT(tumbling.linear_drift, 1e-9) << young_Pa;
  }
}

// The second-order pair has a drift of second order where it resolves the body. Of the stiff one an
// offset is left of the first steps, whose wrenches know nothing of the port's acceleration.
TEST(Tumbling, KeepsItsAngularMomentumToSecondOrderWithTheSecondOrderPair) {
  for (const char* young_Pa : {"2e5", "2e9"}) {
    CoupledPair::Overrides overrides = of(young_Pa);
    overrides.push_back({"mbs.integrator", "verlet"});
    overrides.push_back({"fem.integrator.kind", "generalised_alpha"});
    const Tumbling coarse = tumble(overrides, 1e-3);
    const Tumbling fine = tumble(overrides, 5e-4);
    EXPECT_GT(fine.tips_by, 1.0) << young_Pa;
    EXPECT_LT(coarse.drift, 1e-3 * coarse.angular_momentum) << young_Pa;
    const bool resolved = std::string(young_Pa) == "2e5";
    EXPECT_LT(fine.drift, (resolved ? 0.35 : 0.6) * coarse.drift) << young_Pa;
  }
}

}  // namespace
}  // namespace tandem::coupled_test

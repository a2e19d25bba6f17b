#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fem_process/turning/elastic_turn.h"
#include "tests/support/reduction_case.h"

namespace tandem::coupled_test {
namespace {

// A reduced body is linear in its frame: what it lacks, first of all the shortening of the bent
// beam, is quadratic in the deflection. Ten times the stiffness, a tenth of the deflection, a
// hundredth of the distance.
TEST(CoupledReduction, AgreesWithTheFullBodyAtSmallAndPartsAtLargeDeformation) {
  double deflections[2] = {};
  double distances[2] = {};
  for (int i = 0; i < 2; ++i) {
    const double young_Pa = i == 0 ? 5e8 : 5e7;
    const TipMotion whole = falling_beam("corotational", young_Pa, 0.15);
    const TipMotion reduced = falling_beam("craig_bampton", young_Pa, 0.15);
    deflections[i] = whole.largest_m();
    distances[i] = largest_distance_m(whole, reduced);
  }
  EXPECT_LT(distances[0], 1e-2 * deflections[0]);
  EXPECT_GT(distances[1], 1e-2 * deflections[1]);
  const double order =
      std::log(distances[1] / distances[0]) / std::log(deflections[1] / deflections[0]);
  EXPECT_NEAR(order, 2.0, 0.3);
}

// The beam of the example bends over its length: the run says so. A hundred times as stiff it does
// not. The full body may bend as it likes.
TEST(CoupledReduction, TellsHowFarElementsTurned) {
  const auto turn_rad = [](const std::string& formulation, double young_Pa) {
    CoupledPair pair("pendulum_beam/scenario.yaml", {{"fem.formulation", formulation},
                                                     {"fem.material.young_Pa", text_of(young_Pa)},
                                                     {"run.duration_s", "0.5"}});
    return pair.run(orchestrator::Mode::Inproc, [](const Sample&) {}).elastic_turn_rad;
  };
  EXPECT_GT(turn_rad("craig_bampton", 5e6), 3.0 * fem::kMostElasticTurn_rad);
  const double stiff_rad = turn_rad("craig_bampton", 5e8);
  EXPECT_LT(stiff_rad, 0.1 * fem::kMostElasticTurn_rad);
  EXPECT_GT(stiff_rad, 1e-3);
  EXPECT_EQ(turn_rad("corotational", 5e6), 0.0);
}

TEST(CoupledReduction, TipConvergesWithTheNumberOfModes) {
  const TipMotion many = falling_beam("craig_bampton", 5e8, 0.1, 60);
  double last = many.largest_m();
  for (int modes : {4, 12, 36}) {
    const double distance =
        largest_distance_m(many, falling_beam("craig_bampton", 5e8, 0.1, modes));
    EXPECT_LT(distance, 0.3 * last) << modes;
    last = distance;
  }
  EXPECT_LT(last, 1e-4 * many.largest_m());
}

/// Way of the lug's eye against its base, in the base's axes (m).
std::vector<Eigen::Vector3d> eye_of_lug(const std::string& formulation) {
  CoupledPair pair("lug/scenario.yaml",
                   {{"fem.formulation", formulation}, {"run.duration_s", "0.3"}});
  std::vector<Eigen::Vector3d> way;
  const RunReport report = pair.run(orchestrator::Mode::Monolithic, [&](const Sample& sample) {
    const Motion& base = sample.motions.at(0);
    way.emplace_back(base.q_WP.conjugate() * (sample.motions.at(1).p_WP - base.p_WP) -
                     Eigen::Vector3d(0, 0, 0.072));
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  return way;
}

// Two ports, a frame carried by both. The lug of elastomer bends by 3 % of its length; the reduced
// one follows to a few percent of that.
TEST(CoupledReduction, LugCarriesItsPayloadLikeTheFullBody) {
  const auto whole = eye_of_lug("corotational");
  const auto reduced = eye_of_lug("craig_bampton");
  double deflection = 0.0;
  double distance = 0.0;
  for (std::size_t k = 0; k < whole.size(); ++k) {
    deflection = std::max(deflection, whole[k].norm());
    distance = std::max(distance, (whole[k] - reduced[k]).norm());
  }
  EXPECT_LT(distance, 0.03 * deflection);
}

}  // namespace
}  // namespace tandem::coupled_test

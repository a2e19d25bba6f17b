// The belt drive of the examples against the one-dimensional theory of belts: creep under load, and
// the tension ratio of a belt that slips.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/beam_pair.h"

namespace tandem::coupled_test {
namespace {

const std::string kBelt = "belt_drive/scenario.yaml";

/// The belt and the pulleys of the example.
constexpr double kYoung_Pa = 3e8, kWidth_m = 0.04, kHeight_m = 0.001, kRadius_m = 0.1;
constexpr double kLine_m = kRadius_m + 0.5 * kHeight_m;  ///< radius of the centre line
constexpr double kDensity = 3600.0, kStiffness = 1e9, kSlope = 2e6;

/// Strain of a St. Venant-Kirchhoff bar under the tension T: T = E A λ (λ² − 1)/2.
double strain_of(double tension_N) {
  const double relative = tension_N / (kYoung_Pa * kWidth_m * kHeight_m);
  double stretch = 1.0 + relative;
  for (int k = 0; k < 50; ++k) {
    stretch -=
        (0.5 * stretch * (stretch * stretch - 1.0) - relative) / (1.5 * stretch * stretch - 0.5);
  }
  return stretch - 1.0;
}

/// Tension after half a turn of a pulley that is entered with `tension_N` and the slip velocity
/// `slip` (m/s), friction trilinear: dT/dφ = ± w R (R/R_line) min(v_s s, μ T/(R w)), and the slip
/// grows as the belt's speed changes with its strain [Leamy & Wasfy 2002].
double tension_after(double tension_N, double slip, double sign, double friction, double speed) {
  const int n = 2000;
  const double step = std::numbers::pi / n;
  double T = tension_N;
  double s = slip;
  for (int i = 0; i < n; ++i) {
    const double traction = std::min(kSlope * s, friction * T / (kRadius_m * kWidth_m));
    const double change = step * kWidth_m * kRadius_m * kRadius_m / kLine_m * traction;
    const double before = strain_of(T);
    T += sign * change;
    s += sign * speed * (strain_of(T) - before);
  }
  return T;
}

/// The slip at the entry that makes the tension fall (driver) or grow (driven) from one to other.
double entry_slip(double from_N, double to_N, double friction, double speed) {
  const double sign = to_N > from_N ? 1.0 : -1.0;
  double low = 0.0;
  double high = 0.1 * speed;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    const double reached = tension_after(from_N, middle, sign, friction, speed);
    ((reached - to_N) * sign < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Means {
  int count = 0;
  double driver = 0.0, driven = 0.0;  ///< rad/s
  double axle_N = 0.0;                ///< pull on the driven pulley
  double torque_Nm = 0.0;             ///< of the belt on it
};

Means run(const std::vector<std::string>& overrides, double from_s) {
  BeamPair pair(kBelt, overrides);
  Means sum;
  const RunReport report = pair.run([&](const BeamPair& now) {
    if (now.t_s() <= from_s) return;
    ++sum.count;
    sum.driver += now.body("driver").w_WB.y();
    sum.driven += now.body("driven").w_WB.y();
    const Wrench& wrench = now.fem().sums().wheels[1];
    sum.axle_N -= wrench.f_P_W.x();
    sum.torque_Nm += wrench.t_P_W.y();
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  const double n = sum.count;
  return {sum.count, sum.driver / n, sum.driven / n, sum.axle_N / n, sum.torque_Nm / n};
}

TEST(AncfBelt, CreepsAsTheTheoryOfBelts) {
  const Means seen = run({"run.duration_s=0.9", "fem.ancf.chain.elements=32"}, 0.7);
  EXPECT_NEAR(seen.torque_Nm, 8.0, 0.1);
  const double difference = seen.torque_Nm / kLine_m;
  const double speed = kLine_m * seen.driver;
  const double centripetal = kDensity * kWidth_m * kHeight_m * speed * speed;
  const double tight = 0.5 * (seen.axle_N + difference) + centripetal;
  const double slack = 0.5 * (seen.axle_N - difference) + centripetal;
  // At both entries the belt runs with the pulley but for the slip that friction needs there, on a
  // radius that the pressure T/(R w) makes smaller.
  const auto radius = [](double T) { return kRadius_m - T / (kRadius_m * kWidth_m) / kStiffness; };
  const double driver =
      ((1.0 + strain_of(tight)) * speed + entry_slip(tight, slack, 0.5, speed)) / radius(tight);
  const double driven =
      ((1.0 + strain_of(slack)) * speed - entry_slip(slack, tight, 0.5, speed)) / radius(slack);
  const double creep = 1.0 - driven / driver;
  EXPECT_GT(creep, 0.006);
  // 32 elements bend onto the pulley over a twentieth of a turn: 4 %, with 48 it is 2 %.
  EXPECT_NEAR(1.0 - seen.driven / seen.driver, creep, 0.06 * creep);
}

TEST(AncfBelt, SlipsAtTheTensionRatioOfEuler) {
  // The driven pulley has the lower friction and more load than the belt can carry.
  const Means seen =
      run({"run.duration_s=0.5", "fem.ancf.chain.elements=32", "fem.ancf.wheels.1.friction=0.3",
           "fem.ancf.wheels.0.friction=1.0", "mbs.forces.load.law.value_end=30"},
          0.4);
  EXPECT_LT(seen.driven, 0.9 * seen.driver);
  const double difference = seen.torque_Nm / kLine_m;
  // The pull on the axle is that of the tensions less the belt's centripetal force: what presses.
  const double ratio = (seen.axle_N + difference) / (seen.axle_N - difference);
  // e^{μφ}, with friction on the inner face and tension on the centre line.
  const double expected = std::exp(0.3 * std::numbers::pi * kRadius_m / kLine_m);
  EXPECT_NEAR(ratio, expected, 0.03 * expected);
}

}  // namespace
}  // namespace tandem::coupled_test

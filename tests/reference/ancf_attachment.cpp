// Ends of ANCF chains that are fixed to bodies: moments and forces of a clamped beam, a load on a
// rope, against closed forms.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/ancf_support.h"
#include "tests/support/beam_pair.h"

namespace tandem::coupled_test {
namespace {

using fem::ancf::BeamBody;
using fem::ancf::BeamMaterial;
using fem::ancf::BeamParams;
using fem::ancf::ElasticLaw;
using fem::ancf::Support;

/// L = 1 m, 0.02 × 0.01 m, no lateral contraction, clamped to the ground and to a port at its tip.
constexpr double kYoung = 2e8;
constexpr double kHeight = 0.01;
constexpr double kBending = kYoung * 0.02 * kHeight * kHeight * kHeight / 12.0;  // E I
constexpr int kElements = 32;
/// The elements are too stiff in bending by this, see AncfStatics.
constexpr double kLocking = 0.25 / (kElements * kElements);

BeamParams tip_clamped() {
  BeamParams params;
  BeamMaterial material = BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, kYoung, 0.0);
  material.density_kg_per_m3 = 7200.0;
  material.dilatation_s = material.deviation_s = 0.04;
  params.model = fem::ancf::testing::straight_beam(1.0, kElements, {0.02, kHeight}, material);
  params.ports = {"tip"};
  params.attachments = {{.port = 0, .at_end = true, .support = Support::Clamped}};
  params.micro_step = SimTime(10'000'000);
  return params;
}

/// From 0 to 1, at rest at both ends.
double progress(double t) { return t * t * (3.0 - 2.0 * t); }
double progress_rate(double t) { return 6.0 * t * (1.0 - t); }

/// The wrench at the port after the tip was taken along `path` in one second and then held for
/// four, in which the slowest vibration (10 rad/s, 20 % of critical) falls to 3e-4.
Wrench wrench_after(const std::function<Motion(double)>& path) {
  BeamBody beam(tip_clamped());
  beam.initialize({path(0.0)});
  StepResult<WrenchSet> result;
  for (int k = 0; k < 500; ++k) {
    const double t = 0.01 * k;
    result = beam.advance({.step = SimTime(10'000'000),
                           .input = {{path(std::min(t, 1.0))}, {path(std::min(t + 0.01, 1.0))}}});
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    if (result.outcome != Outcome::Done) return {};
  }
  return result.output.front();
}

TEST(AncfAttachment, AClampedTipTurnedAlongACircleFeelsTheMomentOfPureBending) {
  // Angle φ = 1 rad at the tip, which goes up: a circular arc of length L with M = E I φ/L. The
  // port's frame lies at the tip with v = dp/dt while it moves.
  const auto path = [](double t) {
    // The quotients below are lost to round-off at 0.
    const double angle = std::max(progress(t), 1e-4);
    const double rate = progress_rate(t);
    Motion tip;
    tip.p_WP = {std::sin(angle) / angle, 0.0, (1.0 - std::cos(angle)) / angle};
    tip.q_WP = Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY());
    tip.v_WP =
        rate * Eigen::Vector3d(std::cos(angle) / angle - std::sin(angle) / (angle * angle), 0.0,
                               std::sin(angle) / angle - (1.0 - std::cos(angle)) / (angle * angle));
    tip.w_WP = {0.0, -rate, 0.0};
    return tip;
  };
  const Wrench wrench = wrench_after(path);
  // It turns the body back. Locking; and Green's strain of a fibre, quadratic in its distance from
  // the centre line, would shorten that by 1.5 (h φ/L)²/12 = 1e-5: the tip holds it, at some
  // 1000 E I/L³ for such a shallow arc. Elements that stretch when bent add with 1/n⁴.
  const double holding = 1000.0 * 1.5 * kHeight * kHeight / 12.0;
  EXPECT_NEAR(wrench.t_P_W.y(), kBending, (kLocking + holding) * kBending);
  EXPECT_LT(wrench.f_P_W.norm(), 2.0 * holding * kBending);
  EXPECT_LT(std::abs(wrench.t_P_W.x()) + std::abs(wrench.t_P_W.z()), 1e-9);
}

TEST(AncfAttachment, AClampedTipMovedSidewaysFeelsTheForceAndMomentOfTheBeam) {
  // 12 E I δ/L³ and 6 E I δ/L², about a port 0.1 m beyond the tip.
  const double delta = 1e-4;  // the tension of its lengthening is of second order
  const auto path = [&](double t) {
    Motion port;
    port.p_WP = {1.1, 0.0, delta * progress(t)};
    port.v_WP = {0.0, 0.0, delta * progress_rate(t)};
    return port;
  };
  const Wrench wrench = wrench_after(path);
  const double force = 12.0 * kBending * delta;
  // Two cantilevers of half the elements each lock four times as much; shear yields by
  // 12 E I/(k G A L²) < 0.1 %, the rest is vibration.
  const double locked = force * (1.0 + 4.0 * kLocking);
  EXPECT_NEAR(wrench.f_P_W.z(), -locked, 2e-3 * force);
  // The moment about the tip turns the body about −y; the arm of −0.1 m along x adds to it.
  EXPECT_NEAR(wrench.t_P_W.y(), -0.5 * locked - 0.1 * locked, 2e-3 * force);
}

/// Bodies and forces of the rope crane, one entry per macro step.
struct Swing {
  std::vector<double> t_s, angle, length, trolley_N, load_N;
  double load_turn = 0.0;
};

Swing crane(const std::vector<std::string>& overrides) {
  BeamPair pair("rope_crane/scenario.yaml", overrides);
  Swing swing;
  const RunReport report = pair.run([&](const BeamPair& now) {
    const Eigen::Vector3d d = now.body("load").p_WB - now.body("trolley").p_WB;
    swing.t_s.push_back(now.t_s());
    swing.angle.push_back(std::atan2(d.x(), -d.z()));
    swing.length.push_back(d.norm());
    swing.trolley_N.push_back(now.fem().sums().wheels[0].f_P_W.z());
    swing.load_N.push_back(now.fem().sums().wheels[1].f_P_W.z());
    swing.load_turn =
        std::max(swing.load_turn, std::abs(now.body("load").q_WB.vec().cwiseAbs().maxCoeff()));
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_LT(report.iterations_max, 5);
  return swing;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

constexpr double kLoad = 50.0;
/// Stress-free: 2 m / (1 + strain) of 1100 kg/m³ and 1 cm².
constexpr double kRope = 1100.0 * 1e-4 * 2.0 / 1.0049;

TEST(AncfAttachment, ARopeCarriesItsLoadAndItself) {
  const Swing hanging = crane({"run.duration_s=2", "mbs.joints.rail.motor.law.value_end=0"});
  // Means over ten axial periods of 0.2 s; the load rises and falls by some 50 µm at first.
  EXPECT_NEAR(mean(hanging.load_N), kLoad * 9.81, 1e-3 * kLoad * 9.81);
  EXPECT_NEAR(mean(hanging.trolley_N), -(kLoad + kRope) * 9.81, 1e-3 * kLoad * 9.81);
  // What is left of that axial vibration after two seconds, 3 % of critical, is 15 %.
  EXPECT_NEAR(hanging.load_N.back(), kLoad * 9.81, 2e-3 * kLoad * 9.81);
}

TEST(AncfAttachment, ALoadOnARopeSwingsAsAPendulum) {
  const Swing swing = crane({"run.duration_s=7"});
  std::vector<double> crossings;
  double largest = 0.0;
  for (std::size_t i = 1; i < swing.t_s.size(); ++i) {
    if (swing.t_s[i] < 1.0) continue;
    largest = std::max(largest, std::abs(swing.angle[i]));
    if ((swing.angle[i - 1] < 0.0) != (swing.angle[i] < 0.0)) {
      const double part = swing.angle[i - 1] / (swing.angle[i - 1] - swing.angle[i]);
      crossings.push_back(swing.t_s[i - 1] + part * (swing.t_s[i] - swing.t_s[i - 1]));
    }
  }
  ASSERT_GE(crossings.size(), 4U);
  const double period =
      2.0 * (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  // 2 π √(L/g), longer by θ²/16 of the amplitude, shorter by m_rope/(12 m).
  const double expected = 2.0 * std::numbers::pi * std::sqrt(mean(swing.length) / 9.81) *
                          (1.0 + largest * largest / 16.0 - kRope / (12.0 * kLoad));
  EXPECT_GT(largest, 0.05);
  EXPECT_NEAR(period, expected, 1e-3 * expected);
  // Hinged: no moment reaches the load.
  EXPECT_LT(swing.load_turn, 1e-9);
}

}  // namespace
}  // namespace tandem::coupled_test

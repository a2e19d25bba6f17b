#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tests/support/fem_ports.h"
#include "tests/support/fem_support.h"
#include "tests/support/turning_bar.h"

namespace tandem::fem {
namespace {

using namespace testing;

MotionSet hub(double t) {
  const Eigen::Vector3d w(0.0, 0.0, kRate_rad_per_s);
  return {{.p_WP = kAxisPoint, .q_WP = rotation(w * t), .w_WP = w}};
}

/// Mean over the tip's nodes of how far they are from the axis along the bar (m).
double reach(const FlexibleBody& body, double t) {
  const std::vector<int>& tip = find_set(body.model().mesh, {"RIGHT"}).nodes;
  const Eigen::Vector3d along =
      rotation(Eigen::Vector3d(0, 0, kRate_rad_per_s * t)) * Eigen::Vector3d::UnitX();
  double sum = 0.0;
  for (int node : tip) {
    const Eigen::Vector3d r = body.state().x.segment<3>(3 * node) - kAxisPoint;
    sum += along.dot(r);
  }
  return sum / static_cast<double>(tip.size());
}

class FemTurning : public ::testing::TestWithParam<TurningBarKind> {};

// Limits: extension 1 % (3 % at half a radian per step), of which the prestress of the strained bar
// takes 1e-4; the end forces of Newmark's family m ω² r_c within 0.1 %; those of backward Euler are
// means over the step's arc, sin(ωh/2)/(ωh/2) of that, to 1e-4; torque 1e-6 of force times length;
// kinetic energy 0.1 %. Dissipative weights let the bar come to rest in turning axes.
TEST_P(FemTurning, KnowsNothingOfTheStepsTurn) {
  const auto& [integrator, formulation, order] = GetParam();
  for (double turn : {0.01, 0.1, 0.3, 0.5}) {
    SCOPED_TRACE(turn);
    const Params params = bar(integrator, formulation, order, turn);
    FlexibleBody body(params);
    const Static expected = centrifugal(body.model());
    body.initialize(hub(0.0));
    const double h = to_seconds(params.micro_step);
    const int steps = turn < 0.05 ? 2000 : 600;
    double extension = 0.0;
    double force = 0.0;
    double torque = 0.0;
    const int last = 100;
    for (int k = 1; k <= steps; ++k) {
      const auto result = body.advance(request(hub((k - 1) * h), hub(k * h), params.micro_step));
      ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
      if (k <= steps - last) continue;
      extension += (reach(body, k * h) - 4.0) / last;
      force += result.output[0].f_P_W.norm() / last;
      torque += result.output[0].t_P_W.z() / last;  // about the shaft
    }
    EXPECT_NEAR(extension / expected.extension_m, 1.0, turn < 0.4 ? 0.01 : 0.03);
    const bool means = integrator.kind == IntegratorKind::BackwardEuler;
    const double mean = means ? std::sin(0.5 * turn) / (0.5 * turn) : 1.0;
    EXPECT_NEAR(force / (mean * expected.force_N), 1.0, means ? 1e-4 : 1e-3);
    EXPECT_LT(std::abs(torque), 1e-6 * expected.force_N * 4.0);
    EXPECT_NEAR(body.observe().energy.kinetic_J / expected.kinetic_J, 1.0, 1e-3);
  }
}

// Averaging ports and bushings: the nodes of the face are held on average, so the load at the hub
// spreads, and the bushing gives way by m ω² r_c/k.
TEST_P(FemTurning, OnAveragingPortsAndBushingsLikewise) {
  const auto& [integrator, formulation, order] = GetParam();
  const bool means = integrator.kind == IntegratorKind::BackwardEuler;
  for (const scenario::Attachment& attachment : {averaging(), bushing(1e9, 1e9)}) {
    Params params = bar(integrator, formulation, order, 0.1);
    params.ports[0].attachment = attachment;
    const double stiffness = 1e9;
    params.ports[0].attachment.bushing.damping = 1e6 * scenario::Matrix6::Identity();
    FlexibleBody body(params);
    double mass = 0.0;
    for (double m : body.model().nodal_mass) mass += m;
    const double w2 = kRate_rad_per_s * kRate_rad_per_s;
    const double expected = mass * w2 * 2.0;  // m ω² r_c
    body.initialize(hub(0.0));
    const double h = to_seconds(params.micro_step);
    double force = 0.0;
    double torque = 0.0;
    const int steps = 2000;
    const int last = 100;
    EnergyBook settled;
    for (int k = 1; k <= steps; ++k) {
      const auto result = body.advance(request(hub((k - 1) * h), hub(k * h), params.micro_step));
      ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
      if (k == steps - last) settled = body.observe().energy;
      if (k <= steps - last) continue;
      force += result.output[0].f_P_W.norm() / last;
      torque += result.output[0].t_P_W.z() / last;
    }
    const double mean = means ? std::sin(0.05) / 0.05 : 1.0;
    const bool gives = attachment.kind == scenario::AttachmentKind::Bushing;
    const EnergyBook end = body.observe().energy;
    EXPECT_LT(std::abs(end.damping_loss_J - settled.damping_loss_J), 1e-6 * end.kinetic_J);
    // The bar moves out by F/k, which adds that part of its mean radius.
    const double out = gives ? 1.0 / (1.0 - mass * w2 / stiffness) : 1.0;
    EXPECT_NEAR(force / (mean * expected * out), 1.0, 1e-3) << gives;
    EXPECT_LT(std::abs(torque), 1e-6 * expected * 4.0) << gives;
  }
}

// A thousand turns in steps of 0.3 rad: nothing drifts, and no work is done on what turns steadily.
TEST_P(FemTurning, ForAThousandTurns) {
  const auto& [integrator, formulation, order] = GetParam();
  if (order == 2) return;  // the same step, ten times as long
  const double turn = 0.3;
  const Params params = bar(integrator, formulation, order, turn);
  FlexibleBody body(params);
  body.initialize(hub(0.0));
  const double h = to_seconds(params.micro_step);
  const int settled = 2000;
  const int steps = settled + static_cast<int>(1000 * 2.0 * M_PI / turn);
  EnergyBook begin;
  double reach_begin = 0.0;
  for (int k = 1; k <= steps; ++k) {
    const auto result = body.advance(request(hub((k - 1) * h), hub(k * h), params.micro_step));
    ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
    if (k != settled) continue;
    begin = body.observe().energy;
    reach_begin = reach(body, k * h);
  }
  const EnergyBook end = body.observe().energy;
  EXPECT_NEAR(end.kinetic_J / begin.kinetic_J, 1.0, 1e-9);
  EXPECT_NEAR(end.elastic_J / begin.elastic_J, 1.0, 1e-6);
  EXPECT_NEAR(reach(body, steps * h), reach_begin, 1e-12 * 4.0 * 1000);
  for (double work :
       {end.interface_work_J - begin.interface_work_J, end.damping_loss_J - begin.damping_loss_J,
        end.numerical_loss_J - begin.numerical_loss_J}) {
    EXPECT_LT(std::abs(work), 1e-6 * 1000 * begin.kinetic_J);
  }
}

/// Spun up as sin² from rest to the rate within 0.4 s; the books' error against the kinetic energy.
double spin_up_error(Params params, double h) {
  params.micro_step = sim_time_from_seconds(h);
  params.initial_velocity = {};
  FlexibleBody body(params);
  const auto motion = [](double t) {
    constexpr double kEnd_s = 0.4;
    const double s = M_PI * std::min(t, kEnd_s) / kEnd_s;
    const double rate = 0.5 * kRate_rad_per_s * (1.0 - std::cos(s));
    const double angle = 0.5 * kRate_rad_per_s * kEnd_s * (s - std::sin(s)) / M_PI;
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    return MotionSet{{.p_WP = kAxisPoint, .q_WP = rotation(z * angle), .w_WP = z * rate}};
  };
  body.initialize(motion(0.0));
  const EnergyBook begin = body.observe().energy;
  double worst = 0.0;
  for (int k = 1; k * h <= 0.4 + 1e-9; ++k) {
    const auto result =
        body.advance(request(motion((k - 1) * h), motion(k * h), params.micro_step));
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    const EnergyBook book = body.observe().energy;
    worst = std::max(worst, std::abs(balance_error_J(begin, book)));
  }
  return worst / body.observe().energy.kinetic_J;
}

// Elements are linearised once a step: what that leaves in the books is of second order; first and
// second order methods alike stand far above what their integration loses.
TEST_P(FemTurning, BooksOfASpinUpClose) {
  const auto& [integrator, formulation, order] = GetParam();
  const Params params = bar(integrator, formulation, order, 0.1);
  const double coarse = spin_up_error(params, 2e-3);
  const double fine = spin_up_error(params, 1e-3);
  EXPECT_LT(coarse, integrator.kind == IntegratorKind::BackwardEuler ? 1e-5 : 1e-3);
  EXPECT_LT(fine, std::max(0.3 * coarse, 1e-9));
}

INSTANTIATE_TEST_SUITE_P(Kinds, FemTurning,
                         ::testing::Combine(::testing::Values(IntegratorParams{}, kHht,
                                                              kGeneralised),
                                            kFormulations, ::testing::Values(1, 2)));
}  // namespace
}  // namespace tandem::fem

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <tuple>

#include "tests/support/fem_box.h"
#include "tests/support/fem_ports.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

// A steel bar of four unit cubes that turns at a constant rate about its clamped end, against the
// static centrifugal solution on the same mesh, K u = ω² M X, and closed forms of a turning body.
constexpr double kRate_rad_per_s = 20.0;
const Eigen::Vector3d kAxisPoint(0.0, 0.5, 0.5);

Params bar(const IntegratorParams& integrator, FormulationKind formulation, int order,
           double turn_rad) {
  static const std::filesystem::path file = temporary_file("turning.inp", box_inp(4));
  Params params;
  params.mesh.file = file;
  params.mesh.order = order;
  params.formulation = formulation;
  params.integrator = integrator;
  params.material = {.young_Pa = 2.1e11, .poisson = 0.3, .density_kg_per_m3 = 7850.0};
  params.damping.beta_s = 1e-3;
  params.ports = {{"hub", {"LEFT"}, kAxisPoint}};
  params.initial_velocity = {.angular_rad_per_s = {0.0, 0.0, kRate_rad_per_s},
                             .about_m = kAxisPoint};
  params.micro_step = sim_time_from_seconds(turn_rad / kRate_rad_per_s);
  return params;
}

MotionSet hub(double t) {
  const Eigen::Vector3d w(0.0, 0.0, kRate_rad_per_s);
  return {{.p_WP = kAxisPoint, .q_WP = rotation(w * t), .w_WP = w}};
}

struct Static {
  double extension_m = 0.0;
  double force_N = 0.0;    ///< m ω² r_c
  double kinetic_J = 0.0;  ///< ½ ω² J
};

/// From M and K of the reference alone, densely.
Static centrifugal(const Model& model) {
  const double w2 = kRate_rad_per_s * kRate_rad_per_s;
  Eigen::VectorXd arm = model.reference();
  for (Eigen::Index i = 0; i < arm.size(); i += 3) {
    arm.segment<3>(i) -= kAxisPoint;
    arm(i + 2) = 0.0;
  }
  const Eigen::VectorXd load = w2 * multiply_scalar(model.pattern(), model.mass, arm);
  Eigen::VectorXd f;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f, K);
  const auto n = 3 * static_cast<Eigen::Index>(model.free.size());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  const BlockPattern& pattern = model.interior.pattern;
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      dense.block<3, 3>(3 * i, 3 * pattern.column[static_cast<std::size_t>(b)]) =
          block(K, model.interior.source[static_cast<std::size_t>(b)]);
    }
  }
  Eigen::VectorXd rhs(n);
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    rhs.segment<3>(3 * static_cast<Eigen::Index>(k)) = load.segment<3>(3 * model.free[k]);
  }
  const Eigen::VectorXd u = dense.ldlt().solve(rhs);
  Static found;
  const std::vector<int>& tip = find_set(model.mesh, {"RIGHT"}).nodes;
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    if (std::find(tip.begin(), tip.end(), model.free[k]) == tip.end()) continue;
    found.extension_m += u(3 * static_cast<Eigen::Index>(k)) / static_cast<double>(tip.size());
  }
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < load.size(); i += 3) force += load.segment<3>(i);
  found.force_N = force.norm();
  found.kinetic_J = 0.5 * arm.dot(load);
  return found;
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

class FemTurning
    : public ::testing::TestWithParam<std::tuple<IntegratorParams, FormulationKind, int>> {};

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

// The same bar on a crank: its port goes round at 2 m from the shaft. Backward Euler is as exact as
// about its own end. Newmark's family differences the port's own velocity in W: of what that
// accelerates (ω h)²/12 too much force, and with dissipative weights a torque of third order.
struct Crank {
  static constexpr double kRadius_m = 2.0;
  static MotionSet motion(double t) {
    const Eigen::Vector3d w(0.0, 0.0, kRate_rad_per_s);
    const Eigen::Matrix3d R = rotation(w * t).toRotationMatrix();
    const Eigen::Vector3d r = R * Eigen::Vector3d(kRadius_m, 0.0, 0.0);
    const Eigen::Vector3d centre = kAxisPoint - Eigen::Vector3d(kRadius_m, 0.0, 0.0);
    return {{.p_WP = centre + r, .q_WP = rotation(w * t), .v_WP = w.cross(r), .w_WP = w}};
  }
};

TEST_P(FemTurning, OfABarOnACrankLikewise) {
  const auto& [integrator, formulation, order] = GetParam();
  const bool means = integrator.kind == IntegratorKind::BackwardEuler;
  for (double turn : {0.02, 0.2}) {
    SCOPED_TRACE(turn);
    Params params = bar(integrator, formulation, order, turn);
    params.initial_velocity.about_m = kAxisPoint - Eigen::Vector3d(Crank::kRadius_m, 0.0, 0.0);
    FlexibleBody body(params);
    double mass = 0.0;
    for (double m : body.model().nodal_mass) mass += m;
    const double w2 = kRate_rad_per_s * kRate_rad_per_s;
    const double expected = mass * w2 * (Crank::kRadius_m + 2.0);  // m ω² r_c
    body.initialize(Crank::motion(0.0));
    const double h = to_seconds(params.micro_step);
    const int steps = 600;
    const int last = 100;
    double force = 0.0;
    double torque = 0.0;
    for (int k = 1; k <= steps; ++k) {
      const MotionSet begin = Crank::motion((k - 1) * h);
      const auto result = body.advance(request(begin, Crank::motion(k * h), params.micro_step));
      ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
      if (k <= steps - last) continue;
      const Wrench& wrench = result.output[0];
      force += wrench.f_P_W.norm() / last;
      // About the shaft; the torque of constant forces is about the port at the step's beginning.
      const Eigen::Vector3d about = means ? begin[0].p_WP : Crank::motion(k * h)[0].p_WP;
      const Eigen::Vector3d arm = about - params.initial_velocity.about_m;
      torque += (wrench.t_P_W + arm.cross(wrench.f_P_W)).z() / last;
    }
    const double mean = means ? std::sin(0.5 * turn) / (0.5 * turn) : 1.0;
    EXPECT_NEAR(force / (mean * expected), 1.0, 1e-4 + (means ? 0.0 : 1.1 * turn * turn / 12.0));
    const double third_order = means ? 0.0 : 0.03 * turn * turn * turn;
    EXPECT_LT(std::abs(torque), (1e-6 + third_order) * expected * 4.0);
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

INSTANTIATE_TEST_SUITE_P(
    Kinds, FemTurning,
    ::testing::Combine(
        ::testing::Values(
            IntegratorParams{}, IntegratorParams{.kind = IntegratorKind::Hht, .hht_alpha = -0.3},
            IntegratorParams{.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.5}),
        ::testing::Values(FormulationKind::Corotational, FormulationKind::ConsistentCorotational,
                          FormulationKind::TotalLagrangian),
        ::testing::Values(1, 2)));

}  // namespace
}  // namespace tandem::fem

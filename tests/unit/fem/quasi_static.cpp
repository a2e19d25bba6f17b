#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "fem_process/ports/set_motion.h"
#include "protocol/contract/error.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

Params quasi_static_bar(FormulationKind formulation) {
  Params params = bar_with_two_ports();
  params.formulation = formulation;
  params.integrator.kind = IntegratorKind::QuasiStatic;
  return params;
}

MotionSet at_rest() {
  MotionSet motions(2);
  motions[0].p_WP = {-0.28, 0, 0};
  motions[1].p_WP = {0.28, 0, 0};
  return motions;
}

/// Both ports turned about the origin and shifted.
MotionSet turned(const Eigen::Vector3d& angle, const Eigen::Vector3d& shift) {
  MotionSet motions = at_rest();
  for (Motion& m : motions) {
    m.q_WP = rotation(angle);
    m.p_WP = shift + m.q_WP * m.p_WP;
  }
  return motions;
}

/// Stiffness at rest condensed onto the ports: with nodes x_p = T ξ (ξ: port translations and
/// rotations), S = T^T (K_pp − K_pi K_ii⁻¹ K_ip) T, by dense elimination.
Eigen::MatrixXd condensed_stiffness(const Model& model) {
  const Eigen::Index n = 3 * model.mesh.nodes();
  Eigen::VectorXd f;
  BlockValues values;
  model.formulation->evaluate(model.reference(), f, values);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  const BlockPattern& pattern = model.pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
      K.block<3, 3>(3 * i, 3 * pattern.column[static_cast<std::size_t>(b)]) = block(values, b);
    }
  }
  const auto free = static_cast<Eigen::Index>(3 * model.free.size());
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n, 12);
  Eigen::MatrixXd I = Eigen::MatrixXd::Zero(n, free);
  for (Eigen::Index p = 0; p < 2; ++p) {
    const Eigen::Vector3d origin = at_rest()[static_cast<std::size_t>(p)].p_WP;
    for (int node : model.ports[static_cast<std::size_t>(p)].nodes) {
      const Eigen::Vector3d r = model.mesh.X[static_cast<std::size_t>(node)] - origin;
      T.block<3, 3>(3 * node, 6 * p).setIdentity();
      for (int axis = 0; axis < 3; ++axis) {
        T.block<3, 1>(3 * node, 6 * p + 3 + axis) = Eigen::Vector3d::Unit(axis).cross(r);
      }
    }
  }
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    I.block<3, 3>(3 * model.free[k], 3 * static_cast<Eigen::Index>(k)).setIdentity();
  }
  const Eigen::MatrixXd K_pi = T.transpose() * K * I;
  return T.transpose() * K * T - K_pi * (I.transpose() * K * I).ldlt().solve(K_pi.transpose());
}

// d wrench / d motion = −S for positions and angles, 0 for velocities, whatever the formulation: at
// rest all have the linear stiffness. The dense elimination has a condition number of about 1e6.
TEST(FemQuasiStatic, JacobianAtRestIsTheCondensedStiffness) {
  for (FormulationKind formulation :
       {FormulationKind::Linear, FormulationKind::Corotational, FormulationKind::TotalLagrangian}) {
    FlexibleBody body(quasi_static_bar(formulation));
    const Eigen::MatrixXd S = condensed_stiffness(body.model());
    body.initialize(at_rest());
    const auto result = body.advance(request(at_rest(), at_rest(), SimTime(1'000'000), true));
    ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
    for (Eigen::Index p = 0; p < 2; ++p) {
      const auto found = result.jacobian->middleCols<6>(12 * p);
      EXPECT_LT((found + S.middleCols<6>(6 * p)).norm(), 1e-8 * S.norm());
      EXPECT_EQ(result.jacobian->middleCols<6>(12 * p + 6).norm(), 0.0);
    }
  }
}

// A prism whose ends slide apart without lateral strain (ν = 0): N = E A ε is exact for linear
// tetrahedra. E = 300 Pa, A = 1 m², ε = 0.3/3 m; small strain formulas.
TEST(FemQuasiStatic, TensionOfAPrismIsItsClosedForm) {
  static const std::filesystem::path file = temporary_file("prism.inp", box_inp(3));
  Params params;
  params.mesh.file = file;
  params.material = {.young_Pa = 300.0, .poisson = 0.0, .density_kg_per_m3 = 100.0};
  params.integrator.kind = IntegratorKind::QuasiStatic;
  params.micro_step = SimTime(1'000'000);
  params.fixed = {{"LEFT"}};
  params.ports = {{"port", {"RIGHT"}, Eigen::Vector3d(3.0, 0.5, 0.5)}};
  FlexibleBody body(params);
  MotionSet begin(1);
  begin[0].p_WP = {3.0, 0.5, 0.5};
  MotionSet end = begin;
  end[0].p_WP.x() += 0.3;
  body.initialize(begin);
  const auto result = body.advance(request(begin, end, SimTime(1'000'000)));
  ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
  EXPECT_LT((result.output[0].f_P_W - Eigen::Vector3d(-30.0, 0, 0)).norm(), 30.0 * 1e-8);
  EXPECT_LT(result.output[0].t_P_W.norm(), 30.0 * 1e-8);
}

// Equilibrium knows no path and no time: any rigid motion of both ports gives no wrench, and a
// stretch the same wrench turned with it, after one step or ten. Newton's residual is 1e-8 of the
// forces, squared by the last correction; the linear part of the wrench to it is of order one.
TEST(FemQuasiStatic, WrenchTurnsWithThePortsAndForgetsThePath) {
  for (FormulationKind formulation :
       {FormulationKind::Corotational, FormulationKind::TotalLagrangian}) {
    const Eigen::Vector3d angle(0.2, -0.3, 0.4);
    const Eigen::Vector3d shift(0.1, 2.0, -1.0);
    const auto moved = [&](double part, double stretch) {
      MotionSet motions = turned(part * angle, part * shift);
      motions[1].p_WP += motions[1].q_WP * Eigen::Vector3d(part * stretch, 0, 0);
      return motions;
    };
    const auto wrench_after = [&](int steps, const auto& path) {
      FlexibleBody body(quasi_static_bar(formulation));
      body.initialize(at_rest());
      WrenchSet wrenches;
      for (int k = 0; k < steps; ++k) {
        const auto result = body.advance(
            request(path(1.0 * k / steps), path(1.0 * (k + 1) / steps), SimTime(1'000'000)));
        EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
        wrenches = result.output;
      }
      return wrenches;
    };
    const auto rigid = wrench_after(4, [&](double s) { return moved(s, 0.0); });
    const auto ten = wrench_after(10, [&](double s) { return moved(s, 0.01); });
    const auto four = wrench_after(4, [&](double s) { return moved(s, 0.01); });
    const auto straight = wrench_after(1, [&](double s) {
      MotionSet motions = at_rest();
      motions[1].p_WP.x() += 0.01 * s;
      return motions;
    });
    const double scale = straight[1].f_P_W.norm();
    ASSERT_GT(scale, 100.0);
    EXPECT_LT(rigid[1].f_P_W.norm(), 1e-7 * scale);
    EXPECT_LT((four[1].f_P_W - rotation(angle) * straight[1].f_P_W).norm(), 1e-7 * scale);
    EXPECT_LT((four[1].f_P_W - ten[1].f_P_W).norm(), 1e-7 * scale);
    EXPECT_LT((four[0].t_P_W - ten[0].t_P_W).norm(), 1e-7 * scale);
  }
}

// The lateral pull of one end, 3 s² − 2 s³ of the way over T: inertia is of order 1/T², so that
// the transient wrench at the end of the pull goes to the static one at least as 1/T.
TEST(FemQuasiStatic, IsTheLimitOfSlowTransients) {
  const auto pulled = [](double s) {
    MotionSet motions = at_rest();
    motions[1].p_WP.z() += 0.05 * s * s * (3.0 - 2.0 * s);
    return motions;
  };
  const auto wrench_of = [&](IntegratorParams integrator, double duration_s) {
    Params params = bar_with_two_ports();
    params.integrator = integrator;
    params.damping.alpha_per_s = 20.0;
    const int steps = 60;
    params.micro_step = sim_time_from_seconds(duration_s / steps);
    FlexibleBody body(params);
    body.initialize(pulled(0.0));
    WrenchSet wrenches;
    for (int k = 0; k < steps; ++k) {
      MotionSet begin = pulled(1.0 * k / steps);
      MotionSet end = pulled((k + 1.0) / steps);
      const double s = (k + 1.0) / steps;
      const double s_begin = 1.0 * k / steps;
      begin[1].v_WP.z() = 0.05 * 6.0 * s_begin * (1.0 - s_begin) / duration_s;
      end[1].v_WP.z() = 0.05 * 6.0 * s * (1.0 - s) / duration_s;
      const auto result = body.advance(request(begin, end, params.micro_step));
      EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
      wrenches = result.output;
    }
    return stack(wrenches);
  };
  const Eigen::VectorXd fixed = wrench_of({.kind = IntegratorKind::QuasiStatic}, 1.0);
  double last = 0.0;
  for (double duration_s : {2.0, 4.0, 8.0}) {
    const IntegratorParams newmark{.kind = IntegratorKind::Newmark, .newton_steps = 20};
    const double error = (wrench_of(newmark, duration_s) - fixed).norm() / fixed.norm();
    if (last > 0.0) {
      EXPECT_LT(error, 0.5 * last) << "T = " << duration_s << " s";
    }
    last = error;
  }
  EXPECT_LT(last, 0.01);
}

TEST(FemQuasiStatic, RefusesABodyThatIsNotHeld) {
  Params params = quasi_static_bar(FormulationKind::Corotational);
  params.ports.clear();
  try {
    FlexibleBody body(params);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("not held"), std::string::npos) << error.what();
  }
}

// Loads that stand at t = 0 are in equilibrium there: gravity on the bar between its ports, whose
// wrenches carry the weight.
TEST(FemQuasiStatic, StartsInEquilibrium) {
  Params params = quasi_static_bar(FormulationKind::Corotational);
  params.gravity_m_per_s2 = {0, 0, -9.81};
  FlexibleBody body(params);
  const WrenchSet wrenches = body.initialize(at_rest());
  double mass = 0.0;
  for (double m : body.model().nodal_mass) mass += m;
  EXPECT_NEAR((wrenches[0].f_P_W + wrenches[1].f_P_W).z(), -9.81 * mass, 1e-7 * mass);
  EXPECT_EQ(body.observe().time, SimTime{});
  EXPECT_EQ(body.observe().energy.kinetic_J, 0.0);
  const Observation begin = body.observe();
  body.advance(request(at_rest(), at_rest(), SimTime(1'000'000)));
  EXPECT_NEAR(body.observe().energy.elastic_J, begin.energy.elastic_J,
              1e-7 * begin.energy.elastic_J);
}

// Position and velocity of the law s = 2 t: half a turn about z per second, about the given point.
TEST(FemSetMotion, FollowsItsLaw) {
  SetMotion motion;
  motion.translation_m = {0, 0, 3};
  motion.rotation_rad = {0, 0, 1.5};
  motion.law = Law(RampLaw{.begin_s = 0.0, .end_s = 10.0, .value_end = 20.0});
  const Motion m = motion_at(motion, {1, 2, 3}, 0.4, 0.01);
  EXPECT_LT((m.p_WP - Eigen::Vector3d(1, 2, 3 + 0.8 * 3)).norm(), 1e-12);
  EXPECT_LT((m.v_WP - Eigen::Vector3d(0, 0, 6)).norm(), 1e-9);
  EXPECT_LT((m.w_WP - Eigen::Vector3d(0, 0, 3)).norm(), 1e-9);
  EXPECT_LT(m.q_WP.angularDistance(rotation({0, 0, 1.2})), 1e-12);
}

}  // namespace
}  // namespace tandem::fem

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/support/fem_ports.h"

namespace tandem::fem {
namespace {

using namespace testing;
using scenario::NodeWeights;

constexpr double kArea_m2 = 0.05 * 0.05;
constexpr double kLength_m = 0.5;
constexpr double kYoung_Pa = 5e6;

/// The bar between two kinds of ports, Po in the middle of its end faces.
Params bar(const scenario::Attachment& left, const scenario::Attachment& right) {
  Params params = bar_with_two_ports();
  params.ports[0].attachment = left;
  params.ports[1].attachment = right;
  return params;
}

MotionSet ends(const Motion& right = {.p_WP = {0.25, 0, 0}}) {
  return {{.p_WP = {-0.25, 0, 0}}, right};
}

/// Wrenches once the bar has come to rest at ports that moved by `right` at once: backward Euler
/// with steps of 100 s, where inertia is 1e-8 of the stiffness and loses that much a step.
WrenchSet at_rest(FlexibleBody& body, const MotionSet& motions, int steps = 6) {
  const SimTime step = sim_time_from_seconds(100.0);
  body.initialize(ends());
  StepResult<WrenchSet> result;
  for (int k = 0; k < steps; ++k) {
    result = body.advance(request(motions, motions, step));
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
  }
  return result.output;
}

Params at_leisure(Params params) {
  params.micro_step = sim_time_from_seconds(100.0);
  return params;
}

// Patch test: nodal forces of area weights are those of a uniform traction, so tension is uniform
// to round-off, F = E A δ/L, and the ends contract; a rigid port holds them.
TEST(AveragingPorts, TensionIsUniformAndTheEndsContract) {
  Params params = at_leisure(bar(averaging(NodeWeights::Area), averaging(NodeWeights::Area)));
  params.formulation = FormulationKind::Linear;
  for (int order : {1, 2}) {
    params.mesh.order = order;
    FlexibleBody body(params);
    const double stretch_m = 1e-3;
    const WrenchSet wrenches = at_rest(body, ends({.p_WP = {0.25 + stretch_m, 0, 0}}));
    const double strain = stretch_m / kLength_m;
    const double force_N = kYoung_Pa * kArea_m2 * strain;
    EXPECT_NEAR(wrenches[1].f_P_W.x(), -force_N, 1e-8 * force_N);
    EXPECT_NEAR(wrenches[0].f_P_W.x(), force_N, 1e-8 * force_N);
    for (int i = 0; i < body.model().mesh.nodes(); ++i) {
      const Eigen::Vector3d& X = body.model().mesh.X[static_cast<std::size_t>(i)];
      const Eigen::Vector3d u(strain * (X.x() + 0.25), -0.3 * strain * X.y(),
                              -0.3 * strain * X.z());
      EXPECT_LT((body.state().x.segment<3>(3 * i) - X - u).norm(), 1e-7 * stretch_m);
    }
  }
}

// Ends held against contraction stiffen the bar: by some 0.5 % at this slenderness.
TEST(AveragingPorts, RigidPortsAreStifferInTension) {
  const MotionSet pulled = ends({.p_WP = {0.251, 0, 0}});
  Params params = at_leisure(bar({}, {}));
  params.formulation = FormulationKind::Linear;
  FlexibleBody rigid(params);
  const double exact_N = kYoung_Pa * kArea_m2 * 1e-3 / kLength_m;
  EXPECT_GT(-at_rest(rigid, pulled)[1].f_P_W.x(), 1.003 * exact_N);
}

/// d (wrench on the right port)/d (its displacement and rotation), the left port still: 6 × 6.
Eigen::MatrixXd stiffness_at_right(const Params& params) {
  FlexibleBody body(params);
  Eigen::MatrixXd K(6, 6);
  const double amount = 1e-6;
  for (int c = 0; c < 6; ++c) {
    const Eigen::Vector3d unit = amount * Eigen::Vector3d::Unit(c % 3);
    Motion right{.p_WP = {0.25, 0, 0}};
    if (c < 3) right.p_WP += unit;
    if (c >= 3) right.q_WP = rotation(unit);
    const Wrench wrench = at_rest(body, ends(right))[1];
    K.col(c) << -wrench.f_P_W / amount, -wrench.t_P_W / amount;
  }
  return K;
}

// Springs in series add their compliances: in tension, torsion and bending, with all couplings. The
// bushing's wrench about the right port has the arm L; 1e-6 rad leaves as much of nonlinearity.
TEST(BushingPorts, ComplianceIsThatOfBushingAndBarInSeries) {
  Params params = at_leisure(bar(averaging(NodeWeights::Area), averaging(NodeWeights::Area)));
  params.formulation = FormulationKind::Linear;
  const Eigen::MatrixXd bar_only = stiffness_at_right(params);
  params.ports[0].attachment = full_bushing();
  params.ports[0].attachment.weights = NodeWeights::Area;
  const Eigen::MatrixXd both = stiffness_at_right(params);

  scenario::Matrix6 turn = scenario::Matrix6::Zero();
  const Eigen::Matrix3d R_PB = full_bushing().bushing.q_PB.toRotationMatrix();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = R_PB;
  const scenario::Matrix6 K_W = turn * full_bushing().bushing.stiffness * turn.transpose();
  // Displacement of the right port when the bushing's frame moves by (u, θ): u + θ × L e_x.
  scenario::Matrix6 arm = scenario::Matrix6::Identity();
  for (int c = 0; c < 3; ++c) {
    arm.block<3, 1>(0, 3 + c) = Eigen::Vector3d::Unit(c).cross(Eigen::Vector3d(kLength_m, 0, 0));
  }
  const Eigen::MatrixXd expected = bar_only.inverse() + arm * K_W.inverse() * arm.transpose();
  EXPECT_LT((both.inverse() - expected).norm(), 1e-5 * expected.norm());
}

// 1/k = 1/k_b + L/(E A).
TEST(BushingPorts, TensionInSeriesHasTheClosedForm) {
  const double k_b = 3e4;
  scenario::Attachment soft = bushing(k_b, 40.0);
  soft.weights = NodeWeights::Area;
  Params params = at_leisure(bar(soft, averaging(NodeWeights::Area)));
  params.formulation = FormulationKind::Linear;
  FlexibleBody body(params);
  const double stretch_m = 1e-3;
  const WrenchSet wrenches = at_rest(body, ends({.p_WP = {0.25 + stretch_m, 0, 0}}));
  const double k = 1.0 / (1.0 / k_b + kLength_m / (kYoung_Pa * kArea_m2));
  EXPECT_NEAR(wrenches[0].f_P_W.x(), k * stretch_m, 1e-8 * k * stretch_m);
  const double bushing_m = k * stretch_m / k_b;
  const double energy_J = 0.5 * k_b * bushing_m * bushing_m;
  EXPECT_NEAR(body.state().bushing_J, energy_J, 1e-7 * energy_J);
}

// Both ports turned together by 2.4 rad and shifted, then at rest until backward Euler has damped
// the bar: no force, whatever the attachment. 1e-9 of E A is the round-off of the positions.
TEST(LoosePorts, RigidMotionOfThePortsGivesNoForce) {
  for (const scenario::Attachment& kind : {averaging(), full_bushing()}) {
    Params params = bar(kind, averaging(NodeWeights::Area));
    params.micro_step = SimTime(10'000'000);
    FlexibleBody body(params);
    body.initialize(ends());
    WrenchSet wrenches;
    for (int k = 0; k < 170; ++k) {
      const Eigen::Quaterniond q =
          rotation(std::min(0.15 * (k + 1), 2.4) * Eigen::Vector3d(0.6, 0.0, 0.8));
      MotionSet motions = ends();
      for (Motion& m : motions) {
        m.p_WP = q * m.p_WP + Eigen::Vector3d(0.1, 0.2, 0.3);
        m.q_WP = q;
      }
      const auto result = body.advance(request(motions, motions, params.micro_step));
      ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
      wrenches = result.output;
    }
    for (const Wrench& wrench : wrenches) {
      EXPECT_LT(wrench.f_P_W.norm(), 1e-9 * kYoung_Pa * kArea_m2);
      EXPECT_LT(wrench.t_P_W.norm(), 1e-9 * kYoung_Pa * kArea_m2 * 0.1);
    }
  }
}

const IntegratorParams kHht{.kind = IntegratorKind::Hht, .hht_alpha = -0.1};
const IntegratorParams kNewmark{.kind = IntegratorKind::Newmark};

// While the bar stretches, spins and vibrates: the nodal forces have the wrench's resultants, and
// an averaging port's the wrench's power, to round-off.
TEST(LoosePorts, NodalForcesAreWorkConjugateToTheWrench) {
  for (const IntegratorParams& integrator : {kHht, kNewmark}) {
    for (FormulationKind formulation :
         {FormulationKind::Corotational, FormulationKind::TotalLagrangian}) {
      Params params = bar(averaging(), full_bushing());
      params.ports[0].p_WP = Eigen::Vector3d(-0.28, 0, 0);
      params.integrator = integrator;
      params.formulation = formulation;
      FlexibleBody body(params);
      body.initialize(pair_motion(0.0));
      const LoosePorts ports = loose_ports_of(body.model(), pair_motion(0.0));
      for (int k = 0; k < 5; ++k) {
        const MotionSet end = pair_motion(1e-3 * (k + 1));
        const auto result = body.advance(request(pair_motion(1e-3 * k), end, SimTime(1'000'000)));
        ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
        for (std::size_t p = 0; p < 2; ++p) {
          Eigen::VectorXd f = Eigen::VectorXd::Zero(body.state().x.size());
          ports.ports()[p].average.add_forces(
              body.state().attached.segment<12>(12 * static_cast<Eigen::Index>(p)), 1.0, f);
          Eigen::Vector3d force = result.output[p].f_P_W;
          Eigen::Vector3d torque = result.output[p].t_P_W;
          double power = force.dot(end[p].v_WP) + torque.dot(end[p].w_WP);
          const double size = f.cwiseAbs().sum();
          for (int node : body.model().ports[p].nodes) {
            const Eigen::Vector3d f_i = f.segment<3>(3 * node);
            const Eigen::Vector3d r = body.state().x.segment<3>(3 * node) - end[p].p_WP;
            force += f_i;
            torque += r.cross(f_i);
            power += f_i.dot(Eigen::Vector3d(body.state().v.segment<3>(3 * node)));
          }
          EXPECT_LT(force.norm(), 1e-13 * size);
          EXPECT_LT(torque.norm(), 1e-13 * size);
          if (p == 0) {
            EXPECT_LT(std::abs(power), 1e-12 * size);
          }
        }
      }
    }
  }
}

/// Wrenches of six steps of the spinning, stretching pair, everything turned by `Q`.
std::vector<WrenchSet> wrenches_seen_from(const Eigen::Quaterniond& Q, Params params) {
  params.mesh.orientation = Q;
  for (PortSet& port : params.ports) port.p_WP = Q * *port.p_WP;
  const auto turned = [&](MotionSet motions) {
    for (Motion& m : motions) {
      m = {.p_WP = Q * m.p_WP, .q_WP = Q * m.q_WP, .v_WP = Q * m.v_WP, .w_WP = Q * m.w_WP};
    }
    return motions;
  };
  FlexibleBody body(params);
  std::vector<WrenchSet> all{body.initialize(turned(pair_motion(0.0)))};
  for (int k = 0; k < 6; ++k) {
    all.push_back(body.advance(request(turned(pair_motion(1e-3 * k)),
                                       turned(pair_motion(1e-3 * (k + 1))), SimTime(1'000'000)))
                      .output);
  }
  return all;
}

// Round-off of the solver, 1e-16 times the condition number of the step matrix.
TEST(LoosePorts, WrenchesTurnWithTheWorld) {
  for (const scenario::Attachment& kind : {averaging(), full_bushing()}) {
    Params params = bar_with_two_ports();
    params.ports[1].attachment = kind;
    params.integrator = kHht;
    const Eigen::Quaterniond Q = rotation({1.1, -2.0, 0.7});
    const auto here = wrenches_seen_from(Eigen::Quaterniond::Identity(), params);
    const auto there = wrenches_seen_from(Q, params);
    for (std::size_t k = 0; k < here.size(); ++k) {
      for (std::size_t p = 0; p < 2; ++p) {
        EXPECT_LT((Q * here[k][p].f_P_W - there[k][p].f_P_W).norm(),
                  1e-9 * (1.0 + here[k][p].f_P_W.norm()));
        EXPECT_LT((Q * here[k][p].t_P_W - there[k][p].t_P_W).norm(),
                  1e-9 * (1.0 + here[k][p].t_P_W.norm()));
      }
    }
  }
}

// Towards the averaging port as 1/k: a hundred times the stiffness, a hundredth of the difference.
TEST(BushingPorts, StiffOnesApproachTheAveragingPort) {
  const MotionSet pulled = ends({.p_WP = {0.251, 2e-4, 0}, .q_WP = rotation({1e-3, 2e-3, -1e-3})});
  Params params = at_leisure(bar(averaging(), {}));
  FlexibleBody exact(params);
  const Eigen::VectorXd limit = stack(at_rest(exact, pulled));
  double last = 0.0;
  for (double factor : {1e2, 1e4}) {
    params.ports[0].attachment = bushing(3e4 * factor, 400.0 * factor);
    FlexibleBody body(params);
    const double difference = (stack(at_rest(body, pulled)) - limit).norm() / limit.norm();
    if (last > 0.0) {
      EXPECT_NEAR(last / difference, 100.0, 5.0);
    }
    last = difference;
  }
  EXPECT_LT(last, 1e-3);
}

/// Displacement along z after `steps` steps of a stiff bar hung in its middle by a bushing at its
/// right end's nodes, thrown at 0.1 m/s. With Po in the centre of mass it keeps its direction.
double thrown(double k, double c, double h_s, int steps) {
  Params params = bar_with_two_ports();
  params.material.young_Pa = 2e11;
  params.ports.erase(params.ports.begin());
  params.ports[0].p_WP = Eigen::Vector3d::Zero();
  params.ports[0].attachment = bushing(k, 1e3);
  params.ports[0].attachment.bushing.damping.diagonal().head<3>().setConstant(c);
  params.initial_velocity.linear_m_per_s = {0, 0, 0.1};
  params.integrator = {.kind = IntegratorKind::Newmark};
  params.micro_step = sim_time_from_seconds(h_s);
  FlexibleBody body(params);
  const MotionSet still(1);
  body.initialize(still);
  for (int n = 0; n < steps; ++n) {
    EXPECT_EQ(body.advance(request(still, still, params.micro_step)).outcome, Outcome::Done);
  }
  return body.mean_motion("right").displacement_m.z();
}

// m = 1.25 kg on k = 1000 N/m, damping ratio 0 and 0.1, after 0.1 s (2.8 rad): the trapezoidal rule
// is late by (ω h)²/12 of the phase, 1.6e-5 at h = 5e-4 s, and the bar's own compliance (k L/(E A),
// 1e-6) adds nothing.
TEST(BushingPorts, StiffBarOnABushingVibratesAsAnOscillator) {
  const double m = 1000.0 * kArea_m2 * kLength_m;
  const double k = 1000.0;
  const double omega = std::sqrt(k / m);
  for (double ratio : {0.0, 0.1}) {
    const double damped = omega * std::sqrt(1.0 - ratio * ratio);
    const double exact = 0.1 / damped * std::exp(-ratio * omega * 0.1) * std::sin(damped * 0.1);
    const double found = thrown(k, 2.0 * ratio * std::sqrt(k * m), 5e-4, 200);
    EXPECT_NEAR(found, exact, 1e-4 * 0.1 / omega) << ratio;
  }
}

// Every step made once, and made three times with another input in between: the same bits.
TEST(LoosePorts, RepeatedStepsGiveTheBitsOfASingleOne) {
  for (const IntegratorParams& integrator : {IntegratorParams{}, kHht, kNewmark}) {
    for (SolverKind solver : {SolverKind::Cholmod, SolverKind::Pcg}) {
      Params params = bar(averaging(), full_bushing());
      params.integrator = integrator;
      params.solver.kind = solver;
      FlexibleBody once(params);
      FlexibleBody repeated(params);
      once.initialize(pair_motion(0.0));
      repeated.initialize(pair_motion(0.0));
      for (int k = 0; k < 3; ++k) {
        const SimTime H(2'000'000);
        const auto right = request(pair_motion(2e-3 * k), pair_motion(2e-3 * (k + 1)), H);
        const auto wrong = request(pair_motion(2e-3 * k), pair_motion(2e-3 * k + 3e-3), H, true);
        once.checkpoint();
        repeated.checkpoint();
        const auto expected = once.advance(right);
        ASSERT_EQ(repeated.advance(wrong).outcome, Outcome::Done);
        repeated.rollback();
        EXPECT_EQ(stack(repeated.advance(right).output), stack(expected.output));
        EXPECT_EQ(repeated.observe().state_hash, once.observe().state_hash);
      }
    }
  }
}

// With steel in place of rubber the two solvers agree to PCG's tolerance.
TEST(LoosePorts, BothSolversGiveOneAnswer) {
  Eigen::VectorXd wrenches[2];
  for (SolverKind solver : {SolverKind::Cholmod, SolverKind::Pcg}) {
    Params params = bar(averaging(), full_bushing());
    params.solver.kind = solver;
    FlexibleBody body(params);
    body.initialize(pair_motion(0.0));
    for (int k = 0; k < 5; ++k) {
      wrenches[solver == SolverKind::Pcg ? 1 : 0] =
          stack(body.advance(request(pair_motion(1e-3 * k), pair_motion(1e-3 * (k + 1)),
                                     SimTime(1'000'000)))
                    .output);
    }
  }
  EXPECT_LT((wrenches[0] - wrenches[1]).norm(), 1e-8 * wrenches[0].norm());
}

// h Σ f = −ΔP with backward Euler, as of rigid ports.
TEST(LoosePorts, LinearMomentumClosesWithBackwardEuler) {
  FlexibleBody body(bar(averaging(), full_bushing()));
  body.initialize(pair_motion(0.0));
  Eigen::Vector3d before = linear_momentum(body);
  for (int k = 0; k < 5; ++k) {
    const auto result = body.advance(
        request(pair_motion(1e-3 * k), pair_motion(1e-3 * (k + 1)), SimTime(1'000'000)));
    const Eigen::Vector3d after = linear_momentum(body);
    const Eigen::Vector3d impulse =
        1e-3 * (result.output[0].f_P_W + result.output[1].f_P_W) + after - before;
    EXPECT_LT(impulse.norm(), 1e-12 * (1.0 + after.norm()));
    before = after;
  }
}

// A port that is suddenly thrown at 1 m/s: with Newmark's recursion the jump of its velocity would
// stay in the accelerations as 2/h with alternating sign, and m · 2/h = 12500 N in the wrench, for
// ever. What stays is the bar's own vibration: forces below E A v/c = 180 N that change by some
// (220 rad/s · h)² of themselves, 0.002, from step to step.
TEST(AveragingPorts, NewmarkForgetsAJumpOfThePortsVelocity) {
  Params params = bar_with_two_ports();
  params.ports.erase(params.ports.begin());
  params.ports[0].attachment = averaging();
  params.damping.beta_s = 2e-3;
  params.integrator = kNewmark;
  params.micro_step = SimTime(200'000);
  FlexibleBody body(params);
  MotionSet motion(1);
  body.initialize(motion);
  std::vector<Eigen::VectorXd> wrenches;
  for (int k = 0; k < 200; ++k) {
    MotionSet end = motion;
    end[0].v_WP = {1.0, 0.0, 0.0};
    end[0].p_WP.x() += 2e-4;
    wrenches.push_back(stack(body.advance(request(motion, end, params.micro_step)).output));
    motion = end;
  }
  EXPECT_LT((wrenches[199] - 2.0 * wrenches[198] + wrenches[197]).norm(), 1.0);
}

// 3 rad of relative rotation: the rotation vector is near its end.
TEST(BushingPorts, TooFarATurnFailsWithThePortAndARemedy) {
  Params params = bar(bushing(1e3, 1e-3), {});
  params.integrator.newton_steps = 0;
  FlexibleBody body(params);
  body.initialize(ends());
  StepResult<WrenchSet> result;
  MotionSet begin = ends();
  for (int k = 1; k <= 60 && (k == 1 || result.outcome == Outcome::Done); ++k) {
    MotionSet end = ends();
    end[0].q_WP = rotation({0.05 * k, 0, 0});
    result = body.advance(request(begin, end, SimTime(1'000'000)));
    begin = end;
  }
  EXPECT_EQ(result.outcome, Outcome::Failed);
  EXPECT_NE(result.message.find("bushing of port 'left' is turned by 2.5"), std::string::npos)
      << result.message;
}

}  // namespace
}  // namespace tandem::fem

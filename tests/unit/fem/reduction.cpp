#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "fem_process/reduced/modal_analysis.h"
#include "fem_process/reduced/reduced_body.h"
#include "fem_process/sides/flexible_body.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

Params reduced_bar(int modes = 10) {
  Params params = bar_with_two_ports();
  params.formulation = FormulationKind::CraigBampton;
  params.craig_bampton.modes = modes;
  return params;
}

std::vector<RigidPart> parts_of(const Model& model) {
  return {{model.ports[0].nodes, {-0.28, 0, 0}}, {model.ports[1].nodes, {0.28, 0, 0}}};
}

Eigen::MatrixXd stiffness_times(const Model& model, const Eigen::MatrixXd& shapes) {
  Eigen::VectorXd f_int;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f_int, K);
  Eigen::MatrixXd product(shapes.rows(), shapes.cols());
  for (Eigen::Index c = 0; c < shapes.cols(); ++c) {
    product.col(c) = multiply(model.pattern(), K, shapes.col(c));
  }
  return product;
}

// Lanczos iterates to 1e-12 of the eigenvalue, the static solutions are exact to CHOLMOD's 1e-15 of
// the stiffness times its condition number of about 1e4.
TEST(FemComponentModes, AreOrthonormalAndFreeOfEachOther) {
  const Model model(reduced_bar(12));
  const BoundaryModes modes = fixed_boundary_modes(model, model.params.craig_bampton);
  const Eigen::MatrixXd& phi = modes.shapes;
  ASSERT_EQ(phi.cols(), 12);
  const Eigen::MatrixXd psi = constraint_modes(model, parts_of(model));
  Eigen::MatrixXd M_phi(phi.rows(), phi.cols());
  for (Eigen::Index c = 0; c < phi.cols(); ++c) {
    M_phi.col(c) = multiply_scalar(model.pattern(), model.mass, phi.col(c));
  }
  const Eigen::MatrixXd K_phi = stiffness_times(model, phi);
  EXPECT_LT((phi.transpose() * M_phi - Eigen::MatrixXd::Identity(12, 12)).norm(), 1e-10);
  const Eigen::VectorXd omega2 = modes.angular_frequencies.cwiseAbs2();
  EXPECT_LT((phi.transpose() * K_phi - Eigen::MatrixXd(omega2.asDiagonal())).norm(),
            1e-9 * omega2.maxCoeff());
  // The port nodes' displacements of 1 m take forces of the order of E A/L.
  EXPECT_LT((psi.transpose() * K_phi).norm(), 1e-8 * K_phi.norm() * psi.norm());
}

// A frequency limit keeps exactly the modes below it, also when it lies between the batches in
// which they are sought, and dense and Lanczos solvers agree.
TEST(FemComponentModes, FrequencyLimitKeepsTheModesBelowIt) {
  Params params = reduced_bar(40);
  const Model model(params);
  const Eigen::VectorXd all =
      fixed_boundary_modes(model, params.craig_bampton).angular_frequencies / (2 * M_PI);
  for (Eigen::Index keep : {Eigen::Index{0}, Eigen::Index{5}, Eigen::Index{21}}) {
    const double below = keep == 0 ? 0.0 : all(keep - 1);
    params.craig_bampton.frequency_limit_Hz = 0.5 * (below + all(keep));
    const BoundaryModes modes = fixed_boundary_modes(model, params.craig_bampton);
    ASSERT_EQ(modes.angular_frequencies.size(), keep);
    EXPECT_LT((modes.angular_frequencies / (2 * M_PI) - all.head(keep)).norm(), 1e-8 * all(keep));
  }
  const Eigen::Index n = 3 * static_cast<Eigen::Index>(model.free.size());
  params.craig_bampton.frequency_limit_Hz = 1e9;
  const BoundaryModes every = fixed_boundary_modes(model, params.craig_bampton);
  EXPECT_EQ(every.shapes.cols(), n);
  EXPECT_LT((every.angular_frequencies.head(40) / (2 * M_PI) - all).norm(), 1e-8 * all(39));
}

// The free bar's vibration between movable ports: the reduced eigenproblem K̂ z = ω² M̂ z against
// the full one with the port nodes tied to rigid bodies of no mass. Rayleigh-Ritz: from above, and
// the error falls as modes are added.
TEST(FemComponentModes, ReducedFrequenciesConvergeFromAbove) {
  const auto frequencies = [](int count) {
    const Model model(reduced_bar(count));
    const BoundaryModes modes = fixed_boundary_modes(model, model.params.craig_bampton);
    const ReducedModel reduced(model, modes, pair_motion(0.0));
    const Eigen::Index n = reduced.boundary() + count;
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
    K.topLeftCorner(12, 12) = reduced.K_boundary();
    K.diagonal().tail(count) = reduced.omega2();
    Eigen::MatrixXd M(n, n);
    for (Eigen::Index a = 0; a < n; ++a) {
      for (Eigen::Index b = 0; b < n; ++b) {
        M(a, b) = reduced.T().block<3, 3>(4 + 3 * a, 4 + 3 * b).trace();
      }
    }
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(K, M);
    return Eigen::VectorXd(solver.eigenvalues().segment(6, 6));
  };
  const Eigen::Index all = 3 * static_cast<Eigen::Index>(Model(reduced_bar()).free.size());
  const Eigen::VectorXd exact = frequencies(static_cast<int>(all));
  double last = 10.0;
  for (int count : {0, 6, 12, 24, 48}) {
    const Eigen::VectorXd error = (frequencies(count) - exact).cwiseQuotient(exact);
    EXPECT_GT(error.minCoeff(), -1e-9) << count;
    EXPECT_LT(error.maxCoeff(), 0.5 * last) << count;
    last = error.maxCoeff();
  }
  EXPECT_LT(last, 1e-3);
}

struct Equality {
  IntegratorParams integrator;
  Damping damping;
};

class FemReducedEquality : public ::testing::TestWithParam<Equality> {};

INSTANTIATE_TEST_SUITE_P(
    Integrators, FemReducedEquality,
    ::testing::Values(Equality{{}, {}}, Equality{{}, {.alpha_per_s = 2.0, .beta_s = 1e-3}},
                      Equality{{.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.6}, {}},
                      Equality{{.kind = IntegratorKind::QuasiStatic}, {}},
                      Equality{{.kind = IntegratorKind::Hht, .hht_alpha = -0.1},
                               {.alpha_per_s = 2.0, .beta_s = 1e-3}}));

// With all modes and a frame at rest the reduced body is a change of coordinates of the linear one:
// the same motion and the same wrenches. One port is shaken without turning (a turning port's nodes
// move on arcs in the linear body and on tangents in the reduced one), the other end is fixed;
// gravity, a load and an initial velocity act. Round-off of K, 1e-16 · 1e6 N/m · 0.3 m, over 25
// steps stays below 1e-9 of wrenches and displacements.
TEST_P(FemReducedEquality, AllModesGiveTheLinearBody) {
  Params params = bar_with_two_ports();
  params.mesh.file = temporary_file("equality.inp", box_inp(6));
  params.mesh.length_scale_m = 0.1;
  params.ports = {{"left", {"LEFT"}, Eigen::Vector3d(-0.28, 0, 0)}};
  params.fixed = {{"RIGHT"}};
  params.integrator = GetParam().integrator;
  params.damping = GetParam().damping;
  params.gravity_m_per_s2 = {1, 2, -9.81};
  params.initial_velocity.angular_rad_per_s = {0.1, 0.3, -0.2};
  params.loads = {{.kind = Load::Kind::Nodal, .set = {"ALL"}, .value = {3.0, 1.0, -2.0}}};
  Params reduced_params = params;
  params.formulation = FormulationKind::Linear;
  FlexibleBody linear(params);
  reduced_params.formulation = FormulationKind::CraigBampton;
  reduced_params.craig_bampton.frame.name = "world";
  reduced_params.craig_bampton.modes = 3 * static_cast<int>(linear.model().free.size());
  ReducedBody reduced(reduced_params);
  // Positions are sums of h v, as a semi-implicit multibody side makes them.
  const double h = 1e-3;
  MotionSet before{{.p_WP = {-0.28, 0, 0}, .v_WP = {0.0, 0.4, 0.2}}};
  const Eigen::VectorXd f_0 = stack(linear.initialize(before));
  EXPECT_LT((stack(reduced.initialize(before)) - f_0).norm(), 1e-9 * f_0.norm());
  const Eigen::VectorXd X = linear.model().reference();
  for (int k = 1; k <= 25; ++k) {
    MotionSet after = before;
    // Newmark's recursion holds for the interior nodes in one body, for the modes in the other: the
    // same as long as the port is not accelerated.
    const IntegratorKind kind = params.integrator.kind;
    if (kind == IntegratorKind::BackwardEuler || kind == IntegratorKind::QuasiStatic) {
      after[0].v_WP = {0.3 * std::sin(100 * k * h), 0.4 * std::cos(80 * k * h), 0.2};
    }
    after[0].p_WP += h * after[0].v_WP;
    const auto step = request(before, after, params.micro_step);
    const Eigen::VectorXd f = stack(linear.advance(step).output);
    const auto result = reduced.advance(step);
    ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
    EXPECT_LT((stack(result.output) - f).norm(), 1e-9 * f.norm()) << "step " << k;
    const State nodal = reduced.nodal_state();
    EXPECT_LT((nodal.x - linear.state().x).norm(), 1e-9 * (linear.state().x - X).norm());
    EXPECT_LT((nodal.v - linear.state().v).norm(), 1e-9 * linear.state().v.norm());
    const EnergyBook a = linear.observe().energy;
    const EnergyBook b = reduced.observe().energy;
    EXPECT_NEAR(b.total_J(), a.total_J(), 1e-9 * (a.kinetic_J + a.elastic_J + 1.0));
    EXPECT_NEAR(b.external_work_J, a.external_work_J, 1e-9);
    before = after;
  }
}

struct Momentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< about the origin of W
};

Momentum momentum(const ReducedBody& body) {
  const State nodal = body.nodal_state();
  const Eigen::VectorXd p = multiply_scalar(body.model().pattern(), body.model().mass, nodal.v);
  Momentum sum;
  for (Eigen::Index i = 0; i < p.size(); i += 3) {
    sum.linear += p.segment<3>(i);
    sum.angular += nodal.x.segment<3>(i).cross(p.segment<3>(i));
  }
  return sum;
}

// Impulses and moments of impulse of the ports, levers at the beginning of the step as the rigid
// side takes them, against the change of the momenta of all nodes. Sums of 150 nodes' momenta of up
// to 1 kg m/s: round-off 1e-14.
TEST(FemReducedMomentum, ClosesToRoundOffWithBackwardEuler) {
  for (const char* frame : {"mean", "left"}) {
    Params params = reduced_bar();
    params.craig_bampton.frame.name = frame;
    params.gravity_m_per_s2 = {0.5, -1.0, -9.81};
    params.damping.beta_s = 1e-3;
    ReducedBody body(params);
    body.initialize(pair_motion(0.0));
    double mass = 0.0;
    for (double m : body.model().nodal_mass) mass += m;
    const double h = 1e-3;
    for (int k = 1; k <= 50; ++k) {
      const Momentum before = momentum(body);
      const State nodal = body.nodal_state();
      Eigen::Vector3d weight_moment = Eigen::Vector3d::Zero();
      for (int i = 0; i < body.model().mesh.nodes(); ++i) {
        weight_moment += body.model().nodal_mass[static_cast<std::size_t>(i)] *
                         nodal.x.segment<3>(3 * i).cross(params.gravity_m_per_s2);
      }
      const MotionSet begin = pair_motion((k - 1) * h);
      const auto result = body.advance(request(begin, pair_motion(k * h), params.micro_step));
      ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
      const Momentum after = momentum(body);
      Eigen::Vector3d impulse = -h * mass * params.gravity_m_per_s2;
      Eigen::Vector3d turning = -h * weight_moment;
      for (std::size_t p = 0; p < 2; ++p) {
        const Wrench& wrench = result.output[p];
        impulse += h * wrench.f_P_W;
        turning += h * (wrench.t_P_W + begin[p].p_WP.cross(wrench.f_P_W));
      }
      EXPECT_LT((impulse + after.linear - before.linear).norm(), 1e-12) << frame << k;
      EXPECT_LT((turning + after.angular - before.angular).norm(), 1e-12) << frame << k;
    }
  }
}

// A bar so stiff that it is rigid, tumbling about its port without gravity: what the port feels is
// Newton's and Euler's law for the rigid bar. Largest error over the motion at two steps: HHT is of
// second order. (The elastic deformation is 1e-9 of the length.)
TEST(FemReducedBody, RigidTumblingFollowsNewtonAndEuler) {
  const auto error = [](std::int64_t h_ns) {
    Params params = reduced_bar(4);
    params.material.young_Pa = 1e13;
    params.ports.resize(1);
    params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = -0.3};
    params.micro_step = SimTime(h_ns);
    ReducedBody body(params);
    const auto motion = [](double t) {
      // Rotation about a fixed axis at a varying rate, the port on a circle.
      const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 2) / 3.0;
      Motion m;
      m.q_WP = rotation((3.0 * t + 5.0 * t * t) * axis);
      m.w_WP = (3.0 + 10.0 * t) * axis;
      m.p_WP = {-0.28 + 0.1 * std::sin(4 * t), 0.1 * std::cos(4 * t) - 0.1, 0};
      m.v_WP = {0.4 * std::cos(4 * t), -0.4 * std::sin(4 * t), 0};
      return MotionSet{m};
    };
    body.initialize(motion(0.0));
    const Model& model = body.model();
    const double h = 1e-9 * static_cast<double>(h_ns);
    double worst = 0.0;
    for (int k = 1; k * h <= 0.2; ++k) {
      const auto result =
          body.advance(request(motion((k - 1) * h), motion(k * h), params.micro_step));
      if (k * h < 0.05) continue;  // the start at a constant twist dies out
      const double t = k * h;
      const Motion m = motion(t)[0];
      const Eigen::Vector3d alpha = 10.0 * Eigen::Vector3d(1, 2, 2) / 3.0;
      const Eigen::Vector3d a_P(-1.6 * std::sin(4 * t), -1.6 * std::cos(4 * t), 0);
      Eigen::VectorXd arms(3 * model.mesh.nodes());
      Eigen::VectorXd a(3 * model.mesh.nodes());
      for (int i = 0; i < model.mesh.nodes(); ++i) {
        const Eigen::Vector3d r =
            m.q_WP * (model.mesh.X[static_cast<std::size_t>(i)] - Eigen::Vector3d(-0.28, 0, 0));
        arms.segment<3>(3 * i) = r;
        a.segment<3>(3 * i) = a_P + alpha.cross(r) + m.w_WP.cross(m.w_WP.cross(r));
      }
      const Eigen::VectorXd f = multiply_scalar(model.pattern(), model.mass, a);
      Eigen::VectorXd expected = Eigen::VectorXd::Zero(6);
      for (Eigen::Index i = 0; i < f.size(); i += 3) {
        expected.head<3>() -= f.segment<3>(i);
        expected.tail<3>() -= arms.segment<3>(i).cross(f.segment<3>(i));
      }
      worst = std::max(worst, (stack(result.output) - expected).norm() / expected.norm());
    }
    return worst;
  };
  const double coarse = error(1'000'000);
  const double fine = error(500'000);
  EXPECT_LT(fine, 1e-3);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.15);
}

TEST(FemReducedBody, RefusesPortsTurnedFarAgainstEachOther) {
  Params params = reduced_bar();
  params.craig_bampton.frame.name = "left";
  ReducedBody body(params);
  body.initialize(pair_motion(0.0));
  MotionSet end = pair_motion(1e-3);
  end[1].q_WP = rotation({2.2, 0, 0});  // 126°
  const auto result = body.advance(request(pair_motion(0.0), end, SimTime(1'000'000)));
  EXPECT_EQ(result.outcome, Outcome::Failed);
  EXPECT_NE(result.message.find("turned by"), std::string::npos) << result.message;
}

TEST(FemReducedBody, RefusesAFrameThatNoPortCarries) {
  Params params = reduced_bar();
  params.craig_bampton.frame.name = "middle";
  EXPECT_THROW(ReducedBody{params}, Error);
}

TEST(FemReducedBody, RefusesAPortThatDoesNotHoldTheBody) {
  Params params = reduced_bar();
  params.mesh.file = temporary_file("loose.inp", box_inp(3) + "*NSET, NSET=CORNER\n1\n");
  params.ports = {{"corner", {"CORNER"}, Eigen::Vector3d::Zero()}};
  ReducedBody body(params);
  EXPECT_THROW(body.initialize({Motion{}}), Error);
}

// A shape that is a small rigid turning by θ turns every element by θ; a uniform stretch by none.
TEST(FemElasticTurn, IsHalfTheCurlOfTheDisplacement) {
  const Model model(reduced_bar(1));
  const Eigen::Vector3d theta(0.03, -0.02, 0.05);
  Eigen::MatrixXd shapes(model.mesh.nodes(), 6);
  Eigen::VectorXd x(3 * model.mesh.nodes());
  for (int i = 0; i < model.mesh.nodes(); ++i) {
    const Eigen::Vector3d& X = model.mesh.X[static_cast<std::size_t>(i)];
    shapes.block<1, 3>(i, 0) = theta.cross(X).transpose();
    shapes.block<1, 3>(i, 3) = 0.1 * X.transpose();
    x.segment<3>(3 * i) = X + theta.cross(X) + 0.1 * X;
  }
  const ElasticTurn turn(model.mesh, shapes);
  EXPECT_NEAR(turn.largest_rad(Eigen::Vector2d(1.0, 0.0)), theta.norm(), 1e-14);
  EXPECT_NEAR(turn.largest_rad(Eigen::Vector2d(0.0, 1.0)), 0.0, 1e-14);
  EXPECT_NEAR(turn.largest_rad(Eigen::Vector2d(-2.0, 1.0)), 2.0 * theta.norm(), 1e-14);
  EXPECT_NEAR(largest_turn_rad(model.mesh, x), theta.norm(), 1e-13);
}

}  // namespace
}  // namespace tandem::fem

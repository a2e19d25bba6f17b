#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

// A row of three unit cubes, soft (wave speed about 1 m/s), driven at one end through a rotating
// and accelerating port, with gravity, a harmonic traction, and damping. All modes are resolved by
// the steps below, so the orders of the integrators show without stiff-mode effects.

constexpr double kEnd_s = 1.6;

Params driven_box(FormulationKind formulation = FormulationKind::Corotational) {
  static const std::filesystem::path file = temporary_file("order.inp", box_inp(3));
  Params params;
  params.mesh.file = file;
  params.formulation = formulation;
  params.material = {.young_Pa = 300.0, .poisson = 0.3, .density_kg_per_m3 = 100.0};
  params.mass = MassKind::Lumped;
  params.damping = {.alpha_per_s = 0.2, .beta_s = 0.05};
  params.gravity_m_per_s2 = {0.0, 0.0, -0.5};
  params.loads = {{.kind = Load::Kind::Surface,
                   .set = {"END"},
                   .value = {5.0, 10.0, 0.0},
                   .law = Law(HarmonicLaw{.amplitude = 1.0, .frequency_Hz = 0.3})}};
  params.ports = {{"port", {"LEFT"}, Eigen::Vector3d(-0.5, 0.5, 0.5)}};
  params.initial_velocity = {.linear_m_per_s = {0.1, 0.0, 0.2},
                             .angular_rad_per_s = {0.0, 0.3, 0.6},
                             .about_m = {-0.5, 0.5, 0.5}};
  return params;
}

MotionSet port_motion(double t) {
  const Eigen::Vector3d w(0.0, 0.3, 0.6);
  Motion m;
  m.p_WP = Eigen::Vector3d(-0.5 + 0.1 * t, 0.5 + 0.2 * t * t * t, 0.5 + 0.2 * t);
  m.v_WP = {0.1, 0.6 * t * t, 0.2};
  m.q_WP = rotation(w * t);
  m.w_WP = w;
  return {m};
}

struct End {
  Eigen::VectorXd x, wrench;
};

End integrate(Params params, int steps) {
  const SimTime H = sim_time_from_seconds(kEnd_s / steps);
  params.micro_step = H;
  FlexibleBody body(std::move(params));
  body.initialize(port_motion(0.0));
  WrenchSet wrenches;
  for (int k = 0; k < steps; ++k) {
    const double t = kEnd_s * k / steps;
    const auto result = body.advance(request(port_motion(t), port_motion(t + to_seconds(H)), H));
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    wrenches = result.output;
  }
  return {body.state().x, stack(wrenches)};
}

/// Acceleration of every node at time t: prescribed at the port, from the lumped balance elsewhere.
/// Also the reactions M a + C v + f_int − f_ext.
Eigen::VectorXd acceleration(const Model& model, double t, const Eigen::VectorXd& x,
                             const Eigen::VectorXd& v, Eigen::VectorXd& react) {
  Eigen::VectorXd f;
  BlockValues K;
  model.formulation->evaluate(x, f, K);
  // Stiffness damping acts on the velocities beyond the rigid motion with the port.
  const Motion m = port_motion(t)[0];
  Eigen::VectorXd beyond = v;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    beyond.segment<3>(i) -= m.v_WP + m.w_WP.cross(Eigen::Vector3d(x.segment<3>(i) - m.p_WP));
  }
  f += model.params.damping.alpha_per_s * multiply_scalar(model.pattern(), model.mass, v);
  f += model.params.damping.beta_s * multiply(model.pattern(), K, beyond);
  f -= model.external_forces(t);
  Eigen::VectorXd a(x.size());
  for (int i = 0; i < model.mesh.nodes(); ++i) {
    a.segment<3>(3 * i) = -f.segment<3>(3 * i) / model.nodal_mass[static_cast<std::size_t>(i)];
  }
  for (int node : model.ports[0].nodes) {
    const Eigen::Vector3d r = x.segment<3>(3 * node) - m.p_WP;
    a.segment<3>(3 * node) = Eigen::Vector3d(0, 1.2 * t, 0) + m.w_WP.cross(m.w_WP.cross(r));
  }
  react = multiply_scalar(model.pattern(), model.mass, a) + f;
  return a;
}

/// The semi-discrete equations by the classical Runge-Kutta method of fourth order with 4000 steps
/// (ω h < 0.01: relative error below (ω h)⁴): the truth for the orders, independent of the body's
/// stepping code.
End exact(FormulationKind formulation = FormulationKind::Corotational) {
  const Params params = [formulation] {
    Params p = driven_box(formulation);
    p.micro_step = SimTime(1'000'000);
    return p;
  }();
  const Model model(params);
  Eigen::VectorXd x = model.reference();
  Eigen::VectorXd v = model.initial_velocities();
  const int steps = 4000;
  const double h = kEnd_s / steps;
  Eigen::VectorXd react;
  const auto a = [&](double t, const Eigen::VectorXd& at, const Eigen::VectorXd& rate) {
    return acceleration(model, t, at, rate, react);
  };
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const Eigen::VectorXd a1 = a(t, x, v);
    const Eigen::VectorXd v2 = v + h / 2 * a1;
    const Eigen::VectorXd a2 = a(t + h / 2, x + h / 2 * v, v2);
    const Eigen::VectorXd v3 = v + h / 2 * a2;
    const Eigen::VectorXd a3 = a(t + h / 2, x + h / 2 * v2, v3);
    const Eigen::VectorXd v4 = v + h * a3;
    const Eigen::VectorXd a4 = a(t + h, x + h * v3, v4);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  a(kEnd_s, x, v);
  End end{x, Eigen::VectorXd::Zero(6)};
  for (int node : model.ports[0].nodes) {
    const Eigen::Vector3d r = x.segment<3>(3 * node) - port_motion(kEnd_s)[0].p_WP;
    const Eigen::Vector3d g = react.segment<3>(3 * node);
    end.wrench.head<3>() -= g;
    end.wrench.tail<3>() -= r.cross(g);
  }
  return end;
}

/// Checks the order of positions and wrenches over four halvings of the step, two-sided.
void expect_order(const Params& params, double order, int coarsest) {
  const End truth = exact(params.formulation);
  End errors[5];
  for (int level = 0; level < 5; ++level) {
    const End end = integrate(params, coarsest << level);
    errors[level] = {end.x - truth.x, end.wrench - truth.wrench};
  }
  for (int level = 1; level < 5; ++level) {
    const double x = std::log2(errors[level - 1].x.norm() / errors[level].x.norm());
    const double w = std::log2(errors[level - 1].wrench.norm() / errors[level].wrench.norm());
    EXPECT_NEAR(x, order, 0.15) << "positions, halving " << level;
    EXPECT_NEAR(w, order, 0.15) << "wrench, halving " << level;
  }
}

TEST(FemOrder, BackwardEulerIsOfFirstOrder) { expect_order(driven_box(), 1.0, 500); }

TEST(FemOrder, HhtIsOfSecondOrder) {
  for (double alpha : {0.0, -0.05, -0.3}) {
    SCOPED_TRACE(alpha);
    Params params = driven_box();
    params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = alpha};
    expect_order(params, 2.0, 64);
  }
}

TEST(FemOrder, GeneralisedAlphaIsOfSecondOrder) {
  for (double rho : {1.0, 0.9, 0.5, 0.0}) {
    SCOPED_TRACE(rho);
    Params params = driven_box();
    params.integrator = {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = rho};
    expect_order(params, 2.0, 64);
  }
}

// Average and linear acceleration; γ above ½ costs the second order.
TEST(FemOrder, NewmarkIsOfSecondOrderForGammaOneHalfAndOfFirstAbove) {
  Params params = driven_box();
  params.integrator = {.kind = IntegratorKind::Newmark};
  expect_order(params, 2.0, 64);
  params.integrator.newmark_beta = 1.0 / 6.0;
  expect_order(params, 2.0, 64);
  params.integrator = {.kind = IntegratorKind::Newmark, .newmark_beta = 0.36, .newmark_gamma = 0.7};
  expect_order(params, 1.0, 500);
}

// The linearisation point and what the tangent leaves out cost no order in any formulation: the
// truth solves each one's own equations.
TEST(FemOrder, IsTheIntegratorsForEveryFormulation) {
  for (const FormulationKind formulation :
       {FormulationKind::Linear, FormulationKind::ConsistentCorotational,
        FormulationKind::TotalLagrangian}) {
    SCOPED_TRACE(static_cast<int>(formulation));
    Params params = driven_box(formulation);
    expect_order(params, 1.0, 500);
    params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = -0.05};
    expect_order(params, 2.0, 64);
    params.integrator = {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.9};
    expect_order(params, 2.0, 64);
    params.integrator = {.kind = IntegratorKind::Newmark};
    expect_order(params, 2.0, 64);
  }
}

// Several micro steps in one macro step see the port motion by interpolation, whose own error is of
// fourth order: the order in the micro step stays.
TEST(FemOrder, MicroStepsKeepTheOrder) {
  const End truth = exact();
  double last = 0.0;
  for (int level = 0; level < 3; ++level) {
    Params params = driven_box();
    params.integrator = {.kind = IntegratorKind::Hht, .hht_alpha = -0.05};
    const int macro_steps = 64 << level;
    const SimTime H = sim_time_from_seconds(kEnd_s / macro_steps);
    params.micro_step = H / 4;
    FlexibleBody body(params);
    body.initialize(port_motion(0.0));
    for (int k = 0; k < macro_steps; ++k) {
      const double t = k * to_seconds(H);
      body.advance(request(port_motion(t), port_motion(t + to_seconds(H)), H));
    }
    const double error = (body.state().x - truth.x).norm();
    if (level > 0) {
      EXPECT_NEAR(std::log2(last / error), 2.0, 0.15);
    }
    last = error;
  }
}

}  // namespace
}  // namespace tandem::fem

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "fem_process/reduced/modal_analysis.h"
#include "fem_process/reduced/reduced_body.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_ports.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

constexpr double kRoundOff = 1e-12;  ///< of sums over 400 unknowns in 100 steps: 20·100 ε

struct Named {
  std::string name;
  IntegratorParams integrator;
};

class FemEnergy : public ::testing::TestWithParam<Named> {};
INSTANTIATE_TEST_SUITE_P(
    Integrators, FemEnergy,
    ::testing::Values(
        Named{"backward_euler", {}}, Named{"hht", {.kind = IntegratorKind::Hht, .hht_alpha = -0.1}},
        Named{"trapezoidal", {.kind = IntegratorKind::Hht, .hht_alpha = 0.0}},
        Named{"generalised_alpha", {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.5}},
        Named{"newmark",
              {.kind = IntegratorKind::Newmark, .newmark_beta = 0.36, .newmark_gamma = 0.7}},
        Named{"quasi_static", {.kind = IntegratorKind::QuasiStatic}}),
    [](const auto& tested) { return tested.param.name; });

/// The bar between two moving ports under gravity and a load that changes with time, damped.
Params loaded_bar(const IntegratorParams& integrator, FormulationKind formulation) {
  Params params = bar_with_two_ports();
  params.integrator = integrator;
  params.formulation = formulation;
  params.damping = {.alpha_per_s = 2.0, .beta_s = 1e-4};
  params.gravity_m_per_s2 = {0.0, 1.0, -9.81};
  params.loads = {{.kind = Load::Kind::Nodal,
                   .set = {"right"},
                   .value = {0.1, -0.2, 0.3},
                   .law = Law(HarmonicLaw{1.0, 1.0, 5.0, 0.0})}};
  return params;
}

struct Books {
  EnergyBook begin, end;
  double largest_imbalance_J = 0.0;
  double scale_J = 0.0;  ///< of the energies and works
};

double scale_of(const EnergyBook& book) {
  return book.kinetic_J + std::abs(book.potential_J) + book.elastic_J +
         std::abs(book.external_work_J) + std::abs(book.interface_work_J) +
         std::abs(book.damping_loss_J) + std::abs(book.numerical_loss_J);
}

template <class Body>
Books books_of(Body& body, SimTime h, double duration_s,
               const std::function<MotionSet(double)>& motion) {
  body.initialize(motion(0.0));
  Books books;
  books.begin = body.observe().energy;
  const int n = static_cast<int>(std::lround(duration_s / to_seconds(h)));
  for (int k = 0; k < n; ++k) {
    const double t = to_seconds(h) * k;
    const auto result = body.advance(request(motion(t), motion(t + to_seconds(h)), h));
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    books.end = body.observe().energy;
    books.largest_imbalance_J =
        std::max(books.largest_imbalance_J, std::abs(balance_error_J(books.begin, books.end)));
    books.scale_J = std::max(books.scale_J, scale_of(books.end));
  }
  return books;
}

// The balance of a linear body is an identity whatever the integrator takes: with moving and
// turning ports (it does not ask whether strains are objective), loads, gravity and damping.
TEST_P(FemEnergy, BooksOfALinearBodyBalanceToRoundOff) {
  const Params params = loaded_bar(GetParam().integrator, FormulationKind::Linear);
  FlexibleBody body(params);
  const Books books = books_of(body, params.micro_step, 0.1, pair_motion);
  EXPECT_LT(books.largest_imbalance_J, kRoundOff * books.scale_J);
  EXPECT_GT(std::abs(books.end.interface_work_J), 1e-3 * books.scale_J);
  EXPECT_GT(std::abs(books.end.external_work_J), 1e-6 * books.scale_J);
  if (GetParam().integrator.kind != IntegratorKind::QuasiStatic) {
    EXPECT_GT(books.end.damping_loss_J, 1e-6 * books.scale_J);
  }
}

// Forces of averaging ports and bushings act on free nodes; a bushing stores and damps energy of
// its own. The second-order integrators move the nodes of averaging ports on from where their
// balance has them: booked, too. The ports' relations are solved to 1e-10 of their forces.
TEST_P(FemEnergy, BooksOfLoosePortsBalance) {
  const IntegratorParams& integrator = GetParam().integrator;
  if (integrator.kind == IntegratorKind::QuasiStatic) return;  // needs rigidly held nodes
  Params params = loaded_bar(integrator, FormulationKind::Linear);
  params.ports[0].attachment = averaging();
  params.ports[1].attachment = full_bushing();
  FlexibleBody body(params);
  const Books books = books_of(body, params.micro_step, 0.05, pair_motion);
  EXPECT_LT(books.largest_imbalance_J, 1e-9 * books.scale_J);
  EXPECT_GT(std::abs(books.end.interface_work_J), 1e-3 * books.scale_J);
}

// A co-rotational body's strain energy is not quadratic: what one linearisation a step leaves out
// is of second order over a run.
TEST_P(FemEnergy, BalanceErrorOfACorotationalBodyIsOfSecondOrder) {
  const auto imbalance = [&](SimTime h) {
    Params params = loaded_bar(GetParam().integrator, FormulationKind::Corotational);
    params.micro_step = h;
    FlexibleBody body(params);
    const Books books = books_of(body, h, 0.05, pair_motion);
    EXPECT_LT(books.largest_imbalance_J, 1e-5 * books.scale_J);
    return books.largest_imbalance_J;
  };
  // Backward Euler damps the bar's vibrations, and comes to its order only where it resolves them.
  const double ratio = imbalance(SimTime(62'500)) / imbalance(SimTime(31'250));
  EXPECT_GT(ratio, 3.0);
}

// Reduced bodies balance power at their coordinates: an identity for all motions, large ones too.
TEST_P(FemEnergy, BooksOfAReducedBodyBalanceToRoundOff) {
  Params params = loaded_bar(GetParam().integrator, FormulationKind::Linear);
  params.craig_bampton.modes = 8;
  ReducedBody body(params);
  const Books books = books_of(body, params.micro_step, 0.1, pair_motion);
  EXPECT_LT(books.largest_imbalance_J, kRoundOff * books.scale_J);
  EXPECT_GT(std::abs(books.end.interface_work_J), 1e-3 * books.scale_J);
}

Params clamped_box(const IntegratorParams& integrator, SimTime h) {
  Params params;
  params.mesh.file = temporary_file("energy_books.inp", box_inp(2));
  params.material = {.young_Pa = 300.0, .poisson = 0.3, .density_kg_per_m3 = 100.0};
  params.formulation = FormulationKind::Linear;
  params.integrator = integrator;
  params.fixed = {{"LEFT"}};
  params.initial_velocity.linear_m_per_s = {0.3, 0.2, -0.1};
  params.micro_step = h;
  return params;
}

// Backward Euler on a linear body: ½ Δv·M Δv + ½ Δu·K Δu is lost in a step, [Hughes 1987] with
// Δu = h v⁺. K from the formulation, M from the model.
TEST(FemEnergyLoss, OfBackwardEulerIsTheClosedForm) {
  FlexibleBody body(clamped_box({}, SimTime(5'000'000)));
  body.initialize({});
  const Model& model = body.model();
  Eigen::VectorXd f;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f, K);
  double loss = 0.0;
  const double start = body.observe().energy.total_J();
  for (int k = 0; k < 50; ++k) {
    const State before = body.state();
    body.advance(request({}, {}, SimTime(5'000'000)));
    const Eigen::VectorXd dv = body.state().v - before.v;
    const Eigen::VectorXd du = body.state().x - before.x;
    loss += 0.5 * dv.dot(multiply_scalar(model.pattern(), model.mass, dv)) +
            0.5 * du.dot(multiply(model.pattern(), K, du));
  }
  const EnergyBook end = body.observe().energy;
  EXPECT_NEAR(end.numerical_loss_J, loss, kRoundOff * start);
  EXPECT_NEAR(start - end.total_J(), loss, kRoundOff * start);
  EXPECT_GT(loss, 1e-3 * start);
}

/// One step of x¨ + ω² x = 0 by the weights of [Chung & Hulbert 1993]; α_m = 0 and α_f = −α: HHT.
struct Oscillator {
  double alpha_m, alpha_f, beta, gamma;
  Eigen::Vector3d step(const Eigen::Vector3d& now, double omega, double h) const {
    const double k = omega * omega;
    Eigen::Matrix3d next, last;
    next << 1, 0, -beta * h * h, 0, 1, -gamma * h, (1 - alpha_f) * k, 0, 1 - alpha_m;
    last << 1, h, (0.5 - beta) * h * h, 0, 1, (1 - gamma) * h, -alpha_f * k, 0, -alpha_m;
    return next.lu().solve(last * now);
  }
};

// The body moves in one of its modes, which is a single oscillator: the loss of the booked kind is
// what the textbook's recursion loses of ½ v² + ½ ω² x².
TEST(FemEnergyLoss, OfHhtAndGeneralisedAlphaIsThatOfTheOscillator) {
  const double rho = 0.5, alpha = -0.2;
  const double m = (2 * rho - 1) / (rho + 1), f = rho / (rho + 1);
  const std::vector<std::pair<IntegratorParams, Oscillator>> cases = {
      {{.kind = IntegratorKind::Hht, .hht_alpha = alpha},
       {0.0, -alpha, 0.25 * (1 - alpha) * (1 - alpha), 0.5 - alpha}},
      {{.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = rho},
       {m, f, 0.25 * (1 - m + f) * (1 - m + f), 0.5 - m + f}}};
  for (const auto& [integrator, oscillator] : cases) {
    const SimTime H(500'000'000);
    Params params = clamped_box(integrator, H);
    params.initial_velocity = {};
    const Model model(params);
    const Modes modes = lowest_modes(model, 1);
    const double omega = 2 * M_PI * modes.frequencies_Hz(0), h = to_seconds(H);
    const Eigen::VectorXd phi = modes.shapes.col(0);  // φ·M φ = 1
    const TransientStep step(model, {});
    State state;
    WrenchSet none;
    ASSERT_EQ(step.start({}, state, none).outcome, Outcome::Done);
    state.v = phi;  // at rest position: no acceleration
    Eigen::Vector3d truth(0.0, 1.0, 0.0);
    for (int k = 0; k < 30; ++k) {
      Linearisation kept;
      state.generation = static_cast<std::uint64_t>(k) + 1;
      state = step.advance(state, {}, {}, H, kept).state;
      truth = oscillator.step(truth, omega, h);
      const double left = 0.5 * truth[1] * truth[1] + 0.5 * omega * omega * truth[0] * truth[0];
      // Modes are known to 1e-9 of their shapes.
      EXPECT_NEAR(state.book.numerical_loss_J, 0.5 - left, 1e-8) << "step " << k;
    }
    EXPECT_GT(state.book.numerical_loss_J, 1e-3);
  }
}

// By the trapezoidal rule a free linear body keeps its energy.
TEST(FemEnergyLoss, OfTheTrapezoidalRuleIsNone) {
  FlexibleBody body(
      clamped_box({.kind = IntegratorKind::Hht, .hht_alpha = 0.0}, SimTime(5'000'000)));
  body.initialize({});
  const double start = body.observe().energy.total_J();
  for (int k = 0; k < 50; ++k) body.advance(request({}, {}, SimTime(5'000'000)));
  EXPECT_NEAR(body.observe().energy.numerical_loss_J, 0.0, kRoundOff * start);
}

// A set that is fixed gives its motion to the ground, a set that is released takes no energy along.
TEST(FemEnergyLoss, OfACommandIsTheMotionThatTheGroundTakes) {
  for (const IntegratorKind kind :
       {IntegratorKind::BackwardEuler, IntegratorKind::Hht, IntegratorKind::GeneralisedAlpha}) {
    FlexibleBody body(clamped_box({.kind = kind}, SimTime(5'000'000)));
    body.initialize({});
    const EnergyBook begin = body.observe().energy;
    const auto steps = [&] {
      for (int k = 0; k < 10; ++k) body.advance(request({}, {}, SimTime(5'000'000)));
    };
    steps();
    ASSERT_TRUE(body.command("fix RIGHT").accepted);
    EXPECT_GT(body.observe().energy.damping_loss_J, 1e-3 * begin.kinetic_J);
    steps();
    ASSERT_TRUE(body.command("release LEFT").accepted);
    steps();
    EXPECT_NEAR(balance_error_J(begin, body.observe().energy), 0.0, kRoundOff * begin.kinetic_J);
  }
}

// The books belong to the state: they come back with it, bit for bit, and so does what the next
// step's trapezoids need.
TEST_P(FemEnergy, RollbackRestoresTheBooks) {
  const Params params = loaded_bar(GetParam().integrator, FormulationKind::Corotational);
  FlexibleBody body(params);
  body.initialize(pair_motion(0.0));
  const auto advance = [&](int k) {
    body.advance(request(pair_motion(1e-3 * k), pair_motion(1e-3 * (k + 1)), params.micro_step));
    return body.observe().energy;
  };
  static_cast<void>(advance(0));
  const EnergyBook saved = advance(1);
  body.checkpoint();
  const EnergyBook first = advance(2);
  EXPECT_NE(first, saved);
  body.rollback();
  EXPECT_EQ(body.observe().energy, saved);
  EXPECT_EQ(advance(2), first);
}

}  // namespace
}  // namespace tandem::fem

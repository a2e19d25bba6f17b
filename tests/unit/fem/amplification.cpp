#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>

#include "fem_process/reduced/modal_analysis.h"
#include "fem_process/transient/transient_step.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// Weights of M ((1−α_m) a⁺ + α_m a) + (1−α_f) K x⁺ + α_f K x = 0 with Newmark's β and γ.
struct Weights {
  double alpha_m = 0.0, alpha_f = 0.0, beta = 0.25, gamma = 0.5;
};

/// Weights of [Chung & Hulbert 1993, eqs. 17, 20, 25].
Weights chung_hulbert(double rho) {
  const double m = (2 * rho - 1) / (rho + 1);
  const double f = rho / (rho + 1);
  return {m, f, 0.25 * (1 - m + f) * (1 - m + f), 0.5 - m + f};
}

Weights hht(double alpha) { return {0.0, -alpha, 0.25 * (1 - alpha) * (1 - alpha), 0.5 - alpha}; }

Params clamped_cube() {
  static const std::filesystem::path file = temporary_file("amplification.inp", box_inp(1));
  Params params;
  params.mesh.file = file;
  params.material = {.young_Pa = 300.0, .poisson = 0.3, .density_kg_per_m3 = 100.0};
  params.formulation = FormulationKind::Linear;
  params.fixed = {{"LEFT"}};
  return params;
}

/// The eigenvalue of largest modulus of a mode's amplification matrix as the weights have it: one
/// step of a single degree of freedom, state (x, h v, h² a), Ω = ω h.
std::complex<double> dominant(const Eigen::Matrix3d& A) {
  const Eigen::Vector3cd values = Eigen::EigenSolver<Eigen::Matrix3d>(A).eigenvalues();
  Eigen::Index k = 0;
  values.cwiseAbs().maxCoeff(&k);
  return values(k);
}

Eigen::Matrix3d theory(const Weights& w, double Omega) {
  const double O2 = Omega * Omega;
  Eigen::Matrix3d now;  // rows: position, velocity, balance
  Eigen::Matrix3d next;
  next << 1, 0, -w.beta, 0, 1, -w.gamma, (1 - w.alpha_f) * O2, 0, 1 - w.alpha_m;
  now << 1, 1, 0.5 - w.beta, 0, 1, 1 - w.gamma, -w.alpha_f * O2, 0, -w.alpha_m;
  return next.lu().solve(now);
}

/// The body's own amplification of its first mode: one step from each of three states, measured by
/// φᵀ M. The balance holds in all of them, as in every state that a step leaves behind.
Eigen::Matrix3d measured(const IntegratorParams& integrator, double Omega) {
  Params params = clamped_cube();
  params.integrator = integrator;
  params.micro_step = SimTime(1'000'000);
  const double omega = 2 * M_PI * lowest_modes(Model(params), 1).frequencies_Hz(0);
  const double h = Omega / omega;
  params.micro_step = sim_time_from_seconds(h);
  const Model model(params);
  const Modes modes = lowest_modes(model, 1);
  const Eigen::VectorXd phi = modes.shapes.col(0);
  const Eigen::VectorXd M_phi = multiply_scalar(model.pattern(), model.mass, phi);
  const TransientStep step(model, {});
  Eigen::Matrix3d A;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Vector3d begin = Eigen::Vector3d::Unit(k);
    State state;
    WrenchSet none;
    EXPECT_EQ(step.start({}, state, none).outcome, Outcome::Done);
    state.x += begin[0] * phi;
    state.v = begin[1] / h * phi;
    if (state.a.size() > 0) state.a = begin[2] / (h * h) * phi;
    if (state.acceleration.size() > 0) state.acceleration = -begin[0] * omega * omega * phi;
    state.generation = static_cast<std::uint64_t>(k) + 1;
    Linearisation kept;
    const TransientStep::Result result = step.advance(state, {}, {}, params.micro_step, kept);
    EXPECT_EQ(result.report.outcome, Outcome::Done) << result.report.message;
    const State& end = result.state;
    A(0, k) = M_phi.dot(end.x - model.reference());
    A(1, k) = h * M_phi.dot(end.v);
    A(2, k) = end.a.size() > 0 ? h * h * M_phi.dot(end.a) : 0.0;
  }
  return A;
}

struct Case {
  std::string name;
  IntegratorParams integrator;
  Weights weights;
};

class FemAmplification : public ::testing::TestWithParam<Case> {};

// The whole matrix, from slow motion to Ω = 1e4. The micro step is a whole number of nanoseconds,
// 1e-9 of the slowest step; the entries grow with Ω².
TEST_P(FemAmplification, OfAModeIsThatOfASingleDegreeOfFreedom) {
  const Case& c = GetParam();
  for (double Omega : {0.05, 0.5, 2.0, 20.0, 1e4}) {
    const Eigen::Matrix3d expected = theory(c.weights, Omega);
    const Eigen::Matrix3d found = measured(c.integrator, Omega);
    EXPECT_LT((found - expected).norm(), 1e-7 * expected.norm()) << "Omega = " << Omega;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FemAmplification,
    ::testing::Values(
        Case{"hht", {.kind = IntegratorKind::Hht, .hht_alpha = -0.05}, hht(-0.05)},
        Case{"hht_most", {.kind = IntegratorKind::Hht, .hht_alpha = -0.3}, hht(-0.3)},
        Case{"rho_1",
             {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 1.0},
             chung_hulbert(1.0)},
        Case{"rho_08",
             {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.8},
             chung_hulbert(0.8)},
        Case{"rho_0",
             {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.0},
             chung_hulbert(0.0)},
        Case{"newmark", {.kind = IntegratorKind::Newmark}, {}},
        Case{"linear_acceleration",
             {.kind = IntegratorKind::Newmark, .newmark_beta = 1.0 / 6.0},
             {.beta = 1.0 / 6.0}},
        Case{"damped",
             {.kind = IntegratorKind::Newmark, .newmark_beta = 0.36, .newmark_gamma = 0.7},
             {.beta = 0.36, .gamma = 0.7}}),
    [](const auto& tested) { return tested.param.name; });

// The three eigenvalues meet at infinity: what is left of 1/Ω² at Ω = 1e4 moves them by its cube
// root at most, 2e-3 times a factor of a few.
TEST(FemSpectralRadius, OfGeneralisedAlphaAtInfinityIsRho) {
  for (double rho : {0.0, 0.3, 0.5, 0.8, 0.9, 1.0}) {
    const Eigen::Matrix3d A =
        measured({.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = rho}, 1e4);
    EXPECT_NEAR(std::abs(dominant(A)), rho, 0.02) << "rho = " << rho;
  }
}

/// Damping ratio ξ and relative period error of λ = exp(Ω̄ (−ξ ± i)), Ω̄ = arg λ.
struct Decay {
  double ratio = 0.0;
  double period_error = 0.0;
};
Decay decay(const IntegratorParams& integrator, double Omega) {
  const std::complex<double> lambda = dominant(measured(integrator, Omega));
  const double turned = std::abs(std::arg(lambda));
  return {-std::log(std::abs(lambda)) / turned, Omega / turned - 1.0};
}

// Leading terms of the closed forms [Hughes 1987, section 9.3]; what follows is smaller by Ω² (by Ω
// where first order): at Ω = 0.05 within 1 %.
TEST(FemNumericalDamping, OfSlowMotionIsThatOfTheClosedForms) {
  const double O = 0.05;
  // Average acceleration: no damping, T̄/T − 1 = Ω²/12; linear acceleration: Ω²/24.
  const Decay average = decay({.kind = IntegratorKind::Newmark}, O);
  EXPECT_LT(std::abs(average.ratio), 1e-9);
  EXPECT_NEAR(average.period_error, O * O / 12, 0.01 * O * O / 12);
  const Decay linear = decay({.kind = IntegratorKind::Newmark, .newmark_beta = 1.0 / 6.0}, O);
  EXPECT_NEAR(linear.period_error, O * O / 24, 0.01 * O * O / 24);
  // Newmark with γ > ½: ξ = (γ − ½) Ω/2.
  const Decay damped =
      decay({.kind = IntegratorKind::Newmark, .newmark_beta = 0.36, .newmark_gamma = 0.7}, O);
  EXPECT_NEAR(damped.ratio, 0.2 * O / 2, 0.01 * 0.2 * O / 2);
  // Backward Euler, λ = 1/(1 ∓ iΩ): ln |λ| = −½ ln(1 + Ω²), arg λ = arctan Ω, exactly.
  const Decay euler = decay({}, O);
  EXPECT_NEAR(euler.ratio, 0.5 * std::log1p(O * O) / std::atan(O), 1e-7);
  EXPECT_NEAR(euler.period_error, O / std::atan(O) - 1.0, 1e-7);
  // The second-order methods damp slow motion by Ω³ at most: ξ(2 Ω)/ξ(Ω) = 8.
  for (const IntegratorParams& integrator :
       {IntegratorParams{.kind = IntegratorKind::Hht, .hht_alpha = -0.1},
        IntegratorParams{.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.5}}) {
    EXPECT_NEAR(decay(integrator, 2 * O).ratio / decay(integrator, O).ratio, 8.0, 0.2);
  }
}

}  // namespace
}  // namespace tandem::fem

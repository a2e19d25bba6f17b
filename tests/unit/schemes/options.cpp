// Options of the schemes against closed forms on the split oscillator: kept Jacobians, retained
// interface inertia, transmission line.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "protocol/schemes/transmission_line.h"
#include "tests/support/split_oscillator.h"

namespace tandem {
namespace {

using test::Journals;
using test::MassMbs;
using test::MassSpringFem;
using Case = test::SplitOscillator;

const SimTime kStep = sim_time_from_seconds(1e-3);

int linearized_calls(const Journals& journals, wire::SideName side) {
  int count = 0;
  for (const wire::StepJournal& journal : journals.steps) {
    for (const wire::CallRecord& call : journal.calls) count += call.side == side && call.linearize;
  }
  return count;
}

TEST(InterfaceJacobianRefresh, AsksForTheJacobiansAsSeldomAsItIsTold) {
  Case c{.fem_kg = 5.0, .stiffness = 1e4};
  c.coupling = {.scheme = SchemeKind::InterfaceNewton};
  c.coupling.jacobian = {
      .mbs_refresh = Refresh::EveryNSteps, .fem_refresh = Refresh::Broyden, .every_steps = 10};
  Journals journals;
  const RunReport report = run(c, journals);
  ASSERT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_EQ(linearized_calls(journals, wire::SideName::Mbs), 10);  // 100 steps
  EXPECT_EQ(linearized_calls(journals, wire::SideName::Fem), 1);
  // Both sides are affine with a constant derivative: nothing is lost by keeping it.
  EXPECT_LE(report.iterations_max, 2);
  EXPECT_NEAR(report.motions[0].p_WP.x(), exact_step_state(c).x, 1e-9);
}

// The hardening spring's derivative changes from step to step: Broyden's updates must learn it.
TEST(InterfaceJacobianRefresh, BroydenFollowsAHardeningSpring) {
  Case c{.fem_kg = 2.0, .stiffness = 1e4, .hardening = 1e3};
  c.coupling = {.scheme = SchemeKind::InterfaceNewton};
  const RunReport fresh = run(c);
  c.coupling.jacobian = {.mbs_refresh = Refresh::Broyden, .fem_refresh = Refresh::Broyden};
  Journals journals;
  const RunReport kept = run(c, journals);
  ASSERT_EQ(kept.status, RunStatus::Done) << kept.message;
  EXPECT_LT(linearized_calls(journals, wire::SideName::Fem), 10);
  EXPECT_NEAR(kept.motions[0].p_WP.x(), fresh.motions[0].p_WP.x(), 1e-9);
}

/// λ_{n+2}/λ_{n+1} behind an error of the wrench with k = 0, hold prediction and M̂ = factor · μ.
double amplification(double mass_ratio, double factor) {
  CouplingParams coupling{.scheme = SchemeKind::ExplicitSerial, .prediction = Prediction::Hold};
  coupling.retained_inertia.factor = factor;
  MassMbs mbs(1.0, {});
  MassSpringFem fem(mass_ratio, 0.0);
  ExplicitSerial scheme(coupling, fem.info().ports);
  InterfaceState state;
  state.motions = mbs.initialize(WrenchSet(1));
  state.wrenches = fem.initialize(state.motions);
  state.wrenches[0].f_P_W.x() = 1.0;
  double last = 0.0, ratio = 0.0;
  for (int n = 0; n < 2; ++n) {
    mbs.checkpoint();
    fem.checkpoint();
    const MacroStepEnd end = scheme.advance(kStep, state, mbs, fem);
    const double force = end.wrenches[0].f_P_W.x();
    ratio = force / last;
    last = force;
    state.time += kStep;
    state.motions = end.motions;
    state.wrenches = end.wrenches;
  }
  return ratio;
}

// (M̂ − μ)/(m + M̂): stable up to μ = m/(1 − 2 factor) instead of m, and everywhere from one half on.
TEST(RetainedInertia, IsNamedWhereItHasNoEffect) {
  for (const SchemeKind scheme :
       {SchemeKind::Implicit, SchemeKind::InterfaceNewton, SchemeKind::Tlm}) {
    CouplingParams params{.scheme = scheme};
    EXPECT_TRUE(notes_of(params).empty());
    params.retained_inertia.factor = 0.5;
    ASSERT_EQ(notes_of(params).size(), 1U);
    for (const std::string& part : {std::string("coupling.retained_inertia.factor: 0.5"),
                                    to_string(scheme), std::string("explicit_serial")}) {
      EXPECT_NE(notes_of(params)[0].find(part), std::string::npos) << notes_of(params)[0];
    }
  }
  EXPECT_TRUE(
      notes_of({.scheme = SchemeKind::ExplicitParallel, .retained_inertia = {.factor = 1.0}})
          .empty());
}

TEST(RetainedInertia, WidensTheStabilityLimitAsItsClosedFormSays) {
  for (double factor : {0.1, 0.25, 0.4, 0.5, 1.0}) {
    for (double mu : {0.5, 1.5, 3.0, 100.0}) {
      const double retained = factor * mu;
      EXPECT_NEAR(amplification(mu, factor), (retained - mu) / (1.0 + retained), 1e-9)
          << factor << " " << mu;
    }
  }
}

TEST(RetainedInertia, RunsExplicitSchemesFarBeyondTheirMassRatio) {
  for (SchemeKind scheme : {SchemeKind::ExplicitSerial, SchemeKind::ExplicitParallel}) {
    for (double fem_kg : {3.0, 100.0}) {
      Case c{.fem_kg = fem_kg, .stiffness = 400.0, .duration_s = 0.2};
      c.coupling = {
          .scheme = scheme, .prediction = Prediction::Hold, .motion_prediction = Prediction::Hold};
      EXPECT_EQ(run(c).status, RunStatus::Diverged);
      c.coupling.retained_inertia.factor = 1.0;
      const RunReport report = run(c);
      ASSERT_EQ(report.status, RunStatus::Done) << report.message;
      // One step more than there are: the one in which the inertia is taken.
      EXPECT_EQ(report.iterations_total, report.macro_steps + 1);
      // First order: 1 % of the amplitude at H = 1e-3 s and a period of 0.6 s or more.
      EXPECT_LT(phase_distance(c, report), 0.01 * std::hypot(0.01, 1.0 / 2.0)) << fem_kg;
    }
  }
}

/// Free vibration of m — k_line — μ — k — ground from x = (x0, x0), v = (1, 1), at time t. The line
/// starts with the force λ0 = −k x0 in it, which the flexible side answers at t = 0.
double line_system_x1(const Case& c, double line_N_per_m) {
  Eigen::Matrix2d M = Eigen::Vector2d(c.mbs_kg, c.fem_kg).asDiagonal();
  Eigen::Matrix2d K;
  K << line_N_per_m, -line_N_per_m, -line_N_per_m, line_N_per_m + c.stiffness;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(K, M);
  const Eigen::Matrix2d& V = modes.eigenvectors();  // Vᵀ M V = I
  const double lambda0 = -c.stiffness * 0.01;
  const Eigen::Vector2d rest = K.inverse() * Eigen::Vector2d(lambda0, -lambda0);
  const Eigen::Vector2d q = V.transpose() * M * (Eigen::Vector2d(0.01, 0.01) - rest);
  const Eigen::Vector2d p = V.transpose() * M * Eigen::Vector2d(1.0, 1.0);
  Eigen::Vector2d now;
  for (int i = 0; i < 2; ++i) {
    const double w = std::sqrt(modes.eigenvalues()[i]);
    now[i] = q[i] * std::cos(w * c.duration_s) + p[i] / w * std::sin(w * c.duration_s);
  }
  return (rest + V * now)[0];
}

RunReport run_line(const Case& c) {
  MassMbs mbs(c.mbs_kg, {.x = 0.01, .v = 1.0});
  const auto fem = prepared_for(c.coupling, std::make_unique<MassSpringFem>(c.fem_kg, c.stiffness));
  const auto params = scheme_run(
      {sim_time_from_seconds(c.duration_s), sim_time_from_seconds(c.step_s)}, c.coupling);
  Journals journals;
  return run_coupled(params, {mbs}, {*fem}, journals);
}

// The line is a physical spring: the run converges to the system with that spring, with the order
// of the two integrators.
TEST(TransmissionLine, ConvergesToTheSystemWithTheLineAsASpring) {
  double last_error = 0.0;
  for (int level = 0; level < 5; ++level) {
    Case c{
        .fem_kg = 2.0, .stiffness = 100.0, .duration_s = 0.16, .step_s = 5e-4 / std::pow(2, level)};
    c.coupling = {.scheme = SchemeKind::Tlm, .tlm = {.stiffness_N_per_m = 1000.0}};
    const RunReport report = run_line(c);
    ASSERT_EQ(report.status, RunStatus::Done) << report.message;
    EXPECT_EQ(report.iterations_max, 1);
    const double error = std::abs(report.motions[0].p_WP.x() - line_system_x1(c, 1000.0));
    if (level > 0) {
      EXPECT_NEAR(std::log2(last_error / error), 1.0, 0.15) << "level " << level;
    }
    last_error = error;
  }
}

// Whatever it joins: mass ratios 0.01 to 100, lines and springs from soft to far stiffer than the
// step resolves. The energy put in at t = 0 bounds every later velocity.
TEST(TransmissionLine, IsStableForEveryMassRatioAndStiffness) {
  for (double fem_kg : {0.01, 1.0, 100.0}) {
    for (double stiffness : {0.0, 1e3, 1e9}) {
      for (double line : {1e2, 1e5, 1e8}) {
        for (double tolerance : {0.0, 1e-2}) {  // equal steps, and adaptive ones
          Case c{.fem_kg = fem_kg, .stiffness = stiffness, .duration_s = 1.0};
          c.coupling = {.scheme = SchemeKind::Tlm, .tlm = {.stiffness_N_per_m = line}};
          c.coupling.adaptive.tolerance = tolerance;
          const RunReport report = run_line(c);
          ASSERT_EQ(report.status, RunStatus::Done) << report.message;
          // Of the masses, the spring, and the line with the spring's force in it.
          const double energy_J = 0.5 * (1.0 + fem_kg) + 0.5 * stiffness * 1e-4 +
                                  0.5 * std::pow(stiffness * 0.01, 2) / line;
          EXPECT_LT(report.energy_end.sum().kinetic_J, 1.1 * energy_J)
              << fem_kg << " kg, " << stiffness << " N/m, line " << line << " N/m, tolerance "
              << tolerance;
        }
      }
    }
  }
}

TEST(TransmissionLine, ReportsItsParasiticMass) {
  Case c{.fem_kg = 1.0, .stiffness = 10.0};
  c.coupling = {.scheme = SchemeKind::Tlm, .tlm = {.stiffness_N_per_m = 2e5}};
  EXPECT_NEAR(run_line(c).parasitic_mass_kg.value(), 0.2, 1e-12);  // k H²
  EXPECT_FALSE(run(Case{.stiffness = 10.0}).parasitic_mass_kg.has_value());
}

// With steps that change: of the longest.
TEST(TransmissionLine, ReportsTheLargestParasiticMassOfAdaptiveSteps) {
  Case c{.fem_kg = 1.0, .stiffness = 10.0};
  c.coupling = {.scheme = SchemeKind::Tlm, .tlm = {.stiffness_N_per_m = 2e5}};
  c.coupling.adaptive = {.tolerance = 1e-4, .max_step = 4 * kStep};
  Journals journals;
  MassMbs mbs(c.mbs_kg, {.x = 0.01, .v = 1.0});
  const auto fem = prepared_for(c.coupling, std::make_unique<MassSpringFem>(c.fem_kg, c.stiffness));
  const RunReport report =
      run_coupled(scheme_run({sim_time_from_seconds(c.duration_s), sim_time_from_seconds(c.step_s)},
                             c.coupling),
                  {mbs}, {*fem}, journals);
  SimTime longest{}, shortest = kStep;
  for (std::size_t n = 1; n < journals.steps.size(); ++n) {
    longest = std::max(longest, journals.steps[n].step.step);
    shortest = std::min(shortest, journals.steps[n].step.step);
  }
  EXPECT_GT(longest, shortest);
  EXPECT_NEAR(report.parasitic_mass_kg.value(), 2e5 * std::pow(to_seconds(longest), 2), 1e-12);
}

TEST(TransmissionLine, EndRollsBackToTheBit) {
  LineEnd end(std::make_unique<MassSpringFem>(2.0, 1e4, 1e3), 1e4);
  MotionSet a(1), b(1);
  a[0].v_WP.x() = 1.0;
  b[0].v_WP.x() = 0.7;
  (void)end.initialize(a);
  const StepRequest<MotionSet> step{.step = kStep, .input = {a, a}};
  const StepRequest<MotionSet> other{.step = kStep, .input = {b, b}};
  for (int n = 0; n < 3; ++n) {
    end.checkpoint();
    const auto first = end.advance(step);
    const std::uint64_t hash = end.observe().state_hash;
    end.rollback();
    (void)end.advance(other);
    end.rollback();
    const auto again = end.advance(step);
    EXPECT_EQ(stack(first.output), stack(again.output));
    EXPECT_EQ(end.observe().state_hash, hash);
  }
}

}  // namespace
}  // namespace tandem

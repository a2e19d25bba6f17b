// No scheme has a number of newtons, joules or metres per second of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/split_oscillator.h"

namespace tandem {
namespace {

using Case = test::SplitOscillator;
using test::run;

/// Every scheme, with and without adaptive steps, and how it is iterated.
struct Scale : testing::TestWithParam<CouplingParams> {};

// All forces, masses and stiffnesses times 2⁻⁶⁰: multiplications by a power of two are exact, so a
// scheme that has no number of newtons or joules of its own makes the same motions bit for bit, in
// as many iterations, and its wrenches are 2⁻⁶⁰ of the others.
TEST_P(Scale, OfTheForcesIsNothingASchemeKnows) {
  const double small = std::ldexp(1.0, -60);
  Case c{.fem_kg = 0.2, .stiffness = 400.0, .hardening = 5.0, .duration_s = 0.2, .step_s = 1e-3};
  c.coupling = GetParam();
  for (const double fem_kg : {0.2, 3.0}) {  // with the heavier one explicit schemes diverge
    c.fem_kg = fem_kg;
    Case tiny = c;
    tiny.mbs_kg *= small;
    tiny.fem_kg *= small;
    tiny.stiffness *= small;
    tiny.coupling.tlm.stiffness_N_per_m *= small;
    const RunReport a = run(c), b = run(tiny);
    EXPECT_EQ(a.status, b.status) << a.message << b.message;
    EXPECT_EQ(a.macro_steps, b.macro_steps);
    EXPECT_EQ(a.iterations_total, b.iterations_total);
    EXPECT_EQ(a.rejected_steps, b.rejected_steps);
    EXPECT_EQ(difference(a.motions, b.motions).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_EQ(stack(a.wrenches) * small, stack(b.wrenches));
  }
}

std::vector<CouplingParams> all_schemes() {
  std::vector<CouplingParams> all;
  for (const double tolerance : {0.0, 1e-4}) {
    const AdaptiveParams adaptive{.tolerance = tolerance};
    for (const SchemeKind scheme : {SchemeKind::ExplicitSerial, SchemeKind::ExplicitParallel,
                                    SchemeKind::InterfaceNewton, SchemeKind::Tlm}) {
      all.push_back({.scheme = scheme, .prediction = Prediction::Hold, .adaptive = adaptive});
    }
    for (const Iteration iteration : {Iteration::Serial, Iteration::Parallel}) {
      all.push_back({.scheme = SchemeKind::Implicit,
                     .iteration = iteration,
                     .relaxation = Relaxation::IqnIls,
                     .adaptive = adaptive});
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(All, Scale, testing::ValuesIn(all_schemes()));

}  // namespace
}  // namespace tandem

// Order in H of every scheme on the split oscillator, against the solution of the differential
// equation, not of the discrete one: both integrators are of order 1.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "protocol/schemes/transmission_line.h"
#include "tests/support/split_oscillator.h"

namespace tandem::test {
namespace {

struct SchemeCase {
  std::string name;
  CouplingParams coupling;
  double line_impedance_Ns_per_m = 0.0;  ///< Z = k H of tlm: its mass and compliance vanish with H
};

/// Distance in the phase plane to (m + μ) x'' + k x = 0, relative to the amplitude.
double phase_error(SplitOscillator c, double line_impedance_Ns_per_m) {
  if (line_impedance_Ns_per_m > 0.0) {
    c.coupling.tlm.stiffness_N_per_m = line_impedance_Ns_per_m / c.step_s;
  }
  MassMbs mbs(c.mbs_kg, {.x = 0.01, .v = 1.0});
  const auto fem = prepared_for(c.coupling, std::make_unique<MassSpringFem>(c.fem_kg, c.stiffness));
  Journals journals;
  const RunReport report =
      run_coupled(scheme_run({sim_time_from_seconds(c.duration_s), sim_time_from_seconds(c.step_s)},
                             c.coupling),
                  {mbs}, {*fem}, journals);
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  const double omega = std::sqrt(c.stiffness / (c.mbs_kg + c.fem_kg));
  const double angle = omega * c.duration_s;
  const double x = 0.01 * std::cos(angle) + 1.0 / omega * std::sin(angle);
  const double v = 1.0 * std::cos(angle) - 0.01 * omega * std::sin(angle);
  return std::hypot(report.motions[0].p_WP.x() - x, (report.motions[0].v_WP.x() - v) / omega) /
         std::hypot(0.01, 1.0 / omega);
}

class SchemeOrder : public testing::TestWithParam<SchemeCase> {};

// 0.16 s are half a period. κ = 0.1, so that start-up transients die out at once.
TEST_P(SchemeOrder, IsOneOverFourHalvings) {
  double coarser = 0.0;
  for (int halving = 0; halving <= 4; ++halving) {
    SplitOscillator c{.fem_kg = 0.1,
                      .stiffness = 400.0,
                      .duration_s = 0.16,
                      .step_s = 5e-4 / (1 << halving),
                      .coupling = GetParam().coupling};
    const double error = phase_error(c, GetParam().line_impedance_Ns_per_m);
    if (halving > 0) {
      EXPECT_NEAR(std::log2(coarser / error), 1.0, 0.15) << "H = " << c.step_s << ", " << error;
    }
    coarser = error;
  }
}

CouplingParams explicitly(SchemeKind scheme, Prediction prediction, double inertia = 0.0) {
  CouplingParams params{
      .scheme = scheme, .prediction = prediction, .motion_prediction = prediction};
  params.retained_inertia.factor = inertia;
  return params;
}

CouplingParams implicitly(Relaxation relaxation, Iteration iteration = Iteration::Serial) {
  return {.scheme = SchemeKind::Implicit, .iteration = iteration, .relaxation = relaxation};
}

const SchemeCase kCases[] = {
    {"explicit_serial_hold", explicitly(SchemeKind::ExplicitSerial, Prediction::Hold)},
    {"explicit_serial_linear", explicitly(SchemeKind::ExplicitSerial, Prediction::Linear)},
    {"explicit_serial_quadratic", explicitly(SchemeKind::ExplicitSerial, Prediction::Quadratic)},
    {"explicit_serial_inertia", explicitly(SchemeKind::ExplicitSerial, Prediction::Hold, 1.0)},
    {"explicit_parallel_hold", explicitly(SchemeKind::ExplicitParallel, Prediction::Hold)},
    {"explicit_parallel_linear", explicitly(SchemeKind::ExplicitParallel, Prediction::Linear)},
    {"explicit_parallel_inertia", explicitly(SchemeKind::ExplicitParallel, Prediction::Hold, 1.0)},
    {"implicit_constant", implicitly(Relaxation::Constant)},
    {"implicit_aitken", implicitly(Relaxation::Aitken)},
    {"implicit_anderson", implicitly(Relaxation::Anderson)},
    {"implicit_iqn_ils", implicitly(Relaxation::IqnIls)},
    {"implicit_iqn_imvj_parallel", implicitly(Relaxation::IqnImvj, Iteration::Parallel)},
    {"interface_jacobian", {.scheme = SchemeKind::InterfaceNewton}},
    {"tlm", {.scheme = SchemeKind::Tlm}, 30.0},
};

INSTANTIATE_TEST_SUITE_P(SplitOscillator, SchemeOrder, testing::ValuesIn(kCases),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tandem::test

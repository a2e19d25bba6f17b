#pragma once

#include <cmath>
#include <vector>

#include "protocol/driver/coupled_run.h"
#include "tests/support/mock_sides.h"

namespace tandem::test {

class Journals final : public StepSink {
 public:
  double record(wire::StepJournal journal) override {
    steps.push_back(std::move(journal));
    return 0.0;
  }
  std::vector<wire::StepJournal> steps;
};

/// The smallest coupled system: a free mass m joined to a mass μ that hangs on a spring k. With H
/// the coupling ratio is κ = (μ + H² k)/m, and the fixed-point map of one macro step is
/// λ → −κ λ + const.
struct SplitOscillator {
  double mbs_kg = 1.0, fem_kg = 0.5, stiffness = 0.0, hardening = 0.0;
  double duration_s = 0.1, step_s = 0.001;
  CouplingParams coupling;
  double pace = 0.0;  ///< simulated over wall time; 0: free
};

inline RunReport run(const SplitOscillator& c, Journals& journals) {
  MassMbs mbs(c.mbs_kg, {.x = 0.01, .v = 1.0});
  MassSpringFem fem(c.fem_kg, c.stiffness, c.hardening);
  const auto params = scheme_run({.duration = sim_time_from_seconds(c.duration_s),
                                  .macro_step = sim_time_from_seconds(c.step_s),
                                  .pace = c.pace},
                                 c.coupling);
  return run_coupled(params, {mbs}, {fem}, journals);
}

inline RunReport run(const SplitOscillator& c) {
  Journals journals;
  return run(c, journals);
}

/// The same system as one body: backward Euler of (m + μ) v' = −k x.
inline MassMbs::State exact_step_state(const SplitOscillator& c) {
  MassMbs::State s{.x = 0.01, .v = 1.0};
  const auto n = static_cast<int>(std::lround(c.duration_s / c.step_s));
  const double mass = c.mbs_kg + c.fem_kg;
  for (int i = 0; i < n; ++i) {
    s.v = (mass * s.v - c.step_s * c.stiffness * s.x) / (mass + c.step_s * c.step_s * c.stiffness);
    s.x += c.step_s * s.v;
  }
  return s;
}

/// Distance in the phase plane, which has no accidental zero crossings: √(Δx² + (Δv/ω)²).
inline double phase_distance(const SplitOscillator& c, const RunReport& report) {
  const MassMbs::State exact = exact_step_state(c);
  const double omega = std::sqrt(c.stiffness / (c.mbs_kg + c.fem_kg));
  return std::hypot(report.motions[0].p_WP.x() - exact.x,
                    (report.motions[0].v_WP.x() - exact.v) / omega);
}

}  // namespace tandem::test

// Sweeps the split oscillator over mass ratio and stiffness with every scheme and prints the tables
// of docs/coupling.md: coupling_sweep
//   rigid mass m = 1 kg, flexible mass μ on a spring k, H = 1e-3 s, 200 macro steps.

#include <fmt/format.h>

#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "protocol/schemes/transmission_line.h"
#include "tests/support/split_oscillator.h"

namespace tandem::test {
namespace {

struct Row {
  std::string name;
  CouplingParams coupling;
};

CouplingParams implicit(Relaxation relaxation, Iteration iteration = Iteration::Serial) {
  return {.scheme = SchemeKind::Implicit, .iteration = iteration, .relaxation = relaxation};
}

CouplingParams explicit_scheme(SchemeKind scheme, Prediction prediction, double retained) {
  CouplingParams params{
      .scheme = scheme, .prediction = prediction, .motion_prediction = prediction};
  params.retained_inertia.factor = retained;
  return params;
}

std::vector<Row> rows() {
  using enum SchemeKind;
  using enum Prediction;
  return {{"explicit_serial, hold", explicit_scheme(ExplicitSerial, Hold, 0.0)},
          {"explicit_serial, linear", explicit_scheme(ExplicitSerial, Linear, 0.0)},
          {"explicit_serial, quadratic", explicit_scheme(ExplicitSerial, Quadratic, 0.0)},
          {"explicit_serial, hold, inertia ×0.25", explicit_scheme(ExplicitSerial, Hold, 0.25)},
          {"explicit_serial, hold, inertia", explicit_scheme(ExplicitSerial, Hold, 1.0)},
          {"explicit_serial, linear, inertia", explicit_scheme(ExplicitSerial, Linear, 1.0)},
          {"explicit_parallel, hold", explicit_scheme(ExplicitParallel, Hold, 0.0)},
          {"explicit_parallel, linear", explicit_scheme(ExplicitParallel, Linear, 0.0)},
          {"explicit_parallel, hold, inertia", explicit_scheme(ExplicitParallel, Hold, 1.0)},
          {"implicit, constant 0.5", implicit(Relaxation::Constant)},
          {"implicit, aitken", implicit(Relaxation::Aitken)},
          {"implicit, iqn_ils", implicit(Relaxation::IqnIls)},
          {"implicit, iqn_imvj", implicit(Relaxation::IqnImvj)},
          {"implicit, iqn_ils, parallel", implicit(Relaxation::IqnIls, Iteration::Parallel)},
          {"interface_jacobian", {.scheme = InterfaceNewton}},
          {"tlm, k = 1e4 N/m", {.scheme = Tlm}}};
}

/// Mean iterations per macro step, or how the run ended.
std::string cell(const CouplingParams& coupling, double fem_kg, double stiffness) {
  MassMbs mbs(1.0, {.x = 0.01, .v = 1.0});
  const auto fem = prepared_for(coupling, std::make_unique<MassSpringFem>(fem_kg, stiffness));
  const auto params =
      scheme_run({sim_time_from_seconds(0.2), sim_time_from_seconds(1e-3)}, coupling);
  Journals journals;
  const RunReport report = run_coupled(params, {mbs}, {*fem}, journals);
  if (report.status == RunStatus::Diverged) return "diverged";
  if (report.status == RunStatus::NotConverged) return "not conv.";
  // Too slow a growth for the monitor to have stopped it within the run is no stability either.
  const double energy_J = 0.5 * (1.0 + fem_kg) + 0.5 * stiffness * 1e-4;
  if (coupling.scheme != SchemeKind::Tlm && report.energy_end.sum().kinetic_J > 2.0 * energy_J) {
    return "grows";
  }
  return fmt::format("{:.2f}", static_cast<double>(report.iterations_total) /
                                   static_cast<double>(report.macro_steps));
}

void table(const std::string& title, const std::vector<double>& values,
           const std::function<std::string(const CouplingParams&, double)>& entry) {
  std::string head = fmt::format("| {} |", title), rule = "|---|";
  for (double value : values) {
    head += fmt::format(" {:g} |", value);
    rule += "---|";
  }
  std::string text = head + "\n" + rule + "\n";
  for (const Row& row : rows()) {
    text += fmt::format("| {} |", row.name);
    for (double value : values) text += fmt::format(" {} |", entry(row.coupling, value));
    text += "\n";
  }
  std::puts(text.c_str());
}

}  // namespace
}  // namespace tandem::test

int main() {
  using namespace tandem;
  test::table("mass ratio μ/m (k = 100 N/m)", {0.01, 0.1, 0.5, 0.9, 1.0, 2.0, 10.0, 100.0},
              [](const CouplingParams& c, double ratio) { return test::cell(c, ratio, 100.0); });
  test::table(
      "stiffness k H²/m (μ = 0.1 m)", {1e-4, 1e-2, 0.1, 1.0, 10.0, 100.0},
      [](const CouplingParams& c, double kappa) { return test::cell(c, 0.1, kappa * 1e6); });
  return 0;
}

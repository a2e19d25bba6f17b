// Figure 4 of [MZ12] and its evidence: displacement over load for linear, co-rotational and total
// Lagrangian formulation, against independent programs, with the solves that each tangent takes.
//   figure4 SVG_FILE      writes the plot, prints the tables of docs/fem.md

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>

#include "fem_process/transient/static_analysis.h"
#include "orchestrator/page/svg_plot.h"
#include "protocol/contract/error.h"
#include "tests/support/fem_reference_cases.h"

namespace tandem::fem {
namespace {

using testing::ReferenceCase;
using testing::ReferenceStep;

struct Curve {
  std::vector<Eigen::Vector3d> u;  ///< of the monitored node (m)
  std::vector<int> solves;
};

Curve solve(const ReferenceCase& reference, FormulationKind formulation, bool safeguards) {
  Params params = reference.params;
  params.formulation = formulation;
  const Model model(std::move(params));
  const StaticResult result =
      StaticAnalysis(model, {.load_factors = reference.factors(), .safeguards = safeguards}).run();
  Curve curve;
  for (const LoadStep& step : result.steps) {
    curve.u.push_back(mean_displacement(model, reference.monitor, step.x));
    curve.solves.push_back(step.iterations);
  }
  return curve;
}

struct Curves {
  Curve linear, plain, searched, consistent, lagrangian;
};

Curves solve_all(const ReferenceCase& reference) {
  return {.linear = solve(reference, FormulationKind::Linear, true),
          .plain = solve(reference, FormulationKind::Corotational, false),
          .searched = solve(reference, FormulationKind::Corotational, true),
          .consistent = solve(reference, FormulationKind::ConsistentCorotational, true),
          .lagrangian = solve(reference, FormulationKind::TotalLagrangian, true)};
}

/// Largest deviation over the load levels, % of the norm.
double worst_percent(const ReferenceCase& reference, const Curve& curve,
                     Eigen::Vector3d ReferenceStep::*expected) {
  require(curve.u.size() == reference.steps.size(), reference.name + ": a load step is missing.");
  double worst = 0.0;
  for (std::size_t k = 0; k < curve.u.size(); ++k) {
    const Eigen::Vector3d& u = reference.steps[k].*expected;
    worst = std::max(worst, 100.0 * (curve.u[k] - u).norm() / u.norm());
  }
  return worst;
}

std::string solves_text(const Curve& curve, std::size_t wanted) {
  if (curve.solves.size() < wanted) return fmt::format("stops after {}", curve.solves.size());
  const auto [low, high] = std::minmax_element(curve.solves.begin(), curve.solves.end());
  return *low == *high ? fmt::format("{}", *low) : fmt::format("{}–{}", *low, *high);
}

std::string case_row(const ReferenceCase& reference, const Curves& curves) {
  const std::size_t n = reference.steps.size();
  return fmt::format("| {} | {:.1e} | {:.1e} | {:.1e} | {:.2f} | {} | {} | {} |\n", reference.name,
                     worst_percent(reference, curves.lagrangian, &ReferenceStep::nlgeom),
                     worst_percent(reference, curves.searched, &ReferenceStep::corot),
                     worst_percent(reference, curves.consistent, &ReferenceStep::corot),
                     worst_percent(reference, curves.searched, &ReferenceStep::nlgeom),
                     solves_text(curves.plain, n), solves_text(curves.consistent, n),
                     solves_text(curves.lagrangian, n));
}

void print_levels(const ReferenceCase& reference, const Curves& curves) {
  fmt::print(
      "\n| load factor | linear (mm) | co-rotational (mm) | total Lagrangian (mm) | CalculiX "
      "NLGEOM "
      "(mm) | solves: plain | consistent | total Lagrangian "
      "|\n|---|---|---|---|---|---|---|---|\n");
  for (std::size_t k = 0; k < reference.steps.size(); ++k) {
    fmt::print("| {:.2f} | {:.5f} | {:.5f} | {:.5f} | {:.5f} | {} | {} | {} |\n",
               reference.steps[k].factor, 1e3 * curves.linear.u[k].norm(),
               1e3 * curves.searched.u[k].norm(), 1e3 * curves.lagrangian.u[k].norm(),
               1e3 * reference.steps[k].nlgeom.norm(), curves.plain.solves[k],
               curves.consistent.solves[k], curves.lagrangian.solves[k]);
  }
}

/// |u| over |f|, from zero.
orchestrator::PlotSeries series(const std::string& label, const ReferenceCase& reference,
                                const std::vector<Eigen::Vector3d>& u) {
  const double force = reference.params.loads.front().value.norm();
  orchestrator::PlotSeries series{.label = label, .x = {0.0}, .y = {0.0}};
  for (std::size_t k = 0; k < u.size(); ++k) {
    series.x.push_back(1e-3 * force * reference.steps[k].factor);
    series.y.push_back(1e3 * u[k].norm());
  }
  return series;
}

std::string figure(const ReferenceCase& reference, const Curves& curves) {
  std::vector<Eigen::Vector3d> rigorous;
  for (const ReferenceStep& step : reference.steps) rigorous.push_back(step.nlgeom);
  orchestrator::PlotSeries calculix = series("CalculiX NLGEOM", reference, rigorous);
  calculix.markers = true;
  calculix.dashed = true;
  const orchestrator::Plot plot{
      .title = "Hinge: displacement of the pin (Figure 4 of [MZ12])",
      .x_label = "force (kN)",
      .y_label = "displacement (mm)",
      .series = {series("linear", reference, curves.linear.u),
                 series("co-rotational", reference, curves.searched.u),
                 series("total Lagrangian", reference, curves.lagrangian.u), calculix}};
  return orchestrator::svg_document({plot});
}

void run(const std::string& svg_file) {
  fmt::print(
      "| case | total Lagrangian to CalculiX (%) | co-rotational to its reference (%) | consistent "
      "to its reference (%) | co-rotational to CalculiX (%) | solves: plain | consistent | total "
      "Lagrangian |\n|---|---|---|---|---|---|---|---|\n");
  for (const char* name :
       {"lug", "beam15", "cantilever_c1", "cantilever_c2", "cantilever_c3", "hinge"}) {
    const ReferenceCase reference = testing::reference_case(name);
    const Curves curves = solve_all(reference);
    fmt::print("{}", case_row(reference, curves));
    if (reference.name != "hinge") continue;
    print_levels(reference, curves);
    std::ofstream(svg_file) << figure(reference, curves);
  }
}

}  // namespace
}  // namespace tandem::fem

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: figure4 SVG_FILE\n");
    return 2;
  }
  try {
    tandem::fem::run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "figure4: %s\n", error.what());
    return 4;
  }
  return 0;
}

// What component mode synthesis costs in accuracy: the falling beam of examples/pendulum_beam
// reduced to modes against the full co-rotational body, over the size of the deformation and over
// the number of modes.
//   reduction SVG_FILE      writes the plots, prints the tables of docs/fem.md

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <fstream>

#include "orchestrator/page/svg_plot.h"
#include "tests/support/reduction_case.h"

namespace tandem::coupled_test {
namespace {

constexpr double kLength_m = 1.0;
constexpr double kDuration_s = 0.4;

/// Reduced against full body while the beam becomes softer.
orchestrator::Plot deformation_plot() {
  orchestrator::PlotSeries coarse{.label = "2 modes", .x = {}, .y = {}, .markers = true};
  orchestrator::PlotSeries fine{.label = "20 modes", .x = {}, .y = {}, .markers = true};
  orchestrator::PlotSeries square{.label = "deflection²", .x = {}, .y = {}, .dashed = true};
  fmt::print(
      "| Young's modulus (MPa) | largest deflection (% of the length) | 2 modes: distance of the "
      "tips (%) | 20 modes (%) |\n|---|---|---|---|\n");
  for (double young_Pa : {5e8, 1.6e8, 5e7, 1.6e7, 5e6}) {
    const TipMotion whole = falling_beam("corotational", young_Pa, kDuration_s);
    const double deflection = 100.0 * whole.largest_m() / kLength_m;
    double percent[2] = {};
    for (int i = 0; i < 2; ++i) {
      const TipMotion reduced =
          falling_beam("craig_bampton", young_Pa, kDuration_s, i == 0 ? 2 : 20);
      percent[i] = 100.0 * largest_distance_m(whole, reduced) / kLength_m;
    }
    coarse.x.push_back(deflection);
    coarse.y.push_back(percent[0]);
    fine.x.push_back(deflection);
    fine.y.push_back(percent[1]);
    square.x.push_back(deflection);
    square.y.push_back(0.01 * deflection * deflection);
    fmt::print("| {:g} | {:.3g} | {:.2g} | {:.2g} |\n", 1e-6 * young_Pa, deflection, percent[0],
               percent[1]);
  }
  return {.title = "Reduced against co-rotational body",
          .x_label = "largest deflection of the tip (% of the length)",
          .y_label = "distance of the tips (%)",
          .x_scale = orchestrator::AxisScale::Logarithmic,
          .y_scale = orchestrator::AxisScale::Logarithmic,
          .series = {coarse, fine, square}};
}

/// Against the body of 120 modes, at a small deflection.
orchestrator::Plot mode_plot() {
  constexpr double kYoung_Pa = 5e8;
  const TipMotion many = falling_beam("craig_bampton", kYoung_Pa, kDuration_s, 120);
  orchestrator::PlotSeries curve{.label = "to 120 modes", .x = {}, .y = {}, .markers = true};
  fmt::print("\n| modes | distance of the tips to 120 modes (% of the deflection) |\n|---|---|\n");
  for (int modes : {1, 2, 4, 8, 16, 32, 64}) {
    const TipMotion few = falling_beam("craig_bampton", kYoung_Pa, kDuration_s, modes);
    const double percent = 100.0 * largest_distance_m(many, few) / many.largest_m();
    fmt::print("| {} | {:.2g} |\n", modes, percent);
    curve.x.push_back(modes);
    curve.y.push_back(percent);
  }
  return {.title = "Number of modes",
          .x_label = "fixed-boundary modes",
          .y_label = "distance of the tips (% of the deflection)",
          .x_scale = orchestrator::AxisScale::Logarithmic,
          .y_scale = orchestrator::AxisScale::Logarithmic,
          .series = {curve}};
}

}  // namespace
}  // namespace tandem::coupled_test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: reduction SVG_FILE\n");
    return 2;
  }
  try {
    const auto deformation = tandem::coupled_test::deformation_plot();
    const auto modes = tandem::coupled_test::mode_plot();
    std::ofstream(argv[1]) << tandem::orchestrator::svg_document({deformation, modes}, 2);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "reduction: %s\n", error.what());
    return 4;
  }
  return 0;
}

// The whole run of the tracked vehicle with Figures 4 to 8 of [JC11]:
//   vehicle_figures FOLDER    writes vehicle.csv and vehicle.svg there, prints the table of
//                             docs/tracked_vehicle.md; takes half a minute

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <vector>

#include "orchestrator/page/svg_plot.h"
#include "tests/support/ancf_support.h"
#include "tests/support/beam_pair.h"

namespace tandem::coupled_test {
namespace {

using fem::ancf::testing::number;
using orchestrator::Plot;
using orchestrator::PlotSeries;

struct History {
  std::vector<double> t, x, z, vx, pin_x, pin_z, relative_x, relative_z;
  Eigen::Vector3d force_sum = Eigen::Vector3d::Zero();  ///< on the track, 0.3 s to 1 s
  Eigen::Vector3d momentum_begin = Eigen::Vector3d::Zero(), momentum_end = momentum_begin;
  int force_count = 0;
  double speed_sum = 0.0;
  int speed_count = 0;
  double weight_sum = 0.0;
  int weight_count = 0;
  double mass_kg = 0.0;
  double lateral_m = 0.0;
};

void record(const BeamPair& now, History& h) {
  const double t = now.t_s();
  const mbs::BodyState& chassis = now.body("chassis");
  const Eigen::Vector3d pin = now.fem().motion_of(now.fem().params().watch.front()).r;
  const Eigen::Vector3d ground = -now.fem().sums().ground;
  h.mass_kg = now.mass_kg();
  h.lateral_m = std::max(h.lateral_m, std::abs(chassis.p_WB.y()));
  if (std::abs(t - 0.3) < 1e-9) h.momentum_begin = now.momentum();
  if (std::abs(t - 1.0) < 1e-9) h.momentum_end = now.momentum();
  if (t > 0.3 + 1e-9 && t < 1.0 + 1e-9) {
    h.force_sum += ground;
    ++h.force_count;
  }
  if (t > 0.3) {
    h.weight_sum += ground.z();
    ++h.weight_count;
  }
  if (t > 1.0) {
    h.speed_sum += chassis.v_WB.x();
    ++h.speed_count;
  }
  if (std::lround(t * 1e4) % 50 != 0) return;
  h.t.push_back(t);
  h.x.push_back(chassis.p_WB.x());
  h.z.push_back(chassis.p_WB.z());
  h.vx.push_back(chassis.v_WB.x());
  h.pin_x.push_back(pin.x());
  h.pin_z.push_back(pin.z());
  const Eigen::Vector3d relative = chassis.q_WB.conjugate() * (pin - chassis.p_WB);
  h.relative_x.push_back(relative.x());
  h.relative_z.push_back(relative.z());
}

std::vector<double> column(const std::vector<fem::ancf::testing::Row>& rows,
                           const std::string& name) {
  std::vector<double> values;
  for (const auto& row : rows) values.push_back(number(row, name));
  return values;
}

Plot figure(const std::string& title, const std::string& x_label, const std::string& y_label,
            const std::vector<double>& x, const std::vector<double>& y,
            const std::vector<double>& reference_x, const std::vector<double>& reference_y) {
  return {.title = title,
          .x_label = x_label,
          .y_label = y_label,
          .series = {
              {.label = "Tandem", .x = x, .y = y},
              {.label = "planar reference", .x = reference_x, .y = reference_y, .dashed = true}}};
}

std::string figures(const History& h) {
  const auto rows = fem::ancf::testing::read_rows("vehicle_base_full.csv");
  const std::vector<double> t = column(rows, "t");
  return orchestrator::svg_document(
      {figure("Chassis, longitudinal (Figure 4)", "t (s)", "x (m)", h.t, h.x, t, column(rows, "x")),
       figure("Chassis, vertical (Figure 4)", "t (s)", "z (m)", h.t, h.z, t, column(rows, "z")),
       figure("Chassis velocity (Figure 5)", "t (s)", "v_x (m/s)", h.t, h.vx, t,
              column(rows, "vx")),
       figure("Pin 7, longitudinal (Figure 6)", "t (s)", "x (m)", h.t, h.pin_x, t,
              column(rows, "xn")),
       figure("Pin 7, vertical (Figure 7)", "t (s)", "z (m)", h.t, h.pin_z, t, column(rows, "zn")),
       figure("Pin 7 seen from the chassis (Figure 8)", "x (m)", "z (m)", h.relative_x,
              h.relative_z, column(rows, "xn_rel"), column(rows, "zn_rel"))},
      2);
}

void print_table(const History& h) {
  fmt::print("| t (s) | displacement (m) | reference (m) | difference (%) |\n|---|---|---|---|\n");
  for (const auto& row : fem::ancf::testing::read_rows("vehicle_base_full.csv")) {
    const double t = number(row, "t");
    const double step = std::round(t * 10.0);
    if (t < 0.4 - 1e-9 || std::abs(10.0 * t - step) > 1e-6 || std::lround(step) % 2 != 0) continue;
    const auto i = static_cast<std::size_t>(std::lround(t * 200.0));
    const double moved = h.x.at(i) - h.x.front();
    const double expected = number(row, "x") - 0.41866002;
    fmt::print("| {:.1f} | {:.5f} | {:.5f} | {:+.2f} |\n", t, moved, expected,
               100.0 * (moved / expected - 1.0));
  }
  const Eigen::Vector3d force = h.force_sum / h.force_count;
  const Eigen::Vector3d inertia = (h.momentum_end - h.momentum_begin) / 0.7;
  fmt::print("\nmean speed after 1 s: {:.4f} m/s (reference 1.9056)\n",
             h.speed_sum / h.speed_count);
  fmt::print("traction, 0.3 … 1 s: {:.2f} N, change of momentum {:.2f} N\n", force.x(),
             inertia.x());
  fmt::print("vertical force after 0.3 s: {:.1f} N, weight {:.1f} N\n",
             h.weight_sum / h.weight_count, 9.81 * h.mass_kg);
  fmt::print("farthest from the plane y = 0: {:.2g} m\n", h.lateral_m);
}

void save(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  require(out.good(), "cannot write " + file.string());
}

void run(const std::filesystem::path& folder) {
  BeamPair pair("tracked_vehicle/scenario.yaml", {});
  History history;
  const RunReport report = pair.run([&](const BeamPair& now) { record(now, history); });
  require(report.status == RunStatus::Done, report.message);
  print_table(history);
  fmt::print("{} steps in {:.1f} s, of which the flexible side {:.1f} s\n", report.macro_steps,
             report.wall_s, report.ledger.fem_compute_s);
  std::filesystem::create_directories(folder);
  std::string csv = "t_s,x_m,z_m,v_x_m_per_s,pin7_x_m,pin7_z_m,pin7_rel_x_m,pin7_rel_z_m\n";
  for (std::size_t i = 0; i < history.t.size(); ++i) {
    csv += fmt::format("{},{},{},{},{},{},{},{}\n", history.t[i], history.x[i], history.z[i],
                       history.vx[i], history.pin_x[i], history.pin_z[i], history.relative_x[i],
                       history.relative_z[i]);
  }
  save(folder / "vehicle.csv", csv);
  save(folder / "vehicle.svg", figures(history));
}

}  // namespace
}  // namespace tandem::coupled_test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: vehicle_figures FOLDER\n");
    return 2;
  }
  try {
    tandem::coupled_test::run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}

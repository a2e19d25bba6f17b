#include "tests/support/truth_case.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "protocol/contract/error.h"

namespace tandem::coupled_test {
namespace {

std::filesystem::path data_file(const std::string& name) {
  return std::filesystem::path(TANDEM_SOURCE_DIR) / "tests/data/coupled" / name;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

std::ifstream open(const std::filesystem::path& file) {
  std::ifstream stream(file);
  require(stream.good(), file.string() + ": cannot be read");
  return stream;
}

Quantity vector_of(const std::string& name, const std::string& prefix,
                   const std::vector<std::string>& components) {
  Quantity quantity{.name = name};
  for (const std::string& component : components) quantity.columns.push_back(prefix + component);
  return quantity;
}

void append(std::vector<double>& row, const Eigen::Vector3d& v) {
  row.insert(row.end(), {v.x(), v.y(), v.z()});
}

/// hub_angle … hub_Mz of the reference file. The port frame is the hub's own.
std::vector<double> pendulum_row(const CoupledPair& pair, const Sample& sample) {
  const Motion& hub = sample.motions.at(0);
  const fem::MeanMotion tip = pair.fem().mean_motion("tip");
  const Eigen::Vector3d tip_start = tip.position_m - tip.displacement_m;
  const mbs::Params& params = pair.mbs().params();
  const Eigen::Vector3d arm_start = tip_start - params.bodies.at(0).p_WB;
  std::vector<double> row{sample.t_s, pair.mbs().state().joint_coordinates.at(0)[0], hub.w_WP.y()};
  append(row, tip.position_m);
  append(row, tip.velocity_m_per_s);
  append(row, hub.q_WP.conjugate() * (tip.position_m - hub.p_WP) - arm_start);
  append(row, -sample.wrenches.at(0).f_P_W);
  append(row, -sample.wrenches.at(0).t_P_W);
  return row;
}

/// left_x … right_Mz, distance of the reference file. The port frames are the bodies' own.
std::vector<double> two_masses_row(const Sample& sample) {
  std::vector<double> row{sample.t_s};
  for (std::size_t port = 0; port < 2; ++port) {
    const Motion& m = sample.motions.at(port);
    append(row, m.p_WP);
    row.insert(row.end(), {m.q_WP.w(), m.q_WP.x(), m.q_WP.y(), m.q_WP.z()});
    append(row, m.v_WP);
    append(row, m.w_WP);
    append(row, -sample.wrenches.at(port).f_P_W);
    append(row, -sample.wrenches.at(port).t_P_W);
  }
  row.push_back((sample.motions[1].p_WP - sample.motions[0].p_WP).norm());
  return row;
}

double distance(const Quantity& quantity, const Trajectory& table, const std::vector<double>& a,
                const std::vector<double>& b) {
  double minus = 0.0;
  double plus = 0.0;
  for (const std::string& name : quantity.columns) {
    const std::size_t i = table.column(name);
    minus += (a[i] - b[i]) * (a[i] - b[i]);
    plus += (a[i] + b[i]) * (a[i] + b[i]);
  }
  return std::sqrt(quantity.is_quaternion ? std::min(minus, plus) : minus);
}

}  // namespace

std::size_t Trajectory::column(const std::string& name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  require(found != columns.end(), "no column '" + name + "'");
  return static_cast<std::size_t>(found - columns.begin());
}

Trajectory read_trajectory(const std::filesystem::path& file) {
  std::ifstream stream = open(file);
  Trajectory trajectory;
  std::string line;
  std::getline(stream, line);
  trajectory.columns = split(line);
  while (std::getline(stream, line)) {
    std::vector<double>& row = trajectory.rows.emplace_back();
    for (const std::string& cell : split(line)) row.push_back(std::stod(cell));
    require(row.size() == trajectory.columns.size(), file.string() + ": a row of another length");
  }
  return trajectory;
}

TruthCase pendulum_beam() {
  TruthCase truth{.name = "pendulum_beam", .scenario = "pendulum_beam/scenario.yaml"};
  for (const char* name : {"hub_angle", "hub_omega", "defl_axial", "defl_y", "defl_n"}) {
    truth.quantities.push_back({.name = name, .columns = {name}});
  }
  truth.quantities.push_back(vector_of("tip_pos", "tip_", {"x", "y", "z"}));
  truth.quantities.push_back(vector_of("tip_vel", "tip_", {"vx", "vy", "vz"}));
  truth.quantities.push_back(vector_of("hub_F", "hub_", {"Fx", "Fy", "Fz"}));
  truth.quantities.push_back(vector_of("hub_M", "hub_", {"Mx", "My", "Mz"}));
  return truth;
}

TruthCase pendulum_beam_damped() {
  TruthCase truth = pendulum_beam();
  truth.name = "pendulum_beam_damped";
  truth.overrides = {{"fem.damping.beta_s", "0.002"}};
  return truth;
}

TruthCase two_masses() {
  TruthCase truth{.name = "two_masses",
                  .scenario = "two_masses/scenario.yaml",
                  .overrides = {{"run.duration_s", "0.1"}}};
  for (const std::string side : {"left", "right"}) {
    const std::string prefix = side + "_";
    truth.quantities.push_back(vector_of(prefix + "pos", prefix, {"x", "y", "z"}));
    truth.quantities.push_back(vector_of(prefix + "quat", prefix, {"qw", "qx", "qy", "qz"}));
    truth.quantities.back().is_quaternion = true;
    truth.quantities.push_back(vector_of(prefix + "vel", prefix, {"vx", "vy", "vz"}));
    truth.quantities.push_back(vector_of(prefix + "omega", prefix, {"wx", "wy", "wz"}));
    truth.quantities.push_back(vector_of(prefix + "F", prefix, {"Fx", "Fy", "Fz"}));
    truth.quantities.push_back(vector_of(prefix + "M", prefix, {"Mx", "My", "Mz"}));
  }
  truth.quantities.push_back({.name = "distance", .columns = {"distance"}});
  return truth;
}

Trajectory reference_of(const TruthCase& truth) {
  return read_trajectory(data_file(truth.name + ".csv"));
}

Trajectory monolithic_trajectory(const TruthCase& truth, double h_s) {
  return trajectory(truth, h_s, orchestrator::Mode::Monolithic, reference_of(truth));
}

Trajectory trajectory(const TruthCase& truth, double h_s, orchestrator::Mode mode,
                      const Trajectory& reference) {
  CoupledPair::Overrides overrides = truth.overrides;
  overrides.push_back({"run.macro_step_s", text_of(h_s)});
  CoupledPair pair(truth.scenario, overrides);
  Trajectory run{.columns = reference.columns};
  const RunReport report = pair.run(mode, [&](const Sample& sample) {
    if (run.rows.size() == reference.rows.size()) return;
    if (std::abs(sample.t_s - reference.rows[run.rows.size()][0]) > 1e-9) return;
    run.rows.push_back(sample.motions.size() == 1 ? pendulum_row(pair, sample)
                                                  : two_masses_row(sample));
  });
  require(report.status == RunStatus::Done, truth.name + ": " + report.message);
  require(run.rows.size() == reference.rows.size(), truth.name + ": sample times were missed");
  return run;
}

Trajectory beginning_of(Trajectory trajectory, double end_s) {
  std::erase_if(trajectory.rows,
                [&](const std::vector<double>& row) { return row[0] > end_s + 1e-9; });
  return trajectory;
}

std::map<std::string, double> largest_errors(const TruthCase& truth, const Trajectory& run,
                                             const Trajectory& reference) {
  std::map<std::string, double> errors;
  for (const Quantity& quantity : truth.quantities) {
    double& error = errors[quantity.name];
    for (std::size_t n = 1; n < reference.rows.size(); ++n) {
      error = std::max(error, distance(quantity, reference, run.rows[n], reference.rows[n]));
    }
  }
  return errors;
}

ListedErrors listed_errors(const TruthCase& truth) {
  std::ifstream stream = open(data_file("first_order_errors.csv"));
  std::string line;
  std::getline(stream, line);
  // case, quantity, unit, span, then one column per step: max_error_h_<step>.
  const std::string prefix = "max_error_h_";
  ListedErrors listed;
  for (const std::string& name : split(line)) {
    if (name.starts_with(prefix)) listed.steps_s.push_back(std::stod(name.substr(prefix.size())));
  }
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = split(line);
    if (cells.at(0) != truth.name) continue;
    for (std::size_t i = 4; i < cells.size(); ++i) {
      listed.errors[cells[1]].push_back(std::stod(cells[i]));
    }
  }
  return listed;
}

}  // namespace tandem::coupled_test

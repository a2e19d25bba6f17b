#include "protocol/driver/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "protocol/contract/quantile.h"

namespace tandem {
namespace {

using nlohmann::ordered_json;

ordered_json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json ports_json(const RunReport& report) {
  ordered_json ports = ordered_json::object();
  for (std::size_t i = 0; i < report.motions.size(); ++i) {
    const Motion& m = report.motions[i];
    const Wrench& w = report.wrenches[i];
    ports[report.port_names[i]] = {{"p_WP_m", vector_json(m.p_WP)},
                                   {"q_WP_wxyz", {m.q_WP.w(), m.q_WP.x(), m.q_WP.y(), m.q_WP.z()}},
                                   {"v_WP_m_per_s", vector_json(m.v_WP)},
                                   {"w_WP_rad_per_s", vector_json(m.w_WP)},
                                   {"f_P_W_N", vector_json(w.f_P_W)},
                                   {"t_P_W_Nm", vector_json(w.t_P_W)}};
  }
  return ports;
}

ordered_json ledger_json(const Ledger& l) {
  return {{"mbs_compute", l.mbs_compute_s},
          {"fem_compute", l.fem_compute_s},
          {"encode", l.encode_s},
          {"decode", l.decode_s},
          {"publish", l.publish_s},
          {"transit", l.transit_s},
          {"wait", l.wait_s},
          {"scheme", l.scheme_s},
          {"record", l.record_s},
          {"other", l.other_s},
          {"overlap", l.overlap_s},
          {"discarded", l.discarded_s}};
}

/// What was booked from `a` to `b`, and the energies at `b`.
ordered_json book_json(const EnergyBook& a, const EnergyBook& b) {
  return {{"kinetic", b.kinetic_J},
          {"potential", b.potential_J},
          {"elastic", b.elastic_J},
          {"total_start", a.total_J()},
          {"total_end", b.total_J()},
          {"external_work", b.external_work_J - a.external_work_J},
          {"interface_work", b.interface_work_J - a.interface_work_J},
          {"damping", b.damping_loss_J - a.damping_loss_J},
          {"numerical", b.numerical_loss_J - a.numerical_loss_J},
          {"balance_error", balance_error_J(a, b)}};
}

ordered_json energy_json(const RunReport& r) {
  ordered_json json = {{"interface_defect_max", r.interface_defect_max_J},
                       {"interface_defect_sum", r.interface_defect_sum_J},
                       {"exchanged_work", r.exchanged_work_J}};
  if (r.broken_off) return json;
  const EnergyBook a = r.energy_start.sum();
  const EnergyBook b = r.energy_end.sum();
  json["total_start"] = a.total_J();
  json["total_end"] = b.total_J();
  json["external_work"] = b.external_work_J - a.external_work_J;
  json["interface_work"] = b.interface_work_J - a.interface_work_J;
  json["dissipated"] = b.dissipated_J() - a.dissipated_J();
  json["damping"] = b.damping_loss_J - a.damping_loss_J;
  json["numerical"] = b.numerical_loss_J - a.numerical_loss_J;
  json["balance_error"] = balance_error_J(a, b);
  const EnergyRange& range = r.energy_range;
  json["held_max"] = range.held_J;
  json["external_work_max"] = range.external_work_J;
  json["potential_change_max"] = range.potential_change_J;
  json["given"] = range.given_J();
  json["lost_by_steps"] = lost_by_steps_J(a, b, r.parasitic_mass_kg.has_value());
  json["lost_by_steps_max"] = range.lost_J;
  json["made_by_steps_max"] = range.made_J;
  json["balance_error_max"] = range.balance_error_J;
  json["still"] = r.still_J;
  json["mbs"] = book_json(r.energy_start.mbs, r.energy_end.mbs);
  json["fem"] = book_json(r.energy_start.fem, r.energy_end.fem);
  return json;
}

/// Of several flexible bodies, or worlds: which one computes how long, and its own book.
ordered_json parts_json(const std::vector<BodyObservation>& start,
                        const std::vector<BodyObservation>& end) {
  ordered_json json;
  for (std::size_t b = 0; b < end.size(); ++b) {
    json[end[b].name] = {{"compute_s", end[b].compute_s},
                         {"solver_iterations", end[b].solver_iterations},
                         {"state_hash", fmt::format("{:016x}", end[b].state_hash)},
                         {"energy_J", book_json(start[b].energy, end[b].energy)}};
  }
  return json;
}

double transfer_s(const Ledger& l) { return l.encode_s + l.decode_s + l.publish_s + l.transit_s; }

}  // namespace

void RunReport::book(const wire::StepRecord& step) {
  iterations_total += step.iterations;
  iterations_max = std::max<std::int64_t>(iterations_max, step.iterations);
  not_converged_steps += step.outcome == Outcome::NotConverged ? 1 : 0;
  exchange_us.push_back(1e6 * transfer_s(step.ledger) / std::max(1, step.iterations));
}

void RunReport::book_turn(SimTime H, const MotionSet& begin, const MotionSet& end) {
  largest_step = std::max(largest_step, H);
  for (std::size_t i = 0; i < end.size(); ++i) {
    const double turn_rad = to_seconds(H) * std::max(begin[i].w_WP.norm(), end[i].w_WP.norm());
    if (!(turn_rad > largest_turn_rad)) continue;
    largest_turn_rad = turn_rad;
    turning_port = port_names[i];
  }
}

void RunReport::book_interface(double defect_J, double exchanged_J) {
  interface_defect_max_J = std::max(interface_defect_max_J, std::abs(defect_J));
  interface_defect_sum_J += defect_J;
  exchanged_work_J += exchanged_J;
}

std::string to_string(RunStatus status) {
  switch (status) {
    case RunStatus::Done:
      return "done";
    case RunStatus::NotConverged:
      return "not_converged";
    case RunStatus::Diverged:
      return "diverged";
    case RunStatus::SolverFailed:
      return "solver_failed";
  }
  return "unknown";
}

ordered_json to_json(const RunReport& r) {
  std::vector<double> exchange_us = r.exchange_us;
  std::sort(exchange_us.begin(), exchange_us.end());
  const double simulated_s = to_seconds(r.simulated);
  ordered_json json;
  json["scheme"] = r.scheme;
  json["status"] = to_string(r.status);
  json["message"] = r.message;
  json["macro_steps"] = r.macro_steps;
  json["simulated_s"] = simulated_s;
  json["wall_s"] = r.wall_s;
  json["realtime_ratio"] = r.wall_s > 0.0 ? simulated_s / r.wall_s : 0.0;
  json["iterations"] = {{"total", r.iterations_total},
                        {"mean", r.macro_steps > 0 ? static_cast<double>(r.iterations_total) /
                                                         static_cast<double>(r.macro_steps)
                                                   : 0.0},
                        {"max", r.iterations_max}};
  json["not_converged_steps"] = r.not_converged_steps;
  if (!r.broken_off) {
    json["rejected_steps"] = r.rejected_steps;
    json["steps_beyond_tolerance"] = r.steps_beyond_tolerance;
    json["steps_out_of_budget"] = r.steps_out_of_budget;
    json["not_converged_message"] = r.not_converged_message;
    json["largest_step_s"] = to_seconds(r.largest_step);
    json["largest_turn"] = {{"rad", r.largest_turn_rad}, {"port", r.turning_port}};
    json["elastic_turn_rad"] = r.elastic_turn_rad;
    json["residual"] = {
        {"largest_N", r.residual_max_N},
        {"part_of_wrench", r.wrench_max_N > 0.0 ? r.residual_max_N / r.wrench_max_N : 0.0}};
    json["widest_joint"] = {{"gap_m", r.widest_joint.gap_m},
                            {"part_of_arm", r.widest_joint.part},
                            {"joint", r.widest_joint.joint}};
    if (!r.worlds_end.empty()) json["widest_joint"]["world"] = r.widest_joint.world;
  }
  if (r.pace.active()) json["pace"] = to_json(r.pace, r.largest_step);
  if (r.parasitic_mass_kg) json["parasitic_mass_kg"] = *r.parasitic_mass_kg;
  json["ledger_s"] = ledger_json(r.ledger);
  json["wire"] = {{"messages", r.ledger.messages},
                  {"bytes", r.ledger.bytes},
                  {"resent", r.ledger.resent},
                  {"duplicates", r.ledger.duplicates},
                  {"lost", r.ledger.lost}};
  json["exchange_us"] = {{"median", quantile(exchange_us, 0.5)},
                         {"p90", quantile(exchange_us, 0.9)},
                         {"p99", quantile(exchange_us, 0.99)},
                         {"max", quantile(exchange_us, 1.0)}};
  json["energy_J"] = energy_json(r);
  if (!r.broken_off && !r.worlds_end.empty()) {
    json["worlds"] = parts_json(r.worlds_start, r.worlds_end);
  }
  if (!r.broken_off && !r.bodies_end.empty()) {
    json["bodies"] = parts_json(r.bodies_start, r.bodies_end);
  }
  if (!r.broken_off) json["state_hash"] = fmt::format("{:016x}", r.state_hash);
  json["ports"] = ports_json(r);
  return json;
}

}  // namespace tandem

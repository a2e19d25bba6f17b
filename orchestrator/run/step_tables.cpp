#include "orchestrator/run/step_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <utility>

namespace tandem::orchestrator {
namespace {

constexpr const char* kStepsHeader =
    "macro_step,t_s,H_s,iterations,outcome,residual_N,energy_defect_J,mbs_compute_s,fem_compute_s,"
    "encode_s,decode_s,publish_s,transit_s,wait_s,scheme_s,record_s,other_s,overlap_s,discarded_s,"
    "messages,bytes,resent,duplicates,lost\n";

const char* text_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::Done:
      return "done";
    case Outcome::NotConverged:
      return "not_converged";
    case Outcome::Failed:
      return "failed";
  }
  return "unknown";
}

std::string step_row(const wire::StepRecord& step) {
  const Ledger& l = step.ledger;
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                     step.macro_step, to_seconds(step.time), to_seconds(step.step), step.iterations,
                     text_of(step.outcome), step.residual_N, step.energy_defect_J, l.mbs_compute_s,
                     l.fem_compute_s, l.encode_s, l.decode_s, l.publish_s, l.transit_s, l.wait_s,
                     l.scheme_s, l.record_s, l.other_s, l.overlap_s, l.discarded_s, l.messages,
                     l.bytes, l.resent, l.duplicates, l.lost);
}

}  // namespace

StepTables::StepTables(const std::filesystem::path& directory,
                       const std::vector<std::string>& ports, std::vector<std::string> parts)
    : steps_(directory / "steps.csv"),
      ports_(directory / "ports.csv"),
      energy_(directory, std::move(parts)) {
  steps_.write(kStepsHeader);
  ports_.write(interface_header(ports));
  flush();  // a run that is killed early leaves tables without rows, and no empty files
}

void StepTables::write(const wire::StepJournal& journal) {
  if (journal.step.macro_step > 0) steps_.write(step_row(journal.step));
  const AcceptedInterface interface = accepted_interface(journal);
  if (!interface.motions.empty()) ports_.write(interface_row(interface));
  energy_.write(journal.step);
}

void StepTables::flush() {
  steps_.flush();
  ports_.flush();
  energy_.flush();
}

AcceptedInterface accepted_interface(const wire::StepJournal& journal) {
  AcceptedInterface interface { .time = journal.step.time };
  if (journal.step.outcome == Outcome::Failed) return interface;
  for (const wire::CallRecord& call : journal.calls) {
    if (!call.accepted) continue;
    if (call.side == wire::SideName::Mbs) interface.motions = call.motions.end;
    if (call.side == wire::SideName::Fem) interface.wrenches = call.wrenches.end;
  }
  if (interface.motions.size() != interface.wrenches.size()) return {};
  return interface;
}

std::string interface_header(const std::vector<std::string>& ports) {
  std::string header = "t_s";
  for (const std::string& port : ports) {
    for (const char* column :
         {"p_x_m", "p_y_m", "p_z_m", "q_w", "q_x", "q_y", "q_z", "v_x_m_per_s", "v_y_m_per_s",
          "v_z_m_per_s", "w_x_rad_per_s", "w_y_rad_per_s", "w_z_rad_per_s", "f_x_N", "f_y_N",
          "f_z_N", "t_x_Nm", "t_y_Nm", "t_z_Nm"}) {
      header += fmt::format(",{}.{}", port, column);
    }
  }
  return header + "\n";
}

std::string interface_row(const AcceptedInterface& interface) {
  std::string row = fmt::format("{}", to_seconds(interface.time));
  const auto append = [&row](const auto& values) {
    for (double value : values) fmt::format_to(std::back_inserter(row), ",{}", value);
  };
  const auto append_motion = [&append](const Motion& m) {
    append(m.p_WP);
    append(std::initializer_list<double>{m.q_WP.w(), m.q_WP.x(), m.q_WP.y(), m.q_WP.z()});
    append(m.v_WP);
    append(m.w_WP);
  };
  // A call of one side may have failed before it had an output.
  const std::size_t ports = std::max(interface.motions.size(), interface.wrenches.size());
  const std::string no_motion(13, ',');
  const std::string no_wrench(6, ',');
  for (std::size_t i = 0; i < ports; ++i) {
    if (i >= interface.motions.size()) {
      row += no_motion;
    } else {
      append_motion(interface.motions[i]);
    }
    if (i >= interface.wrenches.size()) {
      row += no_wrench;
      continue;
    }
    append(interface.wrenches[i].f_P_W);
    append(interface.wrenches[i].t_P_W);
  }
  return row + "\n";
}

}  // namespace tandem::orchestrator

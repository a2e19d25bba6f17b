#include "orchestrator/verdict/run_books.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "mbs_process/make_side.h"
#include "orchestrator/files/summary_number.h"
#include "orchestrator/verdict/body_rates.h"

namespace tandem::orchestrator {
namespace {

using nlohmann::ordered_json;

bool has_contact(const scenario::Node& fem) {
  const scenario::Node ancf = fem.section("ancf");
  return (ancf.has("wheels") && !ancf.list("wheels").empty()) ||
         (ancf.has("grounds") && !ancf.list("grounds").empty());
}

std::vector<std::string> port_bodies(const Model& model) {
  std::vector<std::string> bodies;
  for (const scenario::PortParams& port : scenario::read_ports(model.scenario.root)) {
    bodies.push_back(port.body);
  }
  return bodies;
}

double lightest_kg(const Model& model, const std::vector<std::string>& names) {
  double lightest = std::numeric_limits<double>::infinity();
  for (const scenario::Node& mbs : mbs_sections(model)) {
    if (!mbs.has("bodies")) continue;
    for (const scenario::Node& body : mbs.list("bodies")) {
      if (std::find(names.begin(), names.end(), body.text("name")) == names.end()) continue;
      lightest = std::min(lightest, body.real("mass_kg"));
    }
  }
  return lightest == std::numeric_limits<double>::infinity() ? 0.0 : lightest;
}

void add_energies(const ordered_json& energy, RunBooks& books) {
  books.held_J = number_at(energy, "held_max");
  books.external_work_J = number_at(energy, "external_work_max");
  books.potential_change_J = number_at(energy, "potential_change_max");
  books.still_J = number_at(energy, "still");
  books.given_J = number_at(energy, "given");
  books.exchanged_J = number_at(energy, "exchanged_work");
  books.lost_J = number_at(energy, "lost_by_steps");
  books.lost_max_J = number_at(energy, "lost_by_steps_max");
  books.made_max_J = number_at(energy, "made_by_steps_max");
  books.balance_error_J = number_at(energy, "balance_error");
  books.balance_error_max_J = number_at(energy, "balance_error_max");
}

/// Ports have been followed at every step; bodies without one are in the table of the bodies.
void add_turn(const Model& model, const std::filesystem::path& folder, RunBooks& books) {
  BodyTurn found;
  for (const scenario::MultibodyWorld& world : model.worlds) {
    const auto own = mbs::folder_of(folder, world.root, model.worlds.size());
    const BodyTurn turn = fastest_body(own / "bodies.csv", port_bodies(model));
    found.turn_between_rows_rad = std::max(found.turn_between_rows_rad, turn.turn_between_rows_rad);
    if (!(turn.rate_rad_per_s > found.rate_rad_per_s)) continue;
    found.rate_rad_per_s = turn.rate_rad_per_s;
    found.body = turn.body;
  }
  const std::int64_t every = scenario::read_output(model.scenario.root).bodies_every_steps;
  const double turn_rad = books.adaptive ? found.turn_between_rows_rad /
                                               static_cast<double>(std::max<std::int64_t>(1, every))
                                         : found.rate_rad_per_s * books.largest_step_s;
  if (!(turn_rad > books.largest_turn_rad)) return;
  books.largest_turn_rad = turn_rad;
  books.turning = "body '" + found.body + "'";
}

void add_gap(const Model& model, const ordered_json& widest, RunBooks& books) {
  const auto joint = widest.at("joint").get<std::int64_t>();
  if (joint < 0) return;
  books.joint_gap_m = number_at(widest, "gap_m");
  books.joint_gap_part = number_at(widest, "part_of_arm");
  const auto world = widest.value("world", std::int64_t{0});
  const scenario::Node mbs = mbs_sections(model).at(static_cast<std::size_t>(world));
  books.open_joint = mbs.list("joints").at(static_cast<std::size_t>(joint)).text("name");
}

void add_pace(const ordered_json& pace, RunBooks& books) {
  books.paced_steps = pace.at("steps").get<std::int64_t>();
  books.missed_steps = pace.at("misses").get<std::int64_t>();
  std::int64_t most = 0;
  for (const auto& [part, steps] : pace.at("missed_by").items()) {
    if (steps.get<std::int64_t>() <= most) continue;
    most = steps.get<std::int64_t>();
    books.missed_by = part;
  }
}

}  // namespace

bool is_second_order(const scenario::Node& fem) {
  if (fem.text("model") == "ancf") return true;
  const scenario::Node integrator = fem.section("integrator");
  const std::string kind = integrator.text("kind");
  return kind == "newmark" ? integrator.real("newmark_gamma") == 0.5 : kind != "backward_euler";
}

namespace {

/// A run is of first order where one body is; what any body has, the run has.
void add_body(const scenario::Node& fem, RunBooks& books) {
  books.fem_second_order = books.fem_second_order && is_second_order(fem);
  if (fem.text("model") == "ancf") {
    books.contact = books.contact || has_contact(fem);
    return;
  }
  const scenario::Node integrator = fem.section("integrator");
  const bool reduced = fem.text("formulation") == "craig_bampton";
  if (reduced && !books.reduced) books.reduced_key = fem.path_name();
  books.reduced = books.reduced || reduced;
  const bool linearised = !reduced && integrator.text("kind") != "quasi_static" &&
                          integrator.integer("newton_steps") == 0;
  if (linearised && !books.linearised) books.linearised_key = fem.path_name();
  books.linearised = books.linearised || linearised;
}

}  // namespace

RunBooks books_of_model(const Model& model, bool monolithic) {
  RunBooks books;
  const SchemeKind scheme = model.coupling.scheme;
  books.explicit_scheme = !monolithic && (scheme == SchemeKind::ExplicitSerial ||
                                          scheme == SchemeKind::ExplicitParallel);
  books.adaptive = model.coupling.adaptive.active();
  books.mbs_second_order = true;
  for (const scenario::Node& mbs : mbs_sections(model)) {
    books.mbs_second_order = books.mbs_second_order && mbs.text("integrator") != "euler";
  }
  books.fem_second_order = true;
  for (const scenario::FlexibleBody& body : model.bodies) add_body(body.root.section("fem"), books);
  books.lightest_port_body_kg = lightest_kg(model, port_bodies(model));
  return books;
}

RunBooks books_of_run(const Model& model, bool monolithic, const ordered_json& summary,
                      const std::filesystem::path& folder) {
  RunBooks books = books_of_model(model, monolithic);
  add_energies(summary.at("energy_J"), books);
  books.macro_steps = summary.at("macro_steps").get<std::int64_t>();
  books.not_converged_steps = summary.at("not_converged_steps").get<std::int64_t>();
  books.not_converged_message = summary.at("not_converged_message").get<std::string>();
  books.steps_beyond_tolerance = summary.at("steps_beyond_tolerance").get<std::int64_t>();
  if (summary.contains("parasitic_mass_kg")) {
    books.parasitic_mass_kg = number_at(summary, "parasitic_mass_kg");
  }
  books.residual_part = number_at(summary.at("residual"), "part_of_wrench");
  books.steps_out_of_budget = summary.at("steps_out_of_budget").get<std::int64_t>();
  if (summary.contains("pace")) add_pace(summary.at("pace"), books);
  books.accuracy = model.scenario.root.section("run").real("accuracy");
  books.largest_step_s = number_at(summary, "largest_step_s");
  books.elastic_turn_rad = number_at(summary, "elastic_turn_rad");
  const ordered_json& turn = summary.at("largest_turn");
  books.largest_turn_rad = number_at(turn, "rad");
  books.turning = "port '" + turn.at("port").get<std::string>() + "'";
  add_turn(model, folder, books);
  add_gap(model, summary.at("widest_joint"), books);
  return books;
}

BooksOfOneSide::BooksOfOneSide(FemSide& side, std::int64_t steps)
    : side_(side), every_(std::max<std::int64_t>(1, steps / 64)), begin_(book()) {}

EnergyBook BooksOfOneSide::book() {
  EnergyBook book = side_.observe().energy;
  book.external_work_J += std::exchange(book.interface_work_J, 0.0);
  return book;
}

void BooksOfOneSide::look(std::int64_t step) {
  if (step % every_ == 0) range_.book(begin_, book(), true);
}

void BooksOfOneSide::add_to(RunBooks& books) {
  const EnergyBook end = book();
  range_.book(begin_, end, true);
  books.coupled = false;
  books.held_J = range_.held_J;
  books.external_work_J = range_.external_work_J;
  books.potential_change_J = range_.potential_change_J;
  books.given_J = range_.given_J();
  books.lost_J = lost_by_steps_J(begin_, end, true);
  books.lost_max_J = range_.lost_J;
  books.made_max_J = range_.made_J;
  books.balance_error_J = balance_error_J(begin_, end);
  books.balance_error_max_J = range_.balance_error_J;
}

}  // namespace tandem::orchestrator

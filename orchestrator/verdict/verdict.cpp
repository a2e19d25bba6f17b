#include "orchestrator/verdict/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tandem::orchestrator {
namespace {

using Limits = VerdictLimits;

/// Nothing is no part of nothing; what is no number is no small part either.
double part_of(double value, double scale) {
  if (value == 0.0) return 0.0;
  return scale > 0.0 ? value / scale : std::copysign(INFINITY, value);
}

/// True for NaN, too.
bool exceeds(double value, double limit) { return !(value <= limit); }

std::string percent(double part) {
  const double value = 100.0 * part;
  return std::abs(value) < 10.0 ? fmt::format("{:.2g} %", value) : fmt::format("{:.0f} %", value);
}

std::string step_key(const RunBooks& books) {
  return books.adaptive ? "coupling.adaptive.tolerance (or max_step_s)" : "run.macro_step_s";
}

/// Both sides' integrators as they have to be for order 2, as far as they are not.
std::string second_order_keys(const RunBooks& books) {
  std::string keys;
  if (books.coupled && !books.mbs_second_order) keys += "mbs.integrator: verlet";
  if (!books.fem_second_order) {
    keys += keys.empty() ? "" : " with ";
    keys += books.first_order_key + ".integrator.kind: generalised_alpha";
  }
  return keys;
}

std::string loss_remedy(const RunBooks& books) {
  std::string remedy = "lower " + step_key(books);
  const std::string keys = second_order_keys(books);
  if (!keys.empty()) remedy += " (half the step, half the loss) or set " + keys;
  if (books.reduced) {
    remedy +=
        ", or use the full body instead of " + books.reduced_key + ".formulation: craig_bampton";
  }
  return remedy + ".";
}

std::string growth_remedy(const RunBooks& books) {
  std::string remedy = "lower " + step_key(books);
  if (books.explicit_scheme) remedy = "use coupling.scheme: interface_jacobian, or " + remedy;
  if (books.coupled && books.mbs_second_order != books.fem_second_order) {
    remedy += ", or set " + second_order_keys(books) + " (the sides' orders differ)";
  }
  return remedy + ".";
}

std::string balance_remedy(const RunBooks& books) {
  std::string remedy = "lower " + step_key(books);
  if (books.contact) remedy += ", or soften fem.ancf.contact";
  if (books.linearised)
    remedy += ", or iterate the step: " + books.linearised_key + ".integrator.newton_steps: 20";
  return remedy + ".";
}

std::string budget_of(const RunBooks& books) {
  if (books.steps_out_of_budget == 0) return "";
  return fmt::format(" ({} of {} macro steps ended by coupling.max_evaluations)",
                     books.steps_out_of_budget, books.macro_steps);
}

void judge_pace(const RunBooks& books, std::vector<Cause>& causes) {
  const double missed =
      part_of(static_cast<double>(books.missed_steps), static_cast<double>(books.paced_steps));
  if (!exceeds(missed, Limits::kMissed)) return;
  causes.push_back({.name = "pace",
                    .value = missed,
                    .threshold = Limits::kMissed,
                    .text = fmt::format("{} of {} macro steps were not done when they were due, "
                                        "most of them for {}",
                                        books.missed_steps, books.paced_steps, books.missed_by),
                    .remedy = "bound a step by coupling.max_evaluations and fem.solver."
                              "max_iterations, raise run.macro_step_s, or lower run.pace."});
}

void judge_steps(const RunBooks& books, std::vector<Cause>& causes) {
  if (books.not_converged_steps > 0) {
    const std::string& said = books.not_converged_message;
    causes.push_back({.name = "not_converged_steps",
                      .value = static_cast<double>(books.not_converged_steps),
                      .threshold = 0.0,
                      .text = fmt::format("{} of {} macro step(s) NOT converged, and accepted as "
                                          "coupling.on_not_converged says",
                                          books.not_converged_steps, books.macro_steps),
                      .remedy = said.empty() ? "lower " + step_key(books) + "." : said});
  }
  if (books.not_converged_steps == 0 && exceeds(books.residual_part, books.accuracy)) {
    causes.push_back(
        {.name = "residual",
         .value = books.residual_part,
         .threshold = books.accuracy,
         .text =
             fmt::format("the iterations have left {:.2g} of the largest wrench in a macro step, "
                         "where run.accuracy is {:g}{}",
                         books.residual_part, books.accuracy, budget_of(books)),
         .remedy = books.steps_out_of_budget > 0
                       ? "raise coupling.max_evaluations, or say that it is enough by run.accuracy."
                       : "lower fem.solver.tolerance or use fem.solver.kind: cholmod, and lower "
                         "coupling.relative_tolerance and tolerance_N where they are set; or say "
                         "that it is enough by run.accuracy."});
  }
  if (books.steps_beyond_tolerance > 0) {
    causes.push_back(
        {.name = "steps_beyond_tolerance",
         .value = static_cast<double>(books.steps_beyond_tolerance),
         .threshold = 0.0,
         .text = fmt::format("{} of {} macro step(s) beyond coupling.adaptive.tolerance: they were "
                             "the shortest",
                             books.steps_beyond_tolerance, books.macro_steps),
         .remedy = "lower coupling.adaptive.min_step_s, or raise the tolerance."});
  }
}

void judge_energy(const RunBooks& books, double scale_J, std::vector<Cause>& causes) {
  const double given_J = std::max(books.given_J, books.still_J);
  const double made = part_of(books.made_max_J, given_J);
  if (exceeds(made, Limits::kMade)) {
    causes.push_back(
        {.name = "energy_growth",
         .value = made,
         .threshold = Limits::kMade,
         .text = fmt::format("the steps made {:.3g} J, {} of the {:.3g} J that the run "
                             "began with and was given",
                             books.made_max_J, percent(made), given_J),
         .remedy = growth_remedy(books)});
  }
  const double lost = part_of(books.lost_max_J, scale_J);
  if (exceeds(lost, Limits::kLost)) {
    causes.push_back({.name = "numerical_loss",
                      .value = lost,
                      .threshold = Limits::kLost,
                      .text = fmt::format("{} of the energy was lost numerically ({:.3g} of {:.3g} "
                                          "J)",
                                          percent(lost), books.lost_max_J, scale_J),
                      .remedy = loss_remedy(books)});
  }
  const double missing = part_of(books.balance_error_max_J, scale_J);
  if (exceeds(missing, Limits::kBalanceError)) {
    const std::string begun = books.contact ? ", of contacts that begin or end within a step" : "";
    causes.push_back(
        {.name = books.contact ? "contact" : "balance_error",
         .value = missing,
         .threshold = Limits::kBalanceError,
         .text = fmt::format("the energy balance is off by {:.3g} J, {} of {:.3g} J{}",
                             books.balance_error_max_J, percent(missing), scale_J, begun),
         .remedy = balance_remedy(books)});
  }
}

void judge_model(const RunBooks& books, std::vector<Cause>& causes) {
  if (exceeds(books.largest_turn_rad, Limits::kTurn_rad * (1.0 + 1e-9))) {
    const double step_s = books.largest_step_s * Limits::kTurn_rad / books.largest_turn_rad;
    causes.push_back(
        {.name = "turn_per_step",
         .value = books.largest_turn_rad,
         .threshold = Limits::kTurn_rad,
         .text = fmt::format("{} turns by up to {:.3g} rad in a macro step", books.turning,
                             books.largest_turn_rad),
         .remedy = fmt::format("lower {} to {:.2g} s or less.",
                               books.adaptive ? "coupling.adaptive.max_step_s" : "run.macro_step_s",
                               step_s)});
  }
  if (exceeds(books.joint_gap_part, Limits::kJointGap)) {
    causes.push_back(
        {.name = "joint_gap",
         .value = books.joint_gap_part,
         .threshold = Limits::kJointGap,
         .text = fmt::format("joint '{}' came apart by up to {:.3g} m, {} of its arm",
                             books.open_joint, books.joint_gap_m, percent(books.joint_gap_part)),
         .remedy = "lower mbs.micro_step_s or run.macro_step_s (half the step, a quarter of the "
                   "gap), or raise mbs.erp; a joint made soft by mbs.cfm gives way."});
  }
  if (exceeds(books.elastic_turn_rad, Limits::kElasticTurn_rad)) {
    causes.push_back(
        {.name = "elastic_turn",
         .value = books.elastic_turn_rad,
         .threshold = Limits::kElasticTurn_rad,
         .text = fmt::format("elements turn by up to {:.3g} rad in a body whose shapes add up "
                             "linearly, so what bends grows longer and moves otherwise",
                             books.elastic_turn_rad),
         .remedy = "use " + books.reduced_key + ".formulation: corotational."});
  }
  if (!books.parasitic_mass_kg || !(books.lightest_port_body_kg > 0.0)) return;
  const double mass = *books.parasitic_mass_kg / books.lightest_port_body_kg;
  if (exceeds(mass, Limits::kParasiticMass)) {
    causes.push_back(
        {.name = "parasitic_mass",
         .value = mass,
         .threshold = Limits::kParasiticMass,
         .text = fmt::format("the line of tlm adds {:.3g} kg at each port, {} of the lightest body "
                             "there ({:.3g} kg)",
                             *books.parasitic_mass_kg, percent(mass), books.lightest_port_body_kg),
         .remedy = "lower " + step_key(books) +
                   " or coupling.tlm.stiffness_N_per_m, or use coupling.scheme: "
                   "interface_jacobian."});
  }
}

}  // namespace

Verdict judge(const RunBooks& books) {
  Verdict verdict{.scale_J = std::max({books.held_J, books.external_work_J,
                                       books.potential_change_J, books.still_J}),
                  .books = books,
                  .causes = {}};
  judge_steps(books, verdict.causes);
  judge_pace(books, verdict.causes);
  judge_energy(books, verdict.scale_J, verdict.causes);
  judge_model(books, verdict.causes);
  return verdict;
}

std::string Verdict::status() const { return clean() ? "done" : "done, but"; }

std::string Verdict::text() const {
  std::string text = status();
  for (const Cause& cause : causes) {
    text += &cause == &causes.front() ? " " : "\n  and ";
    text += cause.text + ": " + cause.remedy;
  }
  return text;
}

std::string Verdict::numbers() const {
  const auto of_scale = [&](double value) { return percent(part_of(value, scale_J)); };
  std::string text;
  if (books.coupled) {
    text = fmt::format("exchanged {:.3g} J ({}), ", books.exchanged_J, of_scale(books.exchanged_J));
  }
  const bool made = books.lost_J < 0.0;
  const double size_J = std::abs(books.lost_J);
  return text + fmt::format(
                    "{} numerically {:.3g} J ({}), balance error {:.2g} J ({}), of {:.3g} "
                    "J held or given at most",
                    made ? "made" : "lost", size_J, of_scale(size_J), books.balance_error_J,
                    of_scale(std::abs(books.balance_error_J)), scale_J);
}

nlohmann::ordered_json to_json(const Verdict& verdict) {
  using nlohmann::ordered_json;
  const auto entry = [&](double value) -> ordered_json {
    return {{"J", value}, {"part", part_of(std::abs(value), verdict.scale_J)}};
  };
  ordered_json json = {{"status", verdict.status()},
                       {"text", verdict.text()},
                       {"numbers", verdict.numbers()},
                       {"scale_J", verdict.scale_J}};
  if (verdict.books.coupled) json["exchanged"] = entry(verdict.books.exchanged_J);
  json["lost_numerically"] = entry(verdict.books.lost_J);
  json["balance_error"] = entry(verdict.books.balance_error_J);
  json["largest_turn_rad"] = verdict.books.largest_turn_rad;
  json["causes"] = ordered_json::array();
  for (const Cause& cause : verdict.causes) {
    json["causes"].push_back({{"name", cause.name},
                              {"value", cause.value},
                              {"threshold", cause.threshold},
                              {"text", cause.text},
                              {"remedy", cause.remedy}});
  }
  return json;
}

}  // namespace tandem::orchestrator

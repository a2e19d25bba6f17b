#include "protocol/schemes/coupling_params.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "protocol/contract/error.h"

namespace tandem {
namespace {

template <class Value, std::size_t N>
using Names = std::array<std::pair<const char*, Value>, N>;

constexpr Names<SchemeKind, 5> kSchemes{{{"explicit_serial", SchemeKind::ExplicitSerial},
                                         {"explicit_parallel", SchemeKind::ExplicitParallel},
                                         {"implicit", SchemeKind::Implicit},
                                         {"interface_jacobian", SchemeKind::InterfaceNewton},
                                         {"tlm", SchemeKind::Tlm}}};
constexpr Names<Refresh, 3> kRefreshes{{{"every_step", Refresh::EveryStep},
                                        {"every_n_steps", Refresh::EveryNSteps},
                                        {"broyden", Refresh::Broyden}}};
constexpr Names<Refresh, 4> kFemRefreshes{{{"automatic", Refresh::Automatic},
                                           {"every_step", Refresh::EveryStep},
                                           {"every_n_steps", Refresh::EveryNSteps},
                                           {"broyden", Refresh::Broyden}}};
constexpr Names<Prediction, 3> kPredictions{{{"hold", Prediction::Hold},
                                             {"linear", Prediction::Linear},
                                             {"quadratic", Prediction::Quadratic}}};
constexpr Names<Relaxation, 5> kRelaxations{{{"constant", Relaxation::Constant},
                                             {"aitken", Relaxation::Aitken},
                                             {"anderson", Relaxation::Anderson},
                                             {"iqn_ils", Relaxation::IqnIls},
                                             {"iqn_imvj", Relaxation::IqnImvj}}};
constexpr Names<Iteration, 2> kIterations{
    {{"serial", Iteration::Serial}, {"parallel", Iteration::Parallel}}};
constexpr Names<OnNotConverged, 2> kOnNotConverged{
    {{"stop", OnNotConverged::Stop}, {"accept", OnNotConverged::Accept}}};

template <class Value, std::size_t N>
std::string name_of(const Names<Value, N>& names, Value value) {
  for (const auto& [name, candidate] : names) {
    if (candidate == value) return name;
  }
  throw std::logic_error("enumeration value without a name");
}

template <class Value, std::size_t N>
Value value_of(const Names<Value, N>& names, const std::string& name) {
  for (const auto& [candidate, value] : names) {
    if (candidate == name) return value;
  }
  throw std::logic_error("the key table let '" + name + "' pass");
}

template <class Value, std::size_t N>
std::vector<std::string> choices_of(const Names<Value, N>& names) {
  std::vector<std::string> choices;
  for (const auto& [name, value] : names) choices.emplace_back(name);
  return choices;
}

std::string number(double x) { return fmt::format("{}", x); }

}  // namespace

std::string to_string(SchemeKind kind) { return name_of(kSchemes, kind); }
std::string to_string(Prediction prediction) { return name_of(kPredictions, prediction); }

std::vector<std::string> notes_of(const CouplingParams& params) {
  const bool explicit_scheme =
      params.scheme == SchemeKind::ExplicitSerial || params.scheme == SchemeKind::ExplicitParallel;
  if (params.retained_inertia.factor == 0.0 || explicit_scheme) return {};
  return {fmt::format(
      "coupling.retained_inertia.factor: {} has no effect with coupling.scheme: {}: it belongs to "
      "explicit_serial and explicit_parallel. Leave it out or use one of them.",
      params.retained_inertia.factor, to_string(params.scheme))};
}

namespace {

std::optional<SimTime> step_of(const scenario::Node& node, const char* key) {
  if (!node.has(key)) return std::nullopt;
  try {
    return std::max(sim_time_from_seconds(node.real(key)), SimTime(1));
  } catch (const Error& error) {
    node.fail(key, error.what());
  }
}

AdaptiveParams read_adaptive(const scenario::Node& node) {
  AdaptiveParams params{.tolerance = node.real("tolerance"),
                        .min_step = step_of(node, "min_step_s"),
                        .max_step = step_of(node, "max_step_s")};
  if (params.min_step && params.max_step && *params.max_step < *params.min_step) {
    node.fail("max_step_s", "is shorter than min_step_s. Raise it.");
  }
  return params;
}

scenario::Key quasi_newton_key() {
  const QuasiNewtonParams d;
  scenario::Section content{
      "Quasi-Newton",
      "Secant columns of the accelerators anderson, iqn_ils and iqn_imvj.",
      {scenario::integer("reused_steps")
           .doc_is("Accepted macro steps whose columns iqn_ils keeps.")
           .between(0, 1000)
           .by_default(std::to_string(d.reused_steps)),
       scenario::real("filter", "")
           .doc_is("A column is left out when its part that is new to the newer columns is less "
                   "than this part of it.")
           .between(0.0, 1.0)
           .by_default(number(d.filter))}};
  return scenario::section("quasi_newton", std::move(content)).by_default("{}");
}

QuasiNewtonParams read_quasi_newton(const scenario::Node& node) {
  return {.reused_steps = static_cast<std::int32_t>(node.integer("reused_steps")),
          .filter = node.real("filter")};
}

scenario::Key jacobian_key() {
  const JacobianParams d;
  scenario::Section content{
      "Interface Jacobians",
      "When `interface_jacobian` takes the sides' Jacobians anew. Kept ones save their cost (six "
      "steps of ODE per port) and may need more iterations.",
      {scenario::choice("mbs_refresh", choices_of(kRefreshes))
           .doc_is("Of the multibody side: at the first evaluation of every macro step, of every "
                   "n-th one, or once and then by Broyden's updates.")
           .by_default(name_of(kRefreshes, d.mbs_refresh)),
       scenario::choice("fem_refresh", choices_of(kFemRefreshes))
           .doc_is("Of the flexible side, likewise; every_step uses each factorisation. automatic: "
                   "every_step, but broyden where the side takes micro steps.")
           .by_default(name_of(kFemRefreshes, d.fem_refresh)),
       scenario::integer("every_steps")
           .doc_is("Macro steps between two Jacobians with every_n_steps.")
           .between(1, 1000000)
           .by_default(std::to_string(d.every_steps))}};
  return scenario::section("jacobian", std::move(content)).by_default("{}");
}

JacobianParams read_jacobian(const scenario::Node& node) {
  return {.mbs_refresh = value_of(kRefreshes, node.text("mbs_refresh")),
          .fem_refresh = value_of(kFemRefreshes, node.text("fem_refresh")),
          .every_steps = static_cast<std::int32_t>(node.integer("every_steps"))};
}

scenario::Key retained_inertia_key() {
  const RetainedInertiaParams d;
  scenario::Section content{
      "Retained inertia",
      "Explicit schemes: the rigid side carries the flexible side's effective port inertia, and "
      "the "
      "inertia force that the predicted wrench has booked is subtracted. Widens their limit.",
      {scenario::real("factor", "")
           .doc_is(
               "Part of the flexible side's effective inertia that is carried, 0 = off, 1 = all.")
           .between(0.0, 10.0)
           .by_default(number(d.factor)),
       scenario::integer("refresh_steps")
           .doc_is("Macro steps after which the inertia is taken anew, 0 = once.")
           .between(0, 1000000)
           .by_default(std::to_string(d.refresh_steps))}};
  return scenario::section("retained_inertia", std::move(content)).by_default("{}");
}

RetainedInertiaParams read_retained_inertia(const scenario::Node& node) {
  return {.factor = node.real("factor"),
          .refresh_steps = static_cast<std::int32_t>(node.integer("refresh_steps"))};
}

scenario::Key tlm_key() {
  const TlmParams d;
  scenario::Section content{
      "Transmission line",
      "Scheme `tlm`: an elastic line between the sides at each port, whose delay is the macro "
      "step.",
      {scenario::real("stiffness_N_per_m", "N/m")
           .doc_is("Stiffness k of the line; it adds the mass k H² and the compliance 1/k. "
                   "Rotations see k times the port length squared.")
           .above(0.0)
           .by_default(number(d.stiffness_N_per_m))}};
  return scenario::section("tlm", std::move(content)).by_default("{}");
}

scenario::Key adaptive_key() {
  const AdaptiveParams d;
  scenario::Section content{
      "Adaptive macro step",
      "The macro step follows the error which it makes at the ports; run.macro_step_s is the first "
      "one.",
      {scenario::real("tolerance", "")
           .doc_is(
               "Error above which a macro step is made again: of the ports' positions, relative "
               "to the size of the interface (the diagonal of the box around the ports, or the "
               "largest port length); in explicit schemes also of the interface power, "
               "relative to the largest so far. 0 = fixed steps.")
           .between(0.0, 1.0)
           .by_default(number(d.tolerance)),
       scenario::real("min_step_s", "s")
           .above(0.0)
           .doc_is(
               "Shortest macro step, and the unit of all of them: a whole multiple of the sides' "
               "micro steps. Left out: run.macro_step_s / 32."),
       scenario::real("max_step_s", "s")
           .above(0.0)
           .doc_is("Longest macro step. Left out: 32 run.macro_step_s.")}};
  content.check = [](const scenario::Node& node) { (void)read_adaptive(node); };
  return scenario::section("adaptive", std::move(content)).by_default("{}");
}

}  // namespace

scenario::Key coupling_keys() {
  using scenario::choice;
  using scenario::integer;
  using scenario::real;
  const CouplingParams d;
  scenario::Section content{
      "Coupling",
      "How one macro step is made from evaluations of both sides.",
      {choice("scheme", choices_of(kSchemes))
           .doc_is("Rule by which a macro step is made; compare them with `tandem compare`.")
           .by_default(name_of(kSchemes, d.scheme)),
       choice("prediction", choices_of(kPredictions))
           .doc_is("Extrapolation of the wrenches from accepted macro steps: the input of explicit "
                   "schemes, the first guess of iterative ones.")
           .by_default(name_of(kPredictions, d.prediction)),
       choice("motion_prediction", choices_of(kPredictions))
           .doc_is("Extrapolation of the port velocities in schemes where both sides compute at "
                   "the same time; the poses follow from them.")
           .by_default(name_of(kPredictions, d.motion_prediction)),
       integer("max_iterations")
           .doc_is("Evaluations of both sides per macro step before it counts as not converged.")
           .between(1, 100000)
           .by_default(std::to_string(d.max_iterations)),
       integer("max_evaluations")
           .doc_is("Evaluations after which a macro step of an iterating scheme ends as it is, for "
                   "runs in real time: what is left in the wrench is booked and told. "
                   "interface_jacobian makes two at least where both sides begin at the same time. "
                   "Left out: none, and max_iterations decides.")
           .between(1, 100000),
       real("tolerance_N", "N")
           .doc_is("Absolute part of the residual that counts as converged; torques are divided by "
                   "the port length. 0: the relative part and round-off alone, which have the "
                   "scale of the model.")
           .at_least(0.0)
           .by_default(number(d.tolerance_N)),
       real("relative_tolerance", "")
           .doc_is("Part of the residual that counts as converged, relative to the largest wrench "
                   "norm up to now. Left out: 0.1 run.accuracy with interface_jacobian, 0.01 with "
                   "implicit.")
           .between(0.0, 1.0),
       choice("relaxation", choices_of(kRelaxations))
           .doc_is("Accelerator of `implicit`: a constant factor, Aitken's adapted one, or a "
                   "quasi-Newton method on the columns of this macro step (anderson), of the last "
                   "ones too (iqn_ils), or on an accumulated Jacobian (iqn_imvj).")
           .by_default(name_of(kRelaxations, d.relaxation)),
       real("relaxation_factor", "")
           .doc_is("Constant relaxation factor, or the first one of the other accelerators.")
           .above(0.0)
           .between(0.0, 2.0)
           .by_default(number(d.relaxation_factor)),
       choice("iteration", choices_of(kIterations))
           .doc_is("How `implicit` evaluates the sides: one after the other, or both at the same "
                   "time from the same iterate.")
           .by_default(name_of(kIterations, d.iteration)),
       real("tolerance_m_per_s", "m/s")
           .doc_is("Absolute part of the velocity residual of parallel iterations that counts as "
                   "converged; angular velocities are multiplied by the port length. 0: the "
                   "relative part, and what the wrench's own tolerance makes of the velocity.")
           .at_least(0.0)
           .by_default(number(d.tolerance_m_per_s)),
       quasi_newton_key(), jacobian_key(), retained_inertia_key(), tlm_key(), adaptive_key(),
       choice("on_not_converged", choices_of(kOnNotConverged))
           .doc_is(
               "What a macro step that reaches max_iterations does: stop the run, or accept the "
               "last iterate and count it as not converged.")
           .by_default(name_of(kOnNotConverged, d.on_not_converged)),
       real("divergence_growth", "")
           .doc_is("Growth of the interface energy defect, over consecutive macro steps whose "
                   "residual exceeds half the wrench, that stops the run as diverged.")
           .above(1.0)
           .by_default(number(d.divergence_growth))}};
  return scenario::section("coupling", std::move(content)).by_default("{}");
}

namespace {

double default_tolerance(SchemeKind scheme) {
  return scheme == SchemeKind::InterfaceNewton ? CouplingParams::kNewtonTolerance
                                               : CouplingParams::kFixedStepTolerance;
}

}  // namespace

CouplingParams read_coupling(const scenario::Node& root) {
  const scenario::Node node = root.section("coupling");
  return CouplingParams{
      .scheme = value_of(kSchemes, node.text("scheme")),
      .prediction = value_of(kPredictions, node.text("prediction")),
      .motion_prediction = value_of(kPredictions, node.text("motion_prediction")),
      .max_iterations = static_cast<std::int32_t>(node.integer("max_iterations")),
      .max_evaluations = node.has("max_evaluations")
                             ? static_cast<std::int32_t>(node.integer("max_evaluations"))
                             : 0,
      .tolerance_N = node.real("tolerance_N"),
      .relative_tolerance = node.has("relative_tolerance")
                                ? node.real("relative_tolerance")
                                : default_tolerance(value_of(kSchemes, node.text("scheme"))),
      .tolerance_m_per_s = node.real("tolerance_m_per_s"),
      .iteration = value_of(kIterations, node.text("iteration")),
      .relaxation = value_of(kRelaxations, node.text("relaxation")),
      .relaxation_factor = node.real("relaxation_factor"),
      .quasi_newton = read_quasi_newton(node.section("quasi_newton")),
      .jacobian = read_jacobian(node.section("jacobian")),
      .retained_inertia = read_retained_inertia(node.section("retained_inertia")),
      .tlm = {.stiffness_N_per_m = node.section("tlm").real("stiffness_N_per_m")},
      .adaptive = read_adaptive(node.section("adaptive")),
      .on_not_converged = value_of(kOnNotConverged, node.text("on_not_converged")),
      .divergence_growth = node.real("divergence_growth"),
  };
}

}  // namespace tandem

#include "protocol/schemes/coupling_params.h"

#include <fmt/format.h>

#include <array>
#include <utility>
#include <vector>

namespace tandem {
namespace {

template <class Value, std::size_t N>
using Names = std::array<std::pair<const char*, Value>, N>;

constexpr Names<SchemeKind, 3> kSchemes{{{"explicit_serial", SchemeKind::ExplicitSerial},
                                         {"implicit", SchemeKind::Implicit},
                                         {"interface_jacobian", SchemeKind::InterfaceNewton}}};
constexpr Names<Prediction, 2> kPredictions{
    {{"hold", Prediction::Hold}, {"linear", Prediction::Linear}}};
constexpr Names<Relaxation, 2> kRelaxations{
    {{"constant", Relaxation::Constant}, {"aitken", Relaxation::Aitken}}};
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
       integer("max_iterations")
           .doc_is("Evaluations of both sides per macro step before it counts as not converged.")
           .between(1, 100000)
           .by_default(std::to_string(d.max_iterations)),
       real("tolerance_N", "N")
           .doc_is("Absolute part of the residual that counts as converged; torques are divided by "
                   "the port length.")
           .at_least(0.0)
           .by_default(number(d.tolerance_N)),
       real("relative_tolerance", "")
           .doc_is("Part of the residual that counts as converged, relative to the wrench norm.")
           .between(0.0, 1.0)
           .by_default(number(d.relative_tolerance)),
       choice("relaxation", choices_of(kRelaxations))
           .doc_is("Accelerator of `implicit`: a constant factor or Aitken's adapted one.")
           .by_default(name_of(kRelaxations, d.relaxation)),
       real("relaxation_factor", "")
           .doc_is("Constant relaxation factor, or Aitken's first one.")
           .above(0.0)
           .between(0.0, 2.0)
           .by_default(number(d.relaxation_factor)),
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

CouplingParams read_coupling(const scenario::Node& root) {
  const scenario::Node node = root.section("coupling");
  return CouplingParams{
      .scheme = value_of(kSchemes, node.text("scheme")),
      .prediction = value_of(kPredictions, node.text("prediction")),
      .max_iterations = static_cast<std::int32_t>(node.integer("max_iterations")),
      .tolerance_N = node.real("tolerance_N"),
      .relative_tolerance = node.real("relative_tolerance"),
      .relaxation = value_of(kRelaxations, node.text("relaxation")),
      .relaxation_factor = node.real("relaxation_factor"),
      .on_not_converged = value_of(kOnNotConverged, node.text("on_not_converged")),
      .divergence_growth = node.real("divergence_growth"),
  };
}

}  // namespace tandem

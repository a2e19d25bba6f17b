#include "orchestrator/warnings/warnings.h"

#include <iterator>
#include <utility>

#include "orchestrator/warnings/body_warnings.h"
#include "orchestrator/warnings/junction_warnings.h"
#include "orchestrator/warnings/material_warnings.h"
#include "orchestrator/warnings/set_warnings.h"
#include "orchestrator/warnings/setup_warnings.h"
#include "orchestrator/warnings/stability_warnings.h"

namespace tandem::orchestrator {
namespace {

void add(std::optional<Finding> finding, std::vector<Finding>& all) {
  if (finding) all.push_back(std::move(*finding));
}

void add(std::vector<Finding> findings, std::vector<Finding>& all) {
  std::move(findings.begin(), findings.end(), std::back_inserter(all));
}

}  // namespace

std::vector<Finding> warnings_of(const scenario::Node& root, const fem::Model& body) {
  std::vector<Finding> all;
  add(implausible_size(root, body), all);
  add(implausible_densities(root, body), all);
  add(implausible_moduli(root, body), all);
  add(coarse_in_bending(root, body), all);
  add(corner_nodes_only(body), all);
  add(unstable_newmark(root, body), all);
  return all;
}

std::vector<Finding> warnings_of(const Model& model, const mbs::Params& params,
                                 const fem::Model* body, const MotionSet& origins) {
  const scenario::Node& root = model.scenario.root;
  std::vector<Finding> all;
  if (body != nullptr) {
    all = warnings_of(root, *body);
    add(far_ports(root, *body, origins), all);
    add(unstable_verlet(model, params, *body), all);
    add(unlike_stand_in(model, params, *body), all);
  } else if (root.section("fem").text("model") == "ancf") {
    add(implausible_chain_material(root), all);
  }
  add(coarse_tolerances(root), all);
  add(gravity_on_one_side(root), all);
  add(orders_differ(root), all);
  add(turn_per_step(model, params), all);
  return all;
}

}  // namespace tandem::orchestrator

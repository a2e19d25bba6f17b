#include "orchestrator/scenario/scenario_table.h"

#include "fem_process/keys/fem_keys.h"
#include "mbs_process/mbs_keys.h"
#include "mbs_process/world_links.h"
#include "protocol/driver/wire_params.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/multibody_worlds.h"
#include "protocol/schemes/coupling_params.h"

namespace tandem::orchestrator {

const scenario::Section& scenario_table() {
  static const scenario::Section table = [] {
    scenario::Section root;
    root.title = "Scenario";
    root.doc = "One coupled model and how to run it.";
    root.keys = scenario::root_keys();
    for (scenario::Key key :
         {scenario::run_keys(), coupling_keys(), scenario::ports_keys(), mbs::mbs_keys(),
          fem::fem_keys(), scenario::output_keys(), wire_keys()}) {
      root.keys.push_back(std::move(key));
    }
    root.check = [](const scenario::Node& node) {
      if (node.has("mbs") && node.holds_list("mbs")) mbs::refuse_links(node.list("mbs"));
      (void)scenario::world_table(node);
      if (!node.has("fem") || !node.holds_list("fem")) return;
      for (const scenario::FlexibleBody& body : scenario::flexible_bodies(node)) {
        const scenario::Node fem = body.root.section("fem");
        if (fem.text("model") == "ancf" || fem.text("coupling") != "nodal") continue;
        fem.fail("coupling",
                 "nodal makes bodies and ports of the nodes of one mesh, the only "
                 "flexible body. Use ports.");
      }
    };
    return root;
  }();
  return table;
}

const scenario::Section& fem_scenario_table() {
  static const scenario::Section table = [] {
    scenario::Section root = scenario_table();
    for (scenario::Key& key : root.keys) {
      if (key.name != "name" && key.name != "fem") key.required = false;
    }
    return root;
  }();
  return table;
}

void require_one_body(const scenario::Node& root) {
  if (!root.holds_list("fem")) return;
  root.fail("fem",
            "is a list of bodies. `tandem fem` computes one: give it a mapping, without "
            "'- ' and name.");
}

void require_mesh_file(const scenario::Node& root) {
  for (const scenario::FlexibleBody& body : scenario::flexible_bodies(root)) {
    const scenario::Node fem = body.root.section("fem");
    if (fem.has("mesh")) (void)fem.section("mesh").input_file("file");
  }
}

}  // namespace tandem::orchestrator

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "mbs_process/mbs_keys.h"
#include "orchestrator/page/system_graph.h"
#include "protocol/driver/remote_bodies.h"
#include "protocol/driver/remote_worlds.h"

namespace tandem::orchestrator {
namespace {

using Graph = SystemGraph;

class Drawing {
 public:
  explicit Drawing(const Model& model) : model_(model) {
    for (const scenario::MultibodyWorld& world : model.worlds)
      add_world(mbs::read_params(world.root));
  }

  Graph make() {
    graph_.title = model_.name;
    add_bodies();
    add_links();
    add_ports();
    add_processes();
    return std::move(graph_);
  }

 private:
  /// Names of bodies differ over all worlds.
  void add_world(mbs::Params world) {
    rigid_bodies_.push_back(world.bodies.size());
    std::move(world.bodies.begin(), world.bodies.end(), std::back_inserter(params_.bodies));
    std::move(world.joints.begin(), world.joints.end(), std::back_inserter(params_.joints));
    std::move(world.springs.begin(), world.springs.end(), std::back_inserter(params_.springs));
  }

  void add_bodies() {
    if (uses_ground()) graph_.nodes.push_back({Graph::Part::Ground, mbs::kWorld, ""});
    first_rigid_ = graph_.nodes.size();
    for (const mbs::BodyParams& body : params_.bodies) {
      graph_.nodes.push_back(
          {Graph::Part::Rigid, body.name,
           body.massless ? "massless junction" : fmt::format("{:.3g} kg", body.mass_kg)});
    }
    first_flexible_ = graph_.nodes.size();
    for (const scenario::FlexibleBody& body : model_.bodies) {
      const scenario::Node fem = body.root.section("fem");
      const bool chain = fem.text("model") == "ancf";
      graph_.nodes.push_back(
          {Graph::Part::Flexible, body.name.empty() ? "flexible body" : body.name,
           chain ? "ANCF chain"
                 : fmt::format("{}, {}", fem.section("mesh").path("file").filename().string(),
                               fem.text("formulation"))});
    }
  }

  [[nodiscard]] bool uses_ground() const {
    const auto grounded = [](const auto& link) { return link.body2 == mbs::kWorld; };
    return std::any_of(params_.joints.begin(), params_.joints.end(), grounded) ||
           std::any_of(params_.springs.begin(), params_.springs.end(), grounded);
  }

  [[nodiscard]] std::size_t node_of(const std::string& body) const {
    return first_rigid_ == 1 && body == mbs::kWorld
               ? 0
               : first_rigid_ + mbs::body_index(params_, body).value();
  }

  void add_links() {
    for (const mbs::JointParams& joint : params_.joints) {
      graph_.edges.push_back({Graph::Link::Joint, node_of(joint.body2), node_of(joint.body1),
                              joint.name,
                              mbs::name_of(joint.kind) + (joint.motor ? ", motor" : "")});
    }
    for (const mbs::SpringParams& spring : params_.springs) {
      graph_.edges.push_back({Graph::Link::Spring, node_of(spring.body2), node_of(spring.body1),
                              spring.name, fmt::format("{:.3g} N/m", spring.stiffness_N_per_m)});
    }
  }

  void add_ports() {
    const std::vector<scenario::PortParams> ports = scenario::read_ports(model_.scenario.root);
    for (std::size_t b = 0; b < model_.table.size(); ++b) {
      for (const std::size_t p : model_.table[b].ports) {
        graph_.edges.push_back({Graph::Link::Port, node_of(ports[p].body), first_flexible_ + b,
                                ports[p].name, kind_of(ports[p].attachment.kind)});
      }
    }
  }

  static std::string kind_of(scenario::AttachmentKind kind) {
    switch (kind) {
      case scenario::AttachmentKind::Averaging:
        return "averaging";
      case scenario::AttachmentKind::Bushing:
        return "bushing";
      case scenario::AttachmentKind::Rigid:
        break;
    }
    return "";
  }

  void add_processes() {
    const wire::ProcessNames names = process_names(model_.table, model_.world_table);
    const std::vector<wire::Process> worlds = world_processes(model_.world_table);
    for (std::size_t w = 0; w < worlds.size(); ++w) {
      graph_.processes.push_back(
          fmt::format("{}: {} rigid bodies", names.program(worlds[w]), rigid_bodies_[w]) +
          (w == 0 ? fmt::format(", scheme {}", to_string(model_.coupling.scheme)) : ""));
    }
    for (const wire::Process process : processes_of(model_.table)) {
      graph_.processes.push_back(names.program(process) + ": a flexible body");
    }
    graph_.processes.emplace_back("tandem: records; all on this host");
  }

  const Model& model_;
  mbs::Params params_;                     ///< bodies, joints and springs of all worlds
  std::vector<std::size_t> rigid_bodies_;  ///< of each world
  Graph graph_;
  std::size_t first_rigid_ = 0, first_flexible_ = 0;
};

}  // namespace

SystemGraph graph_of(const Model& model) { return Drawing(model).make(); }

}  // namespace tandem::orchestrator

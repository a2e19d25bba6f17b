#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "orchestrator/scenario/model.h"

namespace tandem::orchestrator {

/// What a coupled system consists of and what holds it together, for a picture.
struct SystemGraph {
  enum class Part { Ground, Rigid, Flexible };
  struct Node {
    Part part = Part::Rigid;
    std::string name;
    std::string detail;  ///< below the name: mass, mesh
  };
  enum class Link { Joint, Spring, Port };
  struct Edge {
    Link link = Link::Joint;
    std::size_t from = 0, to = 0;  ///< numbers of nodes
    std::string name;
    std::string detail;  ///< kind of joint, "motor", attachment
  };
  std::string title;
  std::vector<Node> nodes;
  std::vector<Edge> edges;
  std::vector<std::string> processes;  ///< one line each: who computes what, and where
};

/// The system of a scenario: the ground where something is fixed to it, rigid bodies, flexible
/// bodies; joints, springs, ports.
[[nodiscard]] SystemGraph graph_of(const Model& model);

/// Drawn in layers from the ground (or the first body) to the right: nodes as boxes, their order
/// in a layer such that links cross little, links as labelled curves. One self-contained SVG; the
/// same graph gives the same text.
[[nodiscard]] std::string svg_of(const SystemGraph& graph);

}  // namespace tandem::orchestrator

// The picture of a coupled system: every part and link is there, where it can be read.
#include "orchestrator/page/system_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "mbs_process/make_side.h"

namespace tandem::orchestrator {
namespace {

SystemGraph graph_of_example(const std::string& example) {
  const Model model =
      load_model(TANDEM_SOURCE_DIR + std::string("/examples/") + example + "/scenario.yaml", {});
  return graph_of(model);
}

std::size_t occurrences(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

TEST(SystemGraph, HoldsTheGroundBodiesJointsAndPortsOfAChain) {
  const SystemGraph graph = graph_of_example("chain_of_links");
  ASSERT_EQ(graph.nodes.size(), 1U + 8U + 4U);
  EXPECT_EQ(graph.nodes[0].part, SystemGraph::Part::Ground);
  EXPECT_EQ(graph.nodes[9].name, "link1");
  EXPECT_EQ(graph.nodes[9].part, SystemGraph::Part::Flexible);
  ASSERT_EQ(graph.edges.size(), 4U + 8U);
  EXPECT_EQ(graph.edges[0].from, 0U) << "the first hinge is fixed to the ground";
  EXPECT_EQ(graph.edges[0].detail, "hinge");
  EXPECT_EQ(graph.edges[4].to, 9U);
  EXPECT_EQ(graph.processes.size(), 6U);
}

// A body that nothing fixes: no ground is drawn.
TEST(SystemGraph, HasNoGroundWhereNothingIsFixed) {
  const SystemGraph graph = graph_of_example("two_masses");
  EXPECT_EQ(graph.nodes[0].part, SystemGraph::Part::Rigid);
  EXPECT_EQ(graph.nodes.back().name, "flexible body");
}

TEST(SystemGraph, IsDrawnWhole) {
  SystemGraph graph = graph_of_example("chain_of_links");
  graph.nodes[1].name = "a<b";
  const std::string svg = svg_of(graph);
  EXPECT_EQ(svg, svg_of(graph));
  EXPECT_EQ(occurrences(svg, "rx="), graph.nodes.size());
  EXPECT_EQ(occurrences(svg, "<path"), graph.edges.size() + 3) << "each link, and the key's three";
  EXPECT_NE(svg.find("a&lt;b"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

// No box lies on another, in a graph with loops and several layers.
TEST(SystemGraph, BoxesDoNotOverlap) {
  for (const std::string example : {"chain_of_links", "slider_crank", "tracked_vehicle"}) {
    const std::string svg = svg_of(graph_of_example(example));
    const std::regex box("<rect x=\"([0-9.-]+)\" y=\"([0-9.-]+)\" width=\"150\" height=\"46\"");
    std::vector<std::pair<double, double>> corners;
    for (std::sregex_iterator it(svg.begin(), svg.end(), box), end; it != end; ++it) {
      corners.emplace_back(std::stod((*it)[1]), std::stod((*it)[2]));
    }
    ASSERT_GT(corners.size(), 3U) << example;
    for (std::size_t a = 0; a < corners.size(); ++a) {
      for (std::size_t b = a + 1; b < corners.size(); ++b) {
        const bool apart = std::abs(corners[a].first - corners[b].first) >= 150.0 ||
                           std::abs(corners[a].second - corners[b].second) >= 46.0;
        EXPECT_TRUE(apart) << example << ": " << a << ", " << b;
      }
    }
  }
}

}  // namespace
}  // namespace tandem::orchestrator

#include "orchestrator/page/system_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>

#include "orchestrator/page/svg_plot.h"

namespace tandem::orchestrator {
namespace {

using Graph = SystemGraph;

// Sizes in pixels.
constexpr double kBoxWidth = 150.0, kBoxHeight = 46.0;
constexpr double kAcross = 300.0, kDown = 86.0;  // from a node to the next
constexpr double kMargin = 40.0, kHead = 60.0, kRow = 18.0;
constexpr int kSweeps = 12;

struct Place {
  int layer = -1;
  double slot = 0.0;  ///< position within the layer
};

std::vector<std::vector<std::size_t>> neighbours_of(const Graph& graph) {
  std::vector<std::vector<std::size_t>> neighbours(graph.nodes.size());
  for (const Graph::Edge& edge : graph.edges) {
    neighbours[edge.from].push_back(edge.to);
    neighbours[edge.to].push_back(edge.from);
  }
  return neighbours;
}

/// Distance in links from the first node; of what hangs together with nothing before it, from its
/// own first one.
std::vector<Place> layers_of(const std::vector<std::vector<std::size_t>>& neighbours) {
  std::vector<Place> places(neighbours.size());
  for (std::size_t start = 0; start < places.size(); ++start) {
    if (places[start].layer >= 0) continue;
    places[start].layer = 0;
    std::deque<std::size_t> open{start};
    while (!open.empty()) {
      const std::size_t node = open.front();
      open.pop_front();
      for (const std::size_t next : neighbours[node]) {
        if (places[next].layer >= 0) continue;
        places[next].layer = places[node].layer + 1;
        open.push_back(next);
      }
    }
  }
  return places;
}

/// Orders each layer by the mean slot of its nodes' neighbours, again and again: links then cross
/// little [Sugiyama et al. 1981]. Slots are counted from the middle of the layer.
void order_layers(const std::vector<std::vector<std::size_t>>& neighbours,
                  std::vector<Place>& places) {
  std::map<int, std::vector<std::size_t>> layers;
  for (std::size_t node = 0; node < places.size(); ++node) {
    layers[places[node].layer].push_back(node);
  }
  const auto spread = [&](const std::vector<std::size_t>& layer) {
    for (std::size_t i = 0; i < layer.size(); ++i) {
      places[layer[i]].slot = static_cast<double>(i) - 0.5 * static_cast<double>(layer.size() - 1);
    }
  };
  for (const auto& [number, layer] : layers) spread(layer);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (auto& [number, layer] : layers) {
      std::vector<double> mean(places.size(), 0.0);
      for (const std::size_t node : layer) {
        double sum = 0.0;
        for (const std::size_t next : neighbours[node]) sum += places[next].slot;
        mean[node] = neighbours[node].empty() ? places[node].slot
                                              : sum / static_cast<double>(neighbours[node].size());
      }
      std::stable_sort(layer.begin(), layer.end(),
                       [&](std::size_t a, std::size_t b) { return mean[a] < mean[b]; });
      spread(layer);
    }
  }
}

class Picture {
 public:
  explicit Picture(const Graph& graph) : graph_(graph) {
    const auto neighbours = neighbours_of(graph);
    places_ = layers_of(neighbours);
    order_layers(neighbours, places_);
    for (const Place& place : places_) {
      layers_ = std::max(layers_, place.layer + 1);
      highest_ = std::max(highest_, std::abs(place.slot));
    }
  }

  std::string svg() {
    const double width = 2.0 * kMargin + kBoxWidth + kAcross * (layers_ - 1);
    middle_ = kHead + kMargin + kDown * highest_ + 0.5 * kBoxHeight;
    const double legend = middle_ + kDown * highest_ + 0.5 * kBoxHeight + kMargin;
    const double height = legend + kRow * static_cast<double>(graph_.processes.size()) + kMargin;
    fmt::format_to(std::back_inserter(out_),
                   "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
                   "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"DejaVu Sans, Verdana, "
                   "Helvetica, sans-serif\" font-size=\"12\">\n<title>{2}</title>\n"
                   "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
                   std::max(width, 520.0), height, escaped(graph_.title));
    text(kMargin, 32.0, graph_.title, "font-size=\"17\" font-weight=\"bold\"");
    key(kMargin, 54.0);
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) draw_edge(e);
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n) draw_node(n);
    out_ += labels_;
    for (std::size_t i = 0; i < graph_.processes.size(); ++i) {
      text(kMargin, legend + kRow * static_cast<double>(i + 1), graph_.processes[i],
           "fill=\"#444444\"");
    }
    return std::move(out_) + "</svg>\n";
  }

 private:
  void text(double x, double y, const std::string& what, const std::string& look) {
    fmt::format_to(std::back_inserter(out_), "<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y,
                   look, escaped(what));
  }

  /// What the kinds of links look like.
  void key(double x, double y) {
    for (const auto& [link, name] :
         {std::pair{Graph::Link::Joint, "joint"}, std::pair{Graph::Link::Spring, "spring"},
          std::pair{Graph::Link::Port, "port"}}) {
      fmt::format_to(std::back_inserter(out_),
                     "<path d=\"M{:.1f} {:.1f} h28\" fill=\"none\" {}/>\n", x, y - 4.0,
                     stroke_of(link));
      text(x + 34.0, y, name, "fill=\"#444444\"");
      x += 100.0;
    }
  }

  static std::string stroke_of(Graph::Link link) {
    switch (link) {
      case Graph::Link::Joint:
        return "stroke=\"#333333\" stroke-width=\"1.6\"";
      case Graph::Link::Spring:
        return "stroke=\"#009e73\" stroke-width=\"1.6\" stroke-dasharray=\"5 4\"";
      case Graph::Link::Port:
        break;
    }
    return "stroke=\"#d55e00\" stroke-width=\"2.6\"";
  }

  [[nodiscard]] double left(std::size_t node) const {
    return kMargin + kAcross * places_[node].layer;
  }
  [[nodiscard]] double centre(std::size_t node) const {
    return middle_ + kDown * places_[node].slot;
  }

  void draw_node(std::size_t n) {
    const Graph::Node& node = graph_.nodes[n];
    const double x = left(n), y = centre(n) - 0.5 * kBoxHeight;
    const bool flexible = node.part == Graph::Part::Flexible;
    const char* fill = flexible                           ? "#ffe8d6"
                       : node.part == Graph::Part::Ground ? "#d9d9d9"
                                                          : "#e3edf7";
    fmt::format_to(std::back_inserter(out_),
                   "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.0f}\" height=\"{:.0f}\" rx=\"{}\" "
                   "fill=\"{}\" stroke=\"{}\" stroke-width=\"1.2\"/>\n",
                   x, y, kBoxWidth, kBoxHeight, flexible ? 20 : 3, fill,
                   flexible ? "#d55e00" : "#335577");
    const double at = x + 0.5 * kBoxWidth;
    text(at, y + (node.detail.empty() ? 28.0 : 20.0), node.name,
         "text-anchor=\"middle\" font-weight=\"bold\"");
    if (!node.detail.empty()) {
      text(at, y + 36.0, node.detail, "text-anchor=\"middle\" font-size=\"10\" fill=\"#444444\"");
    }
  }

  /// Which of the links between the same two nodes this is, and of how many.
  [[nodiscard]] std::pair<int, int> rank(std::size_t e) const {
    const auto ends = [&](std::size_t i) {
      return std::minmax(graph_.edges[i].from, graph_.edges[i].to);
    };
    int before = 0, all = 0;
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      if (ends(i) != ends(e)) continue;
      before += i < e ? 1 : 0;
      ++all;
    }
    return {before, all};
  }

  void draw_edge(std::size_t e) {
    const Graph::Edge& edge = graph_.edges[e];
    std::size_t a = edge.from, b = edge.to;
    if (places_[a].layer > places_[b].layer) std::swap(a, b);
    const auto [number, all] = rank(e);
    const double shift = 15.0 * (number - 0.5 * (all - 1));
    const bool same = places_[a].layer == places_[b].layer;
    const double x1 = left(a) + kBoxWidth, y1 = centre(a) + shift;
    const double x2 = same ? x1 : left(b), y2 = centre(b) + shift;
    const double bend = same ? 70.0 : 0.45 * (x2 - x1);
    fmt::format_to(std::back_inserter(out_),
                   "<path d=\"M{:.1f} {:.1f} C{:.1f} {:.1f} {:.1f} {:.1f} {:.1f} {:.1f}\" "
                   "fill=\"none\" {}/>\n",
                   x1, y1, x1 + bend, y1, same ? x2 + bend : x2 - bend, y2, x2, y2,
                   stroke_of(edge.link));
    label(same ? x1 + 0.75 * bend : 0.5 * (x1 + x2), 0.5 * (y1 + y2), edge);
  }

  /// Above all lines, on white.
  void label(double x, double y, const Graph::Edge& edge) {
    const std::string what =
        edge.detail.empty() ? edge.name : fmt::format("{} ({})", edge.name, edge.detail);
    const double half = 3.1 * static_cast<double>(what.size()) + 3.0;
    fmt::format_to(std::back_inserter(labels_),
                   "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"14\" "
                   "fill=\"#ffffff\" fill-opacity=\"0.85\"/>\n<text x=\"{:.1f}\" y=\"{:.1f}\" "
                   "text-anchor=\"middle\" font-size=\"10\">{}</text>\n",
                   x - half, y - 8.0, 2.0 * half, x, y + 3.0, escaped(what));
  }

  const Graph& graph_;
  std::vector<Place> places_;
  int layers_ = 0;
  double highest_ = 0.0, middle_ = 0.0;
  std::string out_, labels_;
};

}  // namespace

std::string svg_of(const SystemGraph& graph) { return Picture(graph).svg(); }

}  // namespace tandem::orchestrator

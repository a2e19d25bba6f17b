#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "fem_process/mesh/raw_mesh.h"

namespace tandem::fem {
namespace {

using Ends = std::pair<std::int64_t, std::int64_t>;

Ends ends_of(std::int64_t a, std::int64_t b) { return {std::min(a, b), std::max(a, b)}; }

class Raiser {
 public:
  explicit Raiser(RawMesh& raw) : raw_(raw) {
    // Every element takes up to six new numbers behind the largest.
    const std::int64_t most = std::numeric_limits<std::int64_t>::max() -
                              6 * static_cast<std::int64_t>(raw.tets.size()) - 1;
    for (std::int64_t tag : raw.node_tags) {
      if (tag > most) {
        raw.fail(1, "node number " + std::to_string(tag) +
                        " leaves no numbers for mid nodes. Number the nodes from 1.");
      }
      next_tag_ = std::max(next_tag_, tag + 1);
    }
  }

  void run() {
    // Before new nodes take the numbers of missing ones.
    for (const RawMesh::Tetrahedron& tet : raw_.tets) {
      for (std::int64_t tag : tet.nodes) static_cast<void>(position(tag, tet));
    }
    for (const auto& [name, set] : raw_.sets) {
      for (std::int64_t tag : set.nodes) {
        if (raw_.node_index.count(tag) > 0) continue;
        raw_.fail(set.line, "set '" + name + "' uses node " + std::to_string(tag) +
                                ", which the file does not define. Write the mesh again.");
      }
    }
    for (RawMesh::Tetrahedron& tet : raw_.tets) raise(tet);
    for (auto& [name, set] : raw_.sets) raise(set);
  }

 private:
  void raise(RawMesh::Tetrahedron& tet) {
    for (std::size_t k = 0; k < 6; ++k) {
      const std::int64_t a = tet.nodes[kTetEdges[k][0]];
      const std::int64_t b = tet.nodes[kTetEdges[k][1]];
      const auto [entry, is_new] = mids_.emplace(ends_of(a, b), next_tag_);
      tet.mids[k] = entry->second;
      if (!is_new) continue;
      raw_.add_node(next_tag_++, 0.5 * (position(a, tet) + position(b, tet)), tet.line);
    }
    tet.second_order = true;
  }

  void raise(RawMesh::Set& set) {
    const std::set<std::int64_t> corners = set.nodes;
    if (set.node_list) {
      for (const auto& [ends, mid] : mids_) {
        if (corners.count(ends.first) > 0 && corners.count(ends.second) > 0) set.nodes.insert(mid);
      }
    }
    for (const auto& line : set.lines) take(set, line[0], line[1]);
    for (RawMesh::Triangle& triangle : set.triangles) {
      const auto& n = triangle.nodes;
      const std::optional<std::int64_t> mids[] = {take(set, n[0], n[1]), take(set, n[1], n[2]),
                                                  take(set, n[2], n[0])};
      triangle.second_order = mids[0] && mids[1] && mids[2];
      if (triangle.second_order) triangle.mids = {*mids[0], *mids[1], *mids[2]};
    }
    if (set.tets_apart) return;
    for (std::int64_t tag : set.tets) {
      const auto& mids = raw_.tets[static_cast<std::size_t>(raw_.tet_index.at(tag))].mids;
      set.nodes.insert(mids.begin(), mids.end());
    }
  }

  /// Adds an edge's mid node to a set; there is none on an edge of no tet.
  std::optional<std::int64_t> take(RawMesh::Set& set, std::int64_t a, std::int64_t b) const {
    const auto found = mids_.find(ends_of(a, b));
    if (found == mids_.end()) return std::nullopt;
    set.nodes.insert(found->second);
    return found->second;
  }

  [[nodiscard]] Eigen::Vector3d position(std::int64_t tag, const RawMesh::Tetrahedron& tet) const {
    const auto found = raw_.node_index.find(tag);
    if (found == raw_.node_index.end()) {
      raw_.fail(tet.line, "element " + std::to_string(tet.tag) + " uses node " +
                              std::to_string(tag) +
                              ", which the file does not define. Write the mesh again.");
    }
    return raw_.node_positions[static_cast<std::size_t>(found->second)];
  }

  RawMesh& raw_;
  std::map<Ends, std::int64_t> mids_;
  std::int64_t next_tag_ = 1;
};

}  // namespace

void raise_to_second_order(RawMesh& raw) { Raiser(raw).run(); }

}  // namespace tandem::fem

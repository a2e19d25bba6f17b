#include "fem_process/matrix/assembly_lists.h"

#include <numeric>

namespace tandem::fem {

AssemblyOrder AssemblyOrder::of_mesh(std::size_t elements, int nodes) {
  AssemblyOrder order;
  order.slot.resize(elements);
  std::iota(order.slot.begin(), order.slot.end(), 0);
  order.nodes.resize(static_cast<std::size_t>(nodes));
  std::iota(order.nodes.begin(), order.nodes.end(), 0);
  return order;
}

AssemblyLists::AssemblyLists(const BlockPattern& pattern, int nodes, const BlocksOf& blocks_of,
                             const AssemblyOrder& order) {
  std::vector<std::vector<Term>> all(pattern.blocks());
  for (std::size_t e = 0; e < order.slot.size(); ++e) {
    const int* blocks = blocks_of(e);
    const int first = nodes * order.slot[e];
    for (int k = 0; k < nodes * nodes; ++k) {
      all[static_cast<std::size_t>(blocks[k])].push_back({first + k / nodes, first + k % nodes});
    }
  }
  const auto end_of = [](const auto& list) { return static_cast<int>(list.size()); };
  for (int i : order.nodes) {
    const auto row = static_cast<std::size_t>(i);
    const int diagonal = pattern.find(i, i);
    rows.push_back({i, diagonal, end_of(corners), end_of(edges)});
    for (const Term& term : all[static_cast<std::size_t>(diagonal)]) corners.push_back(term.i);
    for (int b = diagonal + 1; b < pattern.row_start[row + 1]; ++b) {
      const auto at = static_cast<std::size_t>(b);
      edges.push_back({b, pattern.find(pattern.column[at], i), end_of(terms)});
      terms.insert(terms.end(), all[at].begin(), all[at].end());
    }
  }
  rows.push_back({0, 0, end_of(corners), end_of(edges)});
  edges.push_back({0, 0, end_of(terms)});
}

}  // namespace tandem::fem

#include "fem_process/solvers/elimination_parts.h"

#include <algorithm>
#include <cstdint>

namespace tandem::fem {
namespace {

/// A part has at most this fraction of the factor's entries, unless it is one supernode.
constexpr int kFractions = 8;

/// Supernode of each column.
std::vector<int> owners(const SupernodalFactor& factor) {
  std::vector<int> owner(factor.permutation.size());
  for (int s = 0; s < factor.supernodes(); ++s) {
    const auto at = static_cast<std::size_t>(s);
    std::fill(owner.begin() + factor.first_column[at], owner.begin() + factor.first_column[at + 1],
              s);
  }
  return owner;
}

/// The elimination tree of the supernodes: the parent owns the first row below the columns.
struct Tree {
  std::vector<int> parent;           ///< −1: none
  std::vector<std::int64_t> weight;  ///< entries of the whole subtree
  std::vector<std::vector<int>> children;
};

Tree tree_of(const SupernodalFactor& factor) {
  const std::vector<int> owner = owners(factor);
  const auto n = static_cast<std::size_t>(factor.supernodes());
  Tree tree{std::vector<int>(n, -1), std::vector<std::int64_t>(n, 0),
            std::vector<std::vector<int>>(n)};
  for (std::size_t s = 0; s < n; ++s) {
    const std::int64_t columns = factor.first_column[s + 1] - factor.first_column[s];
    const std::int64_t rows = factor.row_start[s + 1] - factor.row_start[s];
    tree.weight[s] += columns * rows;
    if (rows == columns) continue;
    const int first_below = factor.row[static_cast<std::size_t>(factor.row_start[s] + columns)];
    const int parent = owner[static_cast<std::size_t>(first_below)];
    tree.parent[s] = parent;
    // Parents stand behind their children: the weight is complete.
    tree.weight[static_cast<std::size_t>(parent)] += tree.weight[s];
    tree.children[static_cast<std::size_t>(parent)].push_back(static_cast<int>(s));
  }
  return tree;
}

}  // namespace

EliminationParts cut(const SupernodalFactor& factor) {
  const Tree tree = tree_of(factor);
  const auto n = static_cast<std::size_t>(factor.supernodes());
  std::int64_t total = 0;
  for (std::size_t s = 0; s < n; ++s) total += tree.parent[s] < 0 ? tree.weight[s] : 0;
  const std::int64_t most = total / kFractions;

  EliminationParts result;
  std::vector<int> part(n, -1);  // of each supernode; −1: top
  std::int64_t weight = most + 1;
  // From the roots down: a subtree that is light enough joins the present part or begins a new one.
  for (std::size_t k = n; k-- > 0;) {
    const int parent = tree.parent[k];
    if (parent >= 0 && part[static_cast<std::size_t>(parent)] >= 0) {
      part[k] = part[static_cast<std::size_t>(parent)];
    } else if (tree.weight[k] <= most || tree.children[k].empty()) {
      if (weight + tree.weight[k] > most) {
        result.parts.emplace_back();
        weight = 0;
      }
      weight += tree.weight[k];
      part[k] = static_cast<int>(result.parts.size()) - 1;
    }
  }
  for (std::size_t s = 0; s < n; ++s) {
    std::vector<int>& list =
        part[s] < 0 ? result.top : result.parts[static_cast<std::size_t>(part[s])];
    list.push_back(static_cast<int>(s));
  }
  return result;
}

}  // namespace tandem::fem

#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "fem_process/matrix/block_matrix.h"

namespace tandem::fem {

/// Where the parts of element e stand (slot[e]), and in which order rows are worked. Both orders
/// keep what is near together in a large mesh, or gathering waits for memory.
struct AssemblyOrder {
  std::vector<int> slot;
  std::vector<int> nodes;

  /// The order of the mesh.
  [[nodiscard]] static AssemblyOrder of_mesh(std::size_t elements, int nodes);
};

/// Which nodes of which elements add up in each row of a pattern, so that rows can be gathered by
/// one thread each, the sums in the order of the mesh. Node i of the element at slot s, of N nodes,
/// is entry N s + i of what the elements give. Each list ends with one more entry, for the end of
/// what belongs to the last.
struct AssemblyLists {
  /// Block (i, j), i < j, and its transpose.
  struct Edge {
    int upper = 0;       ///< block (i, j)
    int lower = 0;       ///< block (j, i)
    int first_term = 0;  ///< its last term is before the next edge's first
  };
  struct Term {
    int i = 0;  ///< entry that stands at node i
    int j = 0;
  };
  struct Row {
    int node = 0;
    int diagonal = 0;      ///< block (i, i)
    int first_corner = 0;  ///< in corners
    int first_edge = 0;    ///< in edges
  };
  std::vector<Row> rows;
  std::vector<int> corners;  ///< entries at a node
  std::vector<Edge> edges;
  std::vector<Term> terms;

  /// In which blocks, N i + j, an element's nodes meet.
  using BlocksOf = std::function<const int*(std::size_t element)>;
  AssemblyLists(const BlockPattern& pattern, int nodes, const BlocksOf& blocks_of,
                const AssemblyOrder& order);

  [[nodiscard]] std::size_t row_count() const { return rows.size() - 1; }
  [[nodiscard]] std::size_t block_count() const { return row_count() + 2 * (edges.size() - 1); }
};

}  // namespace tandem::fem

#include "fem_process/fill_reducing_order.h"

#include <cholmod.h>

#include <algorithm>
#include <string>

#include "protocol/contract/error.h"

namespace tandem::fem {

std::vector<int> fill_reducing_order(const BlockPattern& pattern) {
  const auto n = static_cast<std::size_t>(pattern.rows());
  std::vector<int> order(n);
  std::vector<int> parent(n);
  std::vector<int> member(n);
  cholmod_common common{};
  cholmod_start(&common);
  common.print = 0;
  // The pattern is symmetric; the upper triangle by columns is read, the rest ignored.
  cholmod_sparse* graph =
      cholmod_allocate_sparse(n, n, pattern.blocks(), 1, 1, 1, CHOLMOD_PATTERN, &common);
  bool found = false;
  if (graph != nullptr) {
    std::copy(pattern.row_start.begin(), pattern.row_start.end(), static_cast<int*>(graph->p));
    std::copy(pattern.column.begin(), pattern.column.end(), static_cast<int*>(graph->i));
    found = cholmod_nested_dissection(graph, nullptr, 0, order.data(), parent.data(), member.data(),
                                      &common) >= 0 ||
            cholmod_amd(graph, nullptr, 0, order.data(), &common) != 0;
  }
  const int status = common.status;
  cholmod_free_sparse(&graph, &common);
  cholmod_finish(&common);
  require(found, "fem: CHOLMOD cannot order the step matrix (status " + std::to_string(status) +
                     "). Use a coarser mesh.");
  return order;
}

}  // namespace tandem::fem

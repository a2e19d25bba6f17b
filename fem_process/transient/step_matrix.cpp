#include "fem_process/transient/step_matrix.h"

#include "fem_process/kernels/simd.h"

namespace tandem::fem {
namespace {

/// Blocks that a thread takes at a time.
constexpr std::size_t kBlocksAtOnce = 2048;

TANDEM_INLINE void combine_body(const int* source, double m, const double* M, double k,
                                const double* K, double* S, std::size_t begin, std::size_t end) {
  const Double4 unit = {1.0, 0.0, 0.0, 0.0};
  for (std::size_t b = begin; b < end; ++b) {
    const double* from = K + 9 * static_cast<std::ptrdiff_t>(source[b]);
    double* to = S + 9 * b;
    const double mass = m * M[source[b]];
    const Double4 diagonal = mass * unit;
    Double4 low;
    Double4 high;
    load(low, from);
    load(high, from + 4);
    low = k * low + diagonal;
    high = k * high + diagonal;
    store(low, to);
    store(high, to + 4);
    to[8] = k * from[8] + mass;
  }
}

TANDEM_VECTOR_FUNCTION(combine_blocks, combine_body,
                       (const int* source, double m, const double* M, double k, const double* K,
                        double* S, std::size_t begin, std::size_t end),
                       (source, m, M, k, K, S, begin, end))

}  // namespace

void combine(const SubPattern& interior, double m, const std::vector<double>& M, double k,
             const BlockValues* K, BlockValues& S, ThreadTeam& team) {
  S.resize(9 * interior.source.size());
  const BlockValues none(K == nullptr ? 9 * M.size() : 0, 0.0);
  const double* const stiffness = K != nullptr ? K->data() : none.data();
  team.run_ranges(interior.source.size(), kBlocksAtOnce, [&](std::size_t begin, std::size_t end) {
    combine_blocks(interior.source.data(), m, M.data(), k, stiffness, S.data(), begin, end);
  });
}

}  // namespace tandem::fem

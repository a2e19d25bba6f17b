#include "fem_process/elements/tet4_assembly.h"

#include "fem_process/kernels/fetch_ahead.h"
#include "fem_process/kernels/isotropic_block.h"

namespace tandem::fem {
namespace {

/// Nodes that a thread takes at a time.
constexpr std::size_t kNodesAtOnce = 128;

/// Terms and corners of the lists whose vectors are asked for ahead, and bytes of the lists
/// themselves: the time of a line's way from memory.
constexpr std::size_t kTermsAhead = 48;
constexpr std::size_t kCornersAhead = 16;
constexpr std::ptrdiff_t kListAhead = 1024;

/// Terms up to which the vectors stay in the cache of a core, and asking costs more than it
/// saves.
constexpr std::size_t kNearTerms = 40000;

/// Asks for what a later term needs.
TANDEM_INLINE void fetch_term(const AssemblyLists& lists, std::size_t t, const Padded* c) {
  fetch_ahead(&lists.terms[t], kListAhead);
  const AssemblyLists::Term& later = lists.terms[std::min(t + kTermsAhead, lists.terms.size() - 1)];
  fetch_ahead(c[later.i].at, 0);
  fetch_ahead(c[later.j].at, 0);
}

/// Asks for the force of a later corner.
TANDEM_INLINE void fetch_corner(const AssemblyLists& lists, std::size_t k, const Padded* f) {
  const std::size_t later = std::min(k + kCornersAhead, lists.corners.size() - 1);
  fetch_ahead(f[lists.corners[later]].at, 0);
}

/// D += c_i c_jᵀ.
TANDEM_INLINE void add_product(const double* c_i, const double* c_j, Double4 (&D)[3]) {
  Double4 right;
  load(right, c_j);
  for (int r = 0; r < 3; ++r) D[r] += c_i[r] * right;
}

/// Rows [begin, end). `far`: of a mesh that the cache does not hold.
TANDEM_INLINE void gather_body(const AssemblyLists& lists, bool far, double lambda, double mu,
                               std::size_t begin, std::size_t end, const Padded* c, const Padded* f,
                               double* f_int, double* K) {
  for (std::size_t i = begin; i < end; ++i) {
    const AssemblyLists::Row& row = lists.rows[i];
    const AssemblyLists::Row& next = lists.rows[i + 1];
    Double4 force{};
    Double4 D[3] = {};
    for (int k = row.first_corner; k < next.first_corner; ++k) {
      if (far) fetch_corner(lists, static_cast<std::size_t>(k), f);
      const int corner = lists.corners[static_cast<std::size_t>(k)];
      Double4 f_e;
      load(f_e, f[corner].at);
      force += f_e;
      add_product(c[corner].at, c[corner].at, D);
    }
    double* const f_i = f_int + 3 * static_cast<std::ptrdiff_t>(row.node);
    for (int a = 0; a < 3; ++a) f_i[a] = force[a];
    store_stiffness(D, lambda, mu, K + 9 * static_cast<std::ptrdiff_t>(row.diagonal), nullptr);
    for (int e = row.first_edge; e < next.first_edge; ++e) {
      const AssemblyLists::Edge& edge = lists.edges[static_cast<std::size_t>(e)];
      Double4 sum[3] = {};
      const int last = lists.edges[static_cast<std::size_t>(e) + 1].first_term;
      for (int t = edge.first_term; t < last; ++t) {
        if (far) fetch_term(lists, static_cast<std::size_t>(t), c);
        const AssemblyLists::Term& term = lists.terms[static_cast<std::size_t>(t)];
        add_product(c[term.i].at, c[term.j].at, sum);
      }
      store_stiffness(sum, lambda, mu, K + 9 * static_cast<std::ptrdiff_t>(edge.upper),
                      K + 9 * static_cast<std::ptrdiff_t>(edge.lower));
    }
  }
}

TANDEM_VECTOR_FUNCTION(gather_rows, gather_body,
                       (const AssemblyLists& lists, bool far, double lambda, double mu,
                        std::size_t begin, std::size_t end, const Padded* c, const Padded* f,
                        double* f_int, double* K),
                       (lists, far, lambda, mu, begin, end, c, f, f_int, K))

}  // namespace

Tet4Assembly::Tet4Assembly(const std::vector<TetShape>& shapes, const std::vector<int>& slot,
                           const std::vector<int>& nodes, const BlockPattern& pattern,
                           double lambda, double mu)
    : lambda_(lambda),
      mu_(mu),
      lists_(pattern, 4, [&](std::size_t e) { return shapes[e].blocks.data(); },
             {.slot = slot, .nodes = nodes}) {}

void Tet4Assembly::gather(const std::vector<Padded>& c, const std::vector<Padded>& f,
                          Eigen::VectorXd& f_int, BlockValues& K, ThreadTeam& team) const {
  const std::size_t rows = lists_.row_count();
  f_int.resize(3 * static_cast<Eigen::Index>(rows));
  K.resize(9 * lists_.block_count());
  const bool far = lists_.terms.size() > kNearTerms;
  team.run_ranges(rows, kNodesAtOnce, [&](std::size_t begin, std::size_t end) {
    gather_rows(lists_, far, lambda_, mu_, begin, end, c.data(), f.data(), f_int.data(), K.data());
  });
}

}  // namespace tandem::fem

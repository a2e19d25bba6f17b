#include "fem_process/elements/tet10_assembly.h"

#include "fem_process/kernels/isotropic_block.h"

namespace tandem::fem {
namespace {

/// Nodes that a thread takes at a time.
constexpr std::size_t kGrain = 64;

/// c_i c_jᵀ, entry 3 a + b, added per point: the points are summed once a block.
TANDEM_INLINE void add_products(const FourVectors& c_i, const FourVectors& c_j, Double4 (&sum)[9]) {
  Double4 left[3];
  Double4 right[3];
  for (int a = 0; a < 3; ++a) {
    load(left[a], c_i.at[a]);
    load(right[a], c_j.at[a]);
  }
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) sum[3 * a + b] += left[a] * right[b];
  }
}

/// Rows of D.
TANDEM_INLINE void sum_points(const Double4 (&sum)[9], Double4 (&D)[3]) {
  for (int a = 0; a < 3; ++a) {
    Double4 p[4] = {sum[3 * a], sum[3 * a + 1], sum[3 * a + 2], Double4{}};
    transpose(p[0], p[1], p[2], p[3]);
    D[a] = (p[0] + p[1]) + (p[2] + p[3]);
  }
}

/// Rows [begin, end).
TANDEM_INLINE void gather_body(const AssemblyLists& lists, double lambda, double mu,
                               std::size_t begin, std::size_t end, const FourVectors* c,
                               const Padded* f, double* f_int, double* K) {
  for (std::size_t i = begin; i < end; ++i) {
    const AssemblyLists::Row& row = lists.rows[i];
    const AssemblyLists::Row& next = lists.rows[i + 1];
    Double4 force{};
    Double4 own[9] = {};
    Double4 D[3];
    for (int k = row.first_corner; k < next.first_corner; ++k) {
      const int corner = lists.corners[static_cast<std::size_t>(k)];
      Double4 f_e;
      load(f_e, f[corner].at);
      force += f_e;
      add_products(c[corner], c[corner], own);
    }
    for (int a = 0; a < 3; ++a) f_int[3 * i + static_cast<std::size_t>(a)] = force[a];
    sum_points(own, D);
    store_stiffness(D, lambda, mu, K + 9 * static_cast<std::ptrdiff_t>(row.diagonal), nullptr);
    for (int e = row.first_edge; e < next.first_edge; ++e) {
      const AssemblyLists::Edge& edge = lists.edges[static_cast<std::size_t>(e)];
      Double4 sum[9] = {};
      const int last = lists.edges[static_cast<std::size_t>(e) + 1].first_term;
      for (int t = edge.first_term; t < last; ++t) {
        const AssemblyLists::Term& term = lists.terms[static_cast<std::size_t>(t)];
        add_products(c[term.i], c[term.j], sum);
      }
      sum_points(sum, D);
      store_stiffness(D, lambda, mu, K + 9 * static_cast<std::ptrdiff_t>(edge.upper),
                      K + 9 * static_cast<std::ptrdiff_t>(edge.lower));
    }
  }
}

TANDEM_VECTOR_FUNCTION(gather_tet10_rows, gather_body,
                       (const AssemblyLists& lists, double lambda, double mu, std::size_t begin,
                        std::size_t end, const FourVectors* c, const Padded* f, double* f_int,
                        double* K),
                       (lists, lambda, mu, begin, end, c, f, f_int, K))

TANDEM_INLINE void gather_four_body(const AssemblyLists& lists, std::size_t begin, std::size_t end,
                                    const FourVectors* f, double* const* sums, std::size_t count) {
  for (std::size_t i = begin; i < end; ++i) {
    Double4 sum[3] = {};
    for (int k = lists.rows[i].first_corner; k < lists.rows[i + 1].first_corner; ++k) {
      const FourVectors& from = f[lists.corners[static_cast<std::size_t>(k)]];
      for (int a = 0; a < 3; ++a) {
        Double4 f_a;
        load(f_a, from.at[a]);
        sum[a] += f_a;
      }
    }
    for (std::size_t a = 0; a < 3; ++a) {
      double four[4];
      store(sum[a], four);
      for (std::size_t c = 0; c < count; ++c) sums[c][3 * i + a] = four[c];
    }
  }
}

TANDEM_VECTOR_FUNCTION(gather_four, gather_four_body,
                       (const AssemblyLists& lists, std::size_t begin, std::size_t end,
                        const FourVectors* f, double* const* sums, std::size_t count),
                       (lists, begin, end, f, sums, count))

}  // namespace

Tet10Assembly::Tet10Assembly(const std::vector<SolidElement<10>>& elements,
                             const BlockPattern& pattern, double lambda, double mu)
    : lambda_(lambda),
      mu_(mu),
      lists_(
          pattern, 10, [&](std::size_t e) { return elements[e].blocks.data(); },
          AssemblyOrder::of_mesh(elements.size(), pattern.rows())) {}

void Tet10Assembly::gather(const std::vector<FourVectors>& c, const std::vector<Padded>& f,
                           Eigen::VectorXd& f_int, BlockValues& K, ThreadTeam& team) const {
  const std::size_t rows = lists_.row_count();
  f_int.resize(3 * static_cast<Eigen::Index>(rows));
  K.resize(9 * lists_.block_count());
  team.run_ranges(rows, kGrain, [&](std::size_t begin, std::size_t end) {
    gather_tet10_rows(lists_, lambda_, mu_, begin, end, c.data(), f.data(), f_int.data(), K.data());
  });
}

void Tet10Assembly::gather_forces(const std::vector<FourVectors>& f, Eigen::MatrixXd& sums,
                                  Eigen::Index first, Eigen::Index count, ThreadTeam& team) const {
  double* columns[4] = {};
  for (Eigen::Index c = 0; c < count; ++c) columns[c] = sums.col(first + c).data();
  team.run_ranges(lists_.row_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    gather_four(lists_, begin, end, f.data(), columns, static_cast<std::size_t>(count));
  });
}

}  // namespace tandem::fem

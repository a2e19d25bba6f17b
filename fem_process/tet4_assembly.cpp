#include "fem_process/tet4_assembly.h"

namespace tandem::fem {
namespace {

/// Nodes that a thread takes at a time.
constexpr std::size_t kGrain = 128;

/// The block of three rows, 9 numbers; each row's fourth lane is thrown away.
TANDEM_INLINE void store_block(const Double4& a, const Double4& b, const Double4& c, double* to) {
  store(a, to);
  store(b, to + 3);
  // The last row with the number before it: no write behind the block.
  const Double4 last = __builtin_shufflevector(b, c, 2, 4, 5, 6);
  store(last, to + 5);
}

/// D += c_i c_jᵀ.
TANDEM_INLINE void add_product(const double* c_i, const double* c_j, Double4 (&D)[3]) {
  Double4 right;
  load(right, c_j);
  for (int r = 0; r < 3; ++r) D[r] += c_i[r] * right;
}

/// λ D + μ Dᵀ + μ tr D I into block `to`, its transpose into `transposed` unless that is null.
TANDEM_INLINE void store_stiffness(const Double4 (&D)[3], double lambda, double mu, double* to,
                                   double* transposed) {
  Double4 T[4] = {D[0], D[1], D[2], Double4{}};
  transpose(T[0], T[1], T[2], T[3]);
  const double trace = mu * (D[0][0] + D[1][1] + D[2][2]);
  const Double4 unit[3] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  Double4 K[3];
  for (int r = 0; r < 3; ++r) K[r] = lambda * D[r] + mu * T[r] + trace * unit[r];
  store_block(K[0], K[1], K[2], to);
  if (transposed == nullptr) return;
  for (int r = 0; r < 3; ++r) K[r] = lambda * T[r] + mu * D[r] + trace * unit[r];
  store_block(K[0], K[1], K[2], transposed);
}

/// Rows [begin, end).
TANDEM_INLINE void gather_body(const Tet4Assembly::Lists& lists, double lambda, double mu,
                               std::size_t begin, std::size_t end, const Padded* c, const Padded* f,
                               double* f_int, double* K) {
  for (std::size_t i = begin; i < end; ++i) {
    const Tet4Assembly::Row& row = lists.rows[i];
    const Tet4Assembly::Row& next = lists.rows[i + 1];
    Double4 force{};
    Double4 D[3] = {};
    for (int k = row.first_corner; k < next.first_corner; ++k) {
      const int corner = lists.corners[static_cast<std::size_t>(k)];
      Double4 f_e;
      load(f_e, f[corner].at);
      force += f_e;
      add_product(c[corner].at, c[corner].at, D);
    }
    for (int a = 0; a < 3; ++a) f_int[3 * i + static_cast<std::size_t>(a)] = force[a];
    store_stiffness(D, lambda, mu, K + 9 * static_cast<std::ptrdiff_t>(row.diagonal), nullptr);
    for (int e = row.first_edge; e < next.first_edge; ++e) {
      const Tet4Assembly::Edge& edge = lists.edges[static_cast<std::size_t>(e)];
      Double4 sum[3] = {};
      const int last = lists.edges[static_cast<std::size_t>(e) + 1].first_term;
      for (int t = edge.first_term; t < last; ++t) {
        const Tet4Assembly::Term& term = lists.terms[static_cast<std::size_t>(t)];
        add_product(c[term.i].at, c[term.j].at, sum);
      }
      store_stiffness(sum, lambda, mu, K + 9 * static_cast<std::ptrdiff_t>(edge.upper),
                      K + 9 * static_cast<std::ptrdiff_t>(edge.lower));
    }
  }
}

TANDEM_VECTOR_FUNCTION(gather_rows, gather_body,
                       (const Tet4Assembly::Lists& lists, double lambda, double mu,
                        std::size_t begin, std::size_t end, const Padded* c, const Padded* f,
                        double* f_int, double* K),
                       (lists, lambda, mu, begin, end, c, f, f_int, K))

}  // namespace

Tet4Assembly::Tet4Assembly(const std::vector<TetShape>& shapes, const BlockPattern& pattern,
                           double lambda, double mu)
    : lambda_(lambda), mu_(mu) {
  std::vector<std::vector<Term>> terms(pattern.blocks());
  for (std::size_t e = 0; e < shapes.size(); ++e) {
    for (int k = 0; k < 16; ++k) {
      const auto b = static_cast<std::size_t>(shapes[e].blocks[static_cast<std::size_t>(k)]);
      const int corner = 4 * static_cast<int>(e);
      terms[b].push_back({corner + k / 4, corner + k % 4});
    }
  }
  const auto end_of = [](const auto& list) { return static_cast<int>(list.size()); };
  for (int i = 0; i < pattern.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    const int diagonal = pattern.find(i, i);
    lists_.rows.push_back({diagonal, end_of(lists_.corners), end_of(lists_.edges)});
    for (const Term& term : terms[static_cast<std::size_t>(diagonal)]) {
      lists_.corners.push_back(term.i);
    }
    for (int b = diagonal + 1; b < pattern.row_start[row + 1]; ++b) {
      const auto at = static_cast<std::size_t>(b);
      lists_.edges.push_back({b, pattern.find(pattern.column[at], i), end_of(lists_.terms)});
      lists_.terms.insert(lists_.terms.end(), terms[at].begin(), terms[at].end());
    }
  }
  lists_.rows.push_back({0, end_of(lists_.corners), end_of(lists_.edges)});
  lists_.edges.push_back({0, 0, end_of(lists_.terms)});
}

void Tet4Assembly::gather(const std::vector<Padded>& c, const std::vector<Padded>& f,
                          Eigen::VectorXd& f_int, BlockValues& K, ThreadTeam& team) const {
  const std::size_t rows = lists_.rows.size() - 1;
  f_int.resize(3 * static_cast<Eigen::Index>(rows));
  K.resize(9 * (rows + 2 * (lists_.edges.size() - 1)));
  team.run_ranges(rows, kGrain, [&](std::size_t begin, std::size_t end) {
    gather_rows(lists_, lambda_, mu_, begin, end, c.data(), f.data(), f_int.data(), K.data());
  });
}

}  // namespace tandem::fem

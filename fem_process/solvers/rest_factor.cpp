#include "fem_process/solvers/rest_factor.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem_process/solvers/elimination_parts.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

/// What a thread takes of a panel of the top at a time; smaller panels are not worth a division.
constexpr int kTilesAtOnce = 8;
constexpr int kEntriesWorthSharing = 16384;

using Float4 = float __attribute__((vector_size(16)));

/// y = d Wᵀ r of the part's nodes, three numbers each; the fourth is overwritten by the next node.
TANDEM_INLINE void load_body(const int* nodes, std::size_t count, const Padded* r,
                             const double* inverse_root, double scale,
                             const NodeRotation* rotations, float* y) {
  for (std::size_t k = 0; k < count; ++k) {
    const int node = nodes[k];
    const double d = scale * inverse_root[node];
    Float4 sum{};
    for (int a = 0; a < 3; ++a) {
      Float4 row{};
      if (rotations != nullptr) {
        load(row, rotations[node].row[a]);
      } else {
        row[a] = 1.0F;
      }
      sum += static_cast<float>(d * r[node].at[a]) * row;
    }
    for (int a = 0; a < 3; ++a) y[3 * k + static_cast<std::size_t>(a)] = sum[a];
  }
}

/// z = d W y, and the sum of r · z.
TANDEM_INLINE void store_body(const int* nodes, std::size_t count, const Padded* r,
                              const double* inverse_root, double size,
                              const NodeRotation* rotations, const float* y, Padded* z,
                              double& product) {
  Double4 sums{};
  for (std::size_t k = 0; k < count; ++k) {
    const int node = nodes[k];
    const double d = size * inverse_root[node];
    Float4 sum{};
    for (std::size_t a = 0; a < 3; ++a) {
      Float4 column{};
      if (rotations != nullptr) {
        load(column, rotations[node].column[a]);
      } else {
        column[a] = 1.0F;
      }
      sum += y[3 * k + a] * column;
    }
    const Double4 z_i = d * __builtin_convertvector(sum, Double4);
    Double4 r_i;
    load(r_i, r[node].at);
    store(z_i, z[node].at);
    sums += r_i * z_i;
  }
  product = (sums[0] + sums[1]) + sums[2];
}

TANDEM_VECTOR_FUNCTION(load_all, load_body,
                       (const int* nodes, std::size_t count, const Padded* r,
                        const double* inverse_root, double scale, const NodeRotation* rotations,
                        float* y),
                       (nodes, count, r, inverse_root, scale, rotations, y))
TANDEM_VECTOR_FUNCTION(store_all, store_body,
                       (const int* nodes, std::size_t count, const Padded* r,
                        const double* inverse_root, double size, const NodeRotation* rotations,
                        const float* y, Padded* z, double& product),
                       (nodes, count, r, inverse_root, size, rotations, y, z, product))

/// [L₁₁⁻¹; −L₂₁ L₁₁⁻¹] of the factor of D A₀ D, D = diag(1/root).
Eigen::MatrixXd panel_of(const SupernodalFactor& factor, std::size_t s,
                         const std::vector<double>& root) {
  const Eigen::Index columns = factor.first_column[s + 1] - factor.first_column[s];
  const Eigen::Index rows = factor.row_start[s + 1] - factor.row_start[s];
  const Eigen::Index below = rows - columns;
  Eigen::MatrixXd L =
      Eigen::Map<const Eigen::MatrixXd>(factor.value.data() + factor.value_start[s], rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const int row = factor.row[static_cast<std::size_t>(factor.row_start[s] + i)];
    const int of = factor.permutation[static_cast<std::size_t>(row)];
    L.row(i) /= root[static_cast<std::size_t>(of) / 3];
  }
  Eigen::MatrixXd P(rows, columns);
  P.topRows(columns) = L.topRows(columns).triangularView<Eigen::Lower>().solve(
      Eigen::MatrixXd::Identity(columns, columns));
  P.bottomRows(below).noalias() = -L.bottomRows(below) * P.topRows(columns);
  return P;
}

/// Up to whole tiles.
int whole_tiles(int count) {
  return (count + FactorPanels::kTile - 1) / FactorPanels::kTile * FactorPanels::kTile;
}

}  // namespace

RestFactor::RestFactor(const BlockPattern& pattern, const BlockValues& A) {
  CholmodSolver solver(pattern);
  const SolveReport report = solver.factorize(A);
  require(report.outcome == Outcome::Done,
          "fem: the preconditioner rest_factor: at the reference positions " + report.message);
  const SupernodalFactor factor = solver.factor();
  std::vector<double> root;
  for (int i = 0; i < pattern.rows(); ++i) {
    root.push_back(std::sqrt(block(A, pattern.find(i, i)).trace() / 3.0));
    inverse_root_.push_back(1.0 / root.back());
  }
  const EliminationParts cut_parts = cut(factor);
  std::vector<int> position(factor.permutation.size(), -1);
  place(factor, cut_parts.top, position, top_);
  top_size_ = size_;
  add_panels(factor, cut_parts.top, root, position, top_);
  for (const std::vector<int>& supernodes : cut_parts.parts) {
    Part& part = parts_.emplace_back();
    place(factor, supernodes, position, part);
    add_panels(factor, supernodes, root, position, part);
  }
}

/// Gives the columns of the supernodes their positions.
void RestFactor::place(const SupernodalFactor& factor, const std::vector<int>& supernodes,
                       std::vector<int>& position, Part& part) {
  part.first = size_;
  for (int s : supernodes) {
    const auto at = static_cast<std::size_t>(s);
    for (int column = factor.first_column[at]; column < factor.first_column[at + 1]; ++column) {
      const auto c = static_cast<std::size_t>(column);
      position[c] = size_++;
      if (factor.permutation[c] % 3 == 0) part.nodes.push_back(factor.permutation[c] / 3);
    }
  }
  require(size_ - part.first == 3 * static_cast<int>(part.nodes.size()),
          "fem: the preconditioner rest_factor needs the unknowns of a node side by side.");
}

void RestFactor::add_panels(const SupernodalFactor& factor, const std::vector<int>& supernodes,
                            const std::vector<double>& root, const std::vector<int>& position,
                            Part& part) {
  std::vector<int> sum_of(static_cast<std::size_t>(top_size_), -1);  // of a position in the top
  for (int s : supernodes) {
    const auto at = static_cast<std::size_t>(s);
    Supernode& supernode = part.supernodes.emplace_back();
    supernode.panel = panels_.add(panel_of(factor, at, root));
    supernode.first = position[static_cast<std::size_t>(factor.first_column[at])];
    supernode.below = row_.size();
    most_columns_ = std::max(most_columns_, supernode.panel.columns + 1);
    most_rows_ = std::max(most_rows_, whole_tiles(supernode.panel.rows));
    const int first_below = factor.row_start[at] + supernode.panel.columns;
    for (int k = first_below; k < factor.row_start[at + 1]; ++k) {
      const int place = position[static_cast<std::size_t>(factor.row[static_cast<std::size_t>(k)])];
      if (&part == &top_ || place >= top_size_) {
        row_.push_back(place);
        continue;
      }
      int& sum = sum_of[static_cast<std::size_t>(place)];
      if (sum < 0) {
        sum = size_++;
        part.above.push_back(place);
      }
      row_.push_back(sum);
    }
  }
}

void RestFactor::forward(const Supernode& supernode, const float* scaled, int begin, int end,
                         float* y, float* rows) const {
  const FactorPanels::Panel& panel = supernode.panel;
  panels_.multiply(panel, scaled, begin, end, rows);
  const int last = std::min(end * FactorPanels::kTile, panel.rows);
  int i = begin * FactorPanels::kTile;
  for (; i < last && i < panel.columns; ++i) y[supernode.first + i] = rows[i];
  const int* position = row_.data() + supernode.below;
  for (; i < last; ++i) y[position[i - panel.columns]] += rows[i];
}

void RestFactor::gather_rows(const Supernode& supernode, const float* y, float* rows) const {
  const FactorPanels::Panel& panel = supernode.panel;
  std::copy(y + supernode.first, y + supernode.first + panel.columns, rows);
  const int* position = row_.data() + supernode.below;
  for (int i = panel.columns; i < panel.rows; ++i) rows[i] = y[position[i - panel.columns]];
  std::fill(rows + panel.rows, rows + whole_tiles(panel.rows), 0.0F);
}

void RestFactor::solve_top(float* y, float* columns, float* rows, ThreadTeam& team) const {
  const auto divided = [](const FactorPanels::Panel& panel, int count, int grain) {
    return panel.columns * panel.rows < kEntriesWorthSharing ? 1 : (count + grain - 1) / grain;
  };
  for (const Supernode& supernode : top_.supernodes) {
    const FactorPanels::Panel& panel = supernode.panel;
    panels_.scale(panel, y + supernode.first, columns);
    const int pieces = divided(panel, panel.tiles(), kTilesAtOnce);
    team.run(pieces, [&](int k) {
      forward(supernode, columns, k * kTilesAtOnce,
              k + 1 == pieces ? panel.tiles() : (k + 1) * kTilesAtOnce, y, rows);
    });
  }
  for (auto at = top_.supernodes.rbegin(); at != top_.supernodes.rend(); ++at) {
    const FactorPanels::Panel& panel = at->panel;
    gather_rows(*at, y, rows);
    const int pieces = divided(panel, panel.pairs(), FactorPanels::kPairs);
    team.run(pieces, [&](int k) {
      panels_.multiply_transposed(panel, rows, k * FactorPanels::kPairs,
                                  k + 1 == pieces ? panel.pairs() : (k + 1) * FactorPanels::kPairs,
                                  y + at->first);
    });
  }
}

double RestFactor::solve(const std::vector<Padded>& r, double r_norm,
                         const std::vector<NodeRotation>& rotations, std::vector<Padded>& z,
                         Scratch& scratch, ThreadTeam& team) const {
  const int parts = static_cast<int>(parts_.size());
  const int work_size = whole_tiles(most_columns_) + most_rows_;
  scratch.y.resize(static_cast<std::size_t>(size_));
  scratch.work.resize(static_cast<std::size_t>(work_size) * static_cast<std::size_t>(parts + 1));
  scratch.products.resize(static_cast<std::size_t>(parts) + 1);
  float* const y = scratch.y.data();
  const NodeRotation* const turned = rotations.empty() ? nullptr : rotations.data();
  const double size = r_norm > 0.0 ? r_norm : 1.0;
  const auto columns_of = [&](int k) { return scratch.work.data() + k * work_size; };
  const auto rows_of = [&](int k) { return columns_of(k) + whole_tiles(most_columns_); };
  const auto enter = [&](const Part& part) {
    load_all(part.nodes.data(), part.nodes.size(), r.data(), inverse_root_.data(), 1.0 / size,
             turned, y + part.first);
  };
  const auto leave = [&](const Part& part, double& product) {
    store_all(part.nodes.data(), part.nodes.size(), r.data(), inverse_root_.data(), size, turned,
              y + part.first, z.data(), product);
  };

  team.run(parts, [&](int k) {
    const Part& part = parts_[static_cast<std::size_t>(k)];
    enter(part);
    float* const sums = y + part.first + 3 * part.nodes.size();
    std::fill(sums, sums + part.above.size(), 0.0F);
    for (const Supernode& supernode : part.supernodes) {
      panels_.scale(supernode.panel, y + supernode.first, columns_of(k));
      forward(supernode, columns_of(k), 0, supernode.panel.tiles(), y, rows_of(k));
    }
  });
  enter(top_);
  for (const Part& part : parts_) {
    const float* const sums = y + part.first + 3 * part.nodes.size();
    for (std::size_t i = 0; i < part.above.size(); ++i) y[part.above[i]] += sums[i];
  }
  solve_top(y, columns_of(parts), rows_of(parts), team);
  team.run(parts, [&](int k) {
    const Part& part = parts_[static_cast<std::size_t>(k)];
    float* const sums = y + part.first + 3 * part.nodes.size();
    for (std::size_t i = 0; i < part.above.size(); ++i) sums[i] = y[part.above[i]];
    for (auto at = part.supernodes.rbegin(); at != part.supernodes.rend(); ++at) {
      gather_rows(*at, y, rows_of(k));
      panels_.multiply_transposed(at->panel, rows_of(k), 0, at->panel.pairs(), y + at->first);
    }
    leave(part, scratch.products[static_cast<std::size_t>(k)]);
  });
  leave(top_, scratch.products.back());
  return std::accumulate(scratch.products.begin(), scratch.products.end(), 0.0);
}

}  // namespace tandem::fem

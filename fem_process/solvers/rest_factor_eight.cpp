#include <algorithm>

#include "fem_process/kernels/simd.h"
#include "fem_process/solvers/rest_factor.h"

namespace tandem::fem {
namespace {

/// Vectors side by side.
constexpr int kWidth = 8;
/// Of a panel of the top, as for one vector.
constexpr int kTilesAtOnce = 8;
constexpr int kEntriesWorthSharing = 16384;

using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));

/// y = d Wᵀ r of the part's nodes, three unknowns each, each vector times its own `scale`.
TANDEM_INLINE void load_body(const int* nodes, std::size_t count, const double* r,
                             const double* inverse_root, const double* scale,
                             const NodeRotation* rotations, float* y) {
  for (std::size_t k = 0; k < count; ++k) {
    const auto node = static_cast<std::size_t>(nodes[k]);
    for (std::size_t half = 0; half < 2; ++half) {
      Double4 factor;
      load(factor, scale + 4 * half);
      factor = inverse_root[node] * factor;
      Float4 value[3];
      for (std::size_t a = 0; a < 3; ++a) {
        Double4 r_a;
        load(r_a, r + kWidth * (3 * node + a) + 4 * half);
        r_a = factor * r_a;
        value[a] = __builtin_convertvector(r_a, Float4);
      }
      for (std::size_t b = 0; b < 3; ++b) {
        Float4 turned = value[b];
        if (rotations != nullptr) {
          const NodeRotation& R = rotations[node];
          turned = R.row[0][b] * value[0] + R.row[1][b] * value[1] + R.row[2][b] * value[2];
        }
        store(turned, y + kWidth * (3 * k + b) + 4 * half);
      }
    }
  }
}

/// z = d W y, and the sums of r · z.
TANDEM_INLINE void store_body(const int* nodes, std::size_t count, const double* r,
                              const double* inverse_root, const double* size,
                              const NodeRotation* rotations, const float* y, double* z,
                              double* products) {
  Double4 sums[2] = {};
  for (std::size_t k = 0; k < count; ++k) {
    const auto node = static_cast<std::size_t>(nodes[k]);
    for (std::size_t half = 0; half < 2; ++half) {
      Double4 factor;
      load(factor, size + 4 * half);
      factor = inverse_root[node] * factor;
      Float4 value[3];
      for (std::size_t a = 0; a < 3; ++a) load(value[a], y + kWidth * (3 * k + a) + 4 * half);
      for (std::size_t b = 0; b < 3; ++b) {
        Float4 turned = value[b];
        if (rotations != nullptr) {
          const NodeRotation& R = rotations[node];
          turned =
              R.column[0][b] * value[0] + R.column[1][b] * value[1] + R.column[2][b] * value[2];
        }
        const std::size_t at = kWidth * (3 * node + b) + 4 * half;
        const Double4 z_b = factor * __builtin_convertvector(turned, Double4);
        Double4 r_b;
        load(r_b, r + at);
        store(z_b, z + at);
        sums[half] += r_b * z_b;
      }
    }
  }
  store(sums[0], products);
  store(sums[1], products + 4);
}

TANDEM_VECTOR_FUNCTION(load_eight, load_body,
                       (const int* nodes, std::size_t count, const double* r,
                        const double* inverse_root, const double* scale,
                        const NodeRotation* rotations, float* y),
                       (nodes, count, r, inverse_root, scale, rotations, y))
TANDEM_VECTOR_FUNCTION(store_eight, store_body,
                       (const int* nodes, std::size_t count, const double* r,
                        const double* inverse_root, const double* size,
                        const NodeRotation* rotations, const float* y, double* z, double* products),
                       (nodes, count, r, inverse_root, size, rotations, y, z, products))

/// to += from, eight numbers.
TANDEM_INLINE void add_eight(const float* from, float* to) {
  Float8 a;
  Float8 b;
  load(a, from);
  load(b, to);
  a += b;
  store(a, to);
}

TANDEM_INLINE void copy_eight(const float* from, float* to) {
  Float8 a;
  load(a, from);
  store(a, to);
}

int whole_tiles(int count) {
  return (count + FactorPanels::kTile - 1) / FactorPanels::kTile * FactorPanels::kTile;
}

}  // namespace

void RestFactor::forward_eight(const Supernode& supernode, const float* scaled, int vectors,
                               int begin, int end, float* y, float* rows) const {
  const FactorPanels::Panel& panel = supernode.panel;
  panels_.multiply_eight(panel, scaled, vectors, begin, end, rows);
  const int last = std::min(end * FactorPanels::kTile, panel.rows);
  int i = begin * FactorPanels::kTile;
  for (; i < last && i < panel.columns; ++i) {
    copy_eight(rows + kWidth * i, y + kWidth * (supernode.first + i));
  }
  const int* position = row_.data() + supernode.below;
  for (; i < last; ++i) add_eight(rows + kWidth * i, y + kWidth * position[i - panel.columns]);
}

void RestFactor::gather_tiles(const Supernode& supernode, const float* y, float* rows,
                              float* tiles) const {
  const FactorPanels::Panel& panel = supernode.panel;
  const float* own = y + kWidth * supernode.first;
  std::copy(own, own + kWidth * panel.columns, rows);
  const int* position = row_.data() + supernode.below;
  for (int i = panel.columns; i < panel.rows; ++i) {
    copy_eight(y + kWidth * position[i - panel.columns], rows + kWidth * i);
  }
  std::fill(rows + kWidth * panel.rows, rows + kWidth * whole_tiles(panel.rows), 0.0F);
  FactorPanels::lay_out_tiles(rows, panel.rows, tiles);
}

void RestFactor::solve_top_eight(int vectors, float* y, float* columns, float* rows, float* tiles,
                                 ThreadTeam& team) const {
  const auto divided = [](const FactorPanels::Panel& panel, int count, int grain) {
    return panel.columns * panel.rows < kEntriesWorthSharing ? 1 : (count + grain - 1) / grain;
  };
  for (const Supernode& supernode : top_.supernodes) {
    const FactorPanels::Panel& panel = supernode.panel;
    panels_.scale_eight(panel, y + kWidth * supernode.first, columns);
    const int pieces = divided(panel, panel.tiles(), kTilesAtOnce);
    team.run(pieces, [&](int k) {
      forward_eight(supernode, columns, vectors, k * kTilesAtOnce,
                    k + 1 == pieces ? panel.tiles() : (k + 1) * kTilesAtOnce, y, rows);
    });
  }
  for (auto at = top_.supernodes.rbegin(); at != top_.supernodes.rend(); ++at) {
    const FactorPanels::Panel& panel = at->panel;
    gather_tiles(*at, y, rows, tiles);
    const int pieces = divided(panel, panel.pairs(), FactorPanels::kPairs);
    team.run(pieces, [&](int k) {
      panels_.multiply_transposed_eight(
          panel, tiles, vectors, k * FactorPanels::kPairs,
          k + 1 == pieces ? panel.pairs() : (k + 1) * FactorPanels::kPairs, y + kWidth * at->first);
    });
  }
}

RestFactor::Eight RestFactor::solve_eight(const EightVectors& r, const Eight& r_norms, int vectors,
                                          const std::vector<NodeRotation>& rotations,
                                          EightVectors& z, Scratch& scratch,
                                          ThreadTeam& team) const {
  const int parts = static_cast<int>(parts_.size());
  const int columns_size = kWidth * whole_tiles(most_columns_);
  const int work_size = columns_size + 2 * kWidth * most_rows_;
  scratch.y.resize(static_cast<std::size_t>(kWidth * size_));
  scratch.work.resize(static_cast<std::size_t>(work_size) * static_cast<std::size_t>(parts + 1));
  scratch.products.resize(kWidth * (static_cast<std::size_t>(parts) + 1));
  z.resize(kWidth, r.cols());
  float* const y = scratch.y.data();
  const NodeRotation* const turned = rotations.empty() ? nullptr : rotations.data();
  const Eight size = (r_norms > 0.0).select(r_norms, Eight::Ones());
  const Eight scale = size.inverse();
  const auto columns_of = [&](int k) { return scratch.work.data() + k * work_size; };
  const auto rows_of = [&](int k) { return columns_of(k) + columns_size; };
  const auto tiles_of = [&](int k) { return rows_of(k) + kWidth * most_rows_; };
  const auto enter = [&](const Part& part) {
    load_eight(part.nodes.data(), part.nodes.size(), r.data(), inverse_root_.data(), scale.data(),
               turned, y + kWidth * part.first);
  };
  const auto leave = [&](const Part& part, int k) {
    store_eight(part.nodes.data(), part.nodes.size(), r.data(), inverse_root_.data(), size.data(),
                turned, y + kWidth * part.first, z.data(), scratch.products.data() + kWidth * k);
  };
  const auto sums_of = [&](const Part& part) {
    return y + kWidth * (static_cast<std::size_t>(part.first) + 3 * part.nodes.size());
  };

  team.run(parts, [&](int k) {
    const Part& part = parts_[static_cast<std::size_t>(k)];
    enter(part);
    std::fill_n(sums_of(part), kWidth * part.above.size(), 0.0F);
    for (const Supernode& supernode : part.supernodes) {
      panels_.scale_eight(supernode.panel, y + kWidth * supernode.first, columns_of(k));
      forward_eight(supernode, columns_of(k), vectors, 0, supernode.panel.tiles(), y, rows_of(k));
    }
  });
  enter(top_);
  for (const Part& part : parts_) {
    for (std::size_t i = 0; i < part.above.size(); ++i) {
      add_eight(sums_of(part) + kWidth * i, y + kWidth * part.above[i]);
    }
  }
  solve_top_eight(vectors, y, columns_of(parts), rows_of(parts), tiles_of(parts), team);
  team.run(parts, [&](int k) {
    const Part& part = parts_[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < part.above.size(); ++i) {
      copy_eight(y + kWidth * part.above[i], sums_of(part) + kWidth * i);
    }
    for (auto at = part.supernodes.rbegin(); at != part.supernodes.rend(); ++at) {
      gather_tiles(*at, y, rows_of(k), tiles_of(k));
      panels_.multiply_transposed_eight(at->panel, tiles_of(k), vectors, 0, at->panel.pairs(),
                                        y + kWidth * at->first);
    }
    leave(part, k);
  });
  leave(top_, parts);
  Eight product = Eight::Zero();
  for (int k = 0; k <= parts; ++k) {
    product += Eigen::Map<const Eight>(scratch.products.data() + kWidth * k);
  }
  return product;
}

}  // namespace tandem::fem

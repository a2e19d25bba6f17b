#include "fem_process/solvers/rest_multigrid.h"

#include <algorithm>
#include <numeric>

#include "fem_process/kernels/fetch_ahead.h"
#include "fem_process/kernels/simd.h"

namespace tandem::fem {
namespace {

using Float4 = float __attribute__((vector_size(16)));

/// Nodes that a thread takes, and whose products are summed, at a time.
constexpr std::size_t kGrain = 256;
/// Of the first lattice, in mean edges. On a lug of 100k tets 1.5, 2, 2.5, 3
/// take 5.5, 6.5, 7.7, 9.2 iterations; a denser lattice costs more than it saves.
constexpr double kSpacing = 2.0;
/// Vectors of a level: residual, solution, what the forward sweep leaves.
constexpr int kVectors = 3;
enum Vector { kResidual, kSolution, kLeft };

/// Places ahead whose nodes' vectors and rotations are asked for.
constexpr std::size_t kPlacesAhead = 12;

/// y = d Wᵀ r of the nodes.
TANDEM_INLINE void enter_body(const int* nodes, const double* root, std::size_t begin,
                              std::size_t end, const Padded* r, double scale,
                              const NodeRotation* rotations, Padded4* y) {
  for (std::size_t p = begin; p < end; ++p) {
    const int node = nodes[p];
    const int later = nodes[std::min(p + kPlacesAhead, end - 1)];
    fetch_ahead(r[later].at, 0);
    if (rotations != nullptr) fetch_ahead(rotations[later].row, 0);
    const double d = scale / root[p];
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
    store(sum, y[p].at);
  }
}

/// z = d W y, and the sum of r · z.
TANDEM_INLINE void leave_body(const int* nodes, const double* root, std::size_t begin,
                              std::size_t end, const Padded* r, double size,
                              const NodeRotation* rotations, const Padded4* y, Padded* z,
                              double& product) {
  Double4 sums{};
  for (std::size_t p = begin; p < end; ++p) {
    const int node = nodes[p];
    const int later = nodes[std::min(p + kPlacesAhead, end - 1)];
    fetch_ahead(r[later].at, 0);
    fetch_ahead(z[later].at, 0);
    if (rotations != nullptr) fetch_ahead(rotations[later].column, 0);
    Float4 sum{};
    for (std::size_t a = 0; a < 3; ++a) {
      Float4 column{};
      if (rotations != nullptr) {
        load(column, rotations[node].column[a]);
      } else {
        column[a] = 1.0F;
      }
      sum += y[p].at[a] * column;
    }
    const Double4 z_i = (size / root[p]) * __builtin_convertvector(sum, Double4);
    Double4 r_i;
    load(r_i, r[node].at);
    store(z_i, z[node].at);
    sums += r_i * z_i;
  }
  product = (sums[0] + sums[1]) + sums[2];
}

/// Σ weight x of what hangs on each place, from start[p] to start[p + 1].
TANDEM_INLINE void restrict_body(const int* start, const RestMultigrid::Hanging* hangs,
                                 std::size_t begin, std::size_t end, const Padded4* x, Padded4* y) {
  for (std::size_t p = begin; p < end; ++p) {
    Float4 sum{};
    for (int k = start[p]; k < start[p + 1]; ++k) {
      Float4 from;
      load(from, x[hangs[k].node].at);
      sum += hangs[k].weight * from;
    }
    store(sum, y[p].at);
  }
}

/// y += Σ weight x of each place's eight corners.
TANDEM_INLINE void prolong_body(const RestMultigrid::Hanging* corners, std::size_t begin,
                                std::size_t end, const Padded4* x, Padded4* y) {
  for (std::size_t p = begin; p < end; ++p) {
    Float4 sum;
    load(sum, y[p].at);
    for (std::size_t c = 8 * p; c < 8 * p + 8; ++c) {
      Float4 from;
      load(from, x[corners[c].node].at);
      sum += corners[c].weight * from;
    }
    store(sum, y[p].at);
  }
}

TANDEM_VECTOR_FUNCTION(enter, enter_body,
                       (const int* nodes, const double* root, std::size_t begin, std::size_t end,
                        const Padded* r, double scale, const NodeRotation* rotations, Padded4* y),
                       (nodes, root, begin, end, r, scale, rotations, y))
TANDEM_VECTOR_FUNCTION(leave, leave_body,
                       (const int* nodes, const double* root, std::size_t begin, std::size_t end,
                        const Padded* r, double size, const NodeRotation* rotations,
                        const Padded4* y, Padded* z, double& product),
                       (nodes, root, begin, end, r, size, rotations, y, z, product))
TANDEM_VECTOR_FUNCTION(restrict_to, restrict_body,
                       (const int* start, const RestMultigrid::Hanging* hangs, std::size_t begin,
                        std::size_t end, const Padded4* x, Padded4* y),
                       (start, hangs, begin, end, x, y))
TANDEM_VECTOR_FUNCTION(prolong, prolong_body,
                       (const RestMultigrid::Hanging* corners, std::size_t begin, std::size_t end,
                        const Padded4* x, Padded4* y),
                       (corners, begin, end, x, y))

}  // namespace

RestMultigrid::RestMultigrid(const BlockPattern& pattern, const BlockValues& A,
                             const std::vector<Eigen::Vector3d>& positions,
                             std::size_t factorised) {
  double spacing = kSpacing * mean_edge(pattern, positions);
  auto smoother = std::make_unique<GaussSeidel>(pattern, A, near_order(positions));
  std::vector<Eigen::Vector3d> at = positions;
  BlockPattern coarse_pattern;
  BlockValues coarse_A;
  while (smoother != nullptr) {
    const Lattice lattice(at, spacing);
    BlockPattern next_pattern;
    BlockValues next_A;
    const bool finest = levels_.empty();
    lattice.project(finest ? pattern : coarse_pattern, finest ? A : coarse_A, next_pattern, next_A);
    coarse_pattern = std::move(next_pattern);
    coarse_A = std::move(next_A);
    at = lattice.positions();
    std::unique_ptr<GaussSeidel> next;
    if (at.size() > factorised && 2 * at.size() < smoother->nodes()) {
      next = std::make_unique<GaussSeidel>(coarse_pattern, coarse_A, near_order(at));
    }
    add_level(std::move(smoother), lattice, next.get());
    smoother = std::move(next);
    spacing *= 2.0;
  }
  coarsest_ = std::make_unique<RestFactor>(coarse_pattern, coarse_A);
  coarsest_nodes_ = at.size();
  coarsest_first_ = scratch_size_;
  scratch_size_ += 2 * coarsest_nodes_;
}

/// A level above a lattice, whose smoother is `next` (null: it is factorised as it is).
void RestMultigrid::add_level(std::unique_ptr<GaussSeidel> smoother, const Lattice& lattice,
                              const GaussSeidel* next) {
  const std::size_t count = lattice.positions().size();
  std::vector<int> place(count);
  if (next == nullptr) {
    std::iota(place.begin(), place.end(), 0);
  } else {
    for (std::size_t p = 0; p < count; ++p) {
      place[static_cast<std::size_t>(next->order()[p])] = static_cast<int>(p);
    }
  }
  Level& level = levels_.emplace_back();
  level.smoother = std::move(smoother);
  level.first = scratch_size_;
  scratch_size_ += kVectors * level.smoother->nodes();
  const std::vector<int>& order = level.smoother->order();
  std::vector<std::vector<Hanging>> hangs(count);
  for (std::size_t p = 0; p < order.size(); ++p) {
    const Lattice::Corners& corners = lattice.corners()[static_cast<std::size_t>(order[p])];
    for (std::size_t c = 0; c < 8; ++c) {
      const int to = place[static_cast<std::size_t>(corners.node[c])];
      const auto at = static_cast<std::size_t>(to);
      const double root = next != nullptr ? next->root()[at] : 1.0;
      const auto weight = static_cast<float>(corners.weight[c] * level.smoother->root()[p] / root);
      level.corners.push_back({to, weight});
      if (weight > 0.0F) hangs[at].push_back({static_cast<int>(p), weight});
    }
  }
  level.hang_start.push_back(0);
  for (const std::vector<Hanging>& list : hangs) {
    level.hangs.insert(level.hangs.end(), list.begin(), list.end());
    level.hang_start.push_back(static_cast<int>(level.hangs.size()));
  }
}

Padded4* RestMultigrid::vector(const Level& level, int which, Scratch& scratch) const {
  return scratch.levels.data() + level.first +
         static_cast<std::size_t>(which) * level.smoother->nodes();
}

void RestMultigrid::solve_coarsest(const Level& above, Scratch& scratch, ThreadTeam& team) const {
  Padded4* const r = scratch.levels.data() + coarsest_first_;
  Padded4* const x = r + coarsest_nodes_;
  const Padded4* const left = vector(above, kLeft, scratch);
  scratch.coarse_residual.resize(coarsest_nodes_);
  scratch.coarse_solution.resize(coarsest_nodes_);
  team.run_ranges(coarsest_nodes_, kGrain, [&](std::size_t begin, std::size_t end) {
    restrict_to(above.hang_start.data(), above.hangs.data(), begin, end, left, r);
    for (std::size_t p = begin; p < end; ++p) {
      for (int a = 0; a < 3; ++a) scratch.coarse_residual[p].at[a] = r[p].at[a];
    }
  });
  coarsest_->solve(scratch.coarse_residual, 1.0, {}, scratch.coarse_solution, scratch, team);
  Padded4* const solution = vector(above, kSolution, scratch);
  team.run_ranges(coarsest_nodes_, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      for (int a = 0; a < 3; ++a) {
        x[p].at[a] = static_cast<float>(scratch.coarse_solution[p].at[a]);
      }
      x[p].at[3] = 0.0F;
    }
  });
  team.run_ranges(above.smoother->nodes(), kGrain, [&](std::size_t begin, std::size_t end) {
    prolong(above.corners.data(), begin, end, x, solution);
  });
}

void RestMultigrid::cycle(std::size_t k, Scratch& scratch, ThreadTeam& team) const {
  const Level& level = levels_[k];
  Padded4* const r = vector(level, kResidual, scratch);
  Padded4* const x = vector(level, kSolution, scratch);
  Padded4* const left = vector(level, kLeft, scratch);
  level.smoother->forward(r, x, team);
  level.smoother->residual(x, left, team);
  if (k + 1 == levels_.size()) {
    solve_coarsest(level, scratch, team);
  } else {
    const Level& next = levels_[k + 1];
    Padded4* const next_r = vector(next, kResidual, scratch);
    team.run_ranges(next.smoother->nodes(), kGrain, [&](std::size_t begin, std::size_t end) {
      restrict_to(level.hang_start.data(), level.hangs.data(), begin, end, left, next_r);
    });
    cycle(k + 1, scratch, team);
    const Padded4* const next_x = vector(next, kSolution, scratch);
    team.run_ranges(level.smoother->nodes(), kGrain, [&](std::size_t begin, std::size_t end) {
      prolong(level.corners.data(), begin, end, next_x, x);
    });
  }
  level.smoother->backward(r, x, team);
}

double RestMultigrid::solve(const std::vector<Padded>& r, double r_norm,
                            const std::vector<NodeRotation>& rotations, std::vector<Padded>& z,
                            Scratch& scratch, ThreadTeam& team) const {
  scratch.levels.resize(scratch_size_);
  const NodeRotation* const turned = rotations.empty() ? nullptr : rotations.data();
  const double size = r_norm > 0.0 ? r_norm : 1.0;
  const GaussSeidel& finest = *levels_.front().smoother;
  const std::size_t nodes = finest.nodes();
  Padded4* const level_r = vector(levels_.front(), kResidual, scratch);
  const Padded4* const level_x = vector(levels_.front(), kSolution, scratch);
  team.run_ranges(nodes, kGrain, [&](std::size_t begin, std::size_t end) {
    enter(finest.order().data(), finest.root().data(), begin, end, r.data(), 1.0 / size, turned,
          level_r);
  });
  cycle(0, scratch, team);
  scratch.products.resize((nodes + kGrain - 1) / kGrain);
  team.run_ranges(nodes, kGrain, [&](std::size_t begin, std::size_t end) {
    leave(finest.order().data(), finest.root().data(), begin, end, r.data(), size, turned, level_x,
          z.data(), scratch.products[begin / kGrain]);
  });
  return std::accumulate(scratch.products.begin(), scratch.products.end(), 0.0);
}

RestMultigrid::Eight RestMultigrid::solve_eight(const EightVectors& r, const Eight& r_norms,
                                                int vectors,
                                                const std::vector<NodeRotation>& rotations,
                                                EightVectors& z, Scratch& scratch,
                                                ThreadTeam& team) const {
  const std::size_t nodes = levels_.front().smoother->nodes();
  scratch.column_residual.resize(nodes);
  scratch.column_solution.resize(nodes);
  z.setZero(8, r.cols());
  Eight products = Eight::Zero();
  for (int c = 0; c < vectors; ++c) {
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < 3; ++a) {
        scratch.column_residual[i].at[a] = r(c, static_cast<Eigen::Index>(3 * i + a));
      }
    }
    products[c] = solve(scratch.column_residual, r_norms[c], rotations, scratch.column_solution,
                        scratch, team);
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < 3; ++a) {
        z(c, static_cast<Eigen::Index>(3 * i + a)) = scratch.column_solution[i].at[a];
      }
    }
  }
  return products;
}

std::size_t RestMultigrid::bytes() const {
  std::size_t sum = coarsest_->bytes();
  for (const Level& level : levels_) {
    sum += level.smoother->bytes() + sizeof(Hanging) * (level.corners.size() + level.hangs.size()) +
           sizeof(int) * level.hang_start.size();
  }
  return sum;
}

}  // namespace tandem::fem

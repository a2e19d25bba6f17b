#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "fem_process/matrix/lattice.h"
#include "fem_process/solvers/gauss_seidel.h"
#include "fem_process/solvers/rest_factor.h"
#include "fem_process/solvers/rest_inverse.h"

namespace tandem::fem {

/// One V-cycle of multigrid on a step matrix at the reference positions [Trottenberg, Oosterlee,
/// Schüller 2001; embedded lattices: Georgii & Westermann 2008]: a forward sweep of Gauss and
/// Seidel, the residual's solution on a lattice of about twice the edges' length, a backward sweep.
/// The lattice's matrix is Pᵀ A₀ P; it is solved by the same cycle, or by a RestFactor once it is
/// small. Memory and work are proportional to the mesh, which those of a factor outgrow.
class RestMultigrid final : public RestInverse {
 public:
  /// Nodes up to which a lattice's matrix is factorised.
  static constexpr std::size_t kFactorised = 5000;
  /// `positions` (m) of the pattern's nodes. Throws a Usage error when A₀ is not positive definite.
  RestMultigrid(const BlockPattern& pattern, const BlockValues& A,
                const std::vector<Eigen::Vector3d>& positions,
                std::size_t factorised = kFactorised);

  double solve(const std::vector<Padded>& r, double r_norm,
               const std::vector<NodeRotation>& rotations, std::vector<Padded>& z, Scratch& scratch,
               ThreadTeam& team) const override;
  /// One vector after the other.
  Eight solve_eight(const EightVectors& r, const Eight& r_norms, int vectors,
                    const std::vector<NodeRotation>& rotations, EightVectors& z, Scratch& scratch,
                    ThreadTeam& team) const override;

  [[nodiscard]] std::size_t bytes() const override;
  /// With the mesh's own, without the coarsest lattice.
  [[nodiscard]] std::size_t levels() const { return levels_.size(); }

  /// What a node takes from the next level's or gives to them, in scaled unknowns.
  struct Hanging {
    int node = 0;
    float weight = 0.0F;
  };

 private:
  struct Level {
    std::unique_ptr<GaussSeidel> smoother;
    std::vector<Hanging> corners;  ///< eight per place
    std::vector<int> hang_start;   ///< per place of the next level
    std::vector<Hanging> hangs;    ///< places that hang on it
    std::size_t first = 0;         ///< of its vectors in Scratch::levels
  };
  void add_level(std::unique_ptr<GaussSeidel> smoother, const Lattice& lattice,
                 const GaussSeidel* next);
  /// x of level `k` from its r.
  void cycle(std::size_t k, Scratch& scratch, ThreadTeam& team) const;
  void solve_coarsest(const Level& above, Scratch& scratch, ThreadTeam& team) const;
  [[nodiscard]] Padded4* vector(const Level& level, int which, Scratch& scratch) const;

  std::vector<Level> levels_;
  std::unique_ptr<RestFactor> coarsest_;
  std::size_t coarsest_nodes_ = 0;
  std::size_t coarsest_first_ = 0;  ///< of its two vectors in Scratch::levels
  std::size_t scratch_size_ = 0;
};

}  // namespace tandem::fem

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fem_process/matrix/block_matrix.h"
#include "fem_process/solvers/cholmod_solver.h"
#include "fem_process/solvers/factor_panels.h"
#include "fem_process/solvers/rest_inverse.h"

namespace tandem::fem {

/// Cholesky factor A₀ = L Lᵀ of a step matrix at the reference positions, as a preconditioner: made
/// once and held in 16 bits per entry, since a preconditioner need not be exact. Per supernode one
/// dense panel
///   [L₁₁⁻¹; −L₂₁ L₁₁⁻¹]
/// serves both triangular solves as a product [Alvarado & Schreiber 1993; Courtecuisse et al.
/// 2010]; A₀ is scaled to a unit diagonal first. Subtrees of the elimination tree are solved side
/// by side, each with sums of its own for the rows above it, which are added up in the order of the
/// subtrees. The same bits on every processor and for any number of threads.
class RestFactor final : public RestInverse {
 public:
  /// Throws a Usage error when A₀ is not positive definite.
  RestFactor(const BlockPattern& pattern, const BlockValues& A);

  /// z = W L⁻ᵀ L⁻¹ Wᵀ r to some 4 digits.
  double solve(const std::vector<Padded>& r, double r_norm,
               const std::vector<NodeRotation>& rotations, std::vector<Padded>& z, Scratch& scratch,
               ThreadTeam& team) const override;

  /// An entry of the factor is read once for all vectors.
  Eight solve_eight(const EightVectors& r, const Eight& r_norms, int vectors,
                    const std::vector<NodeRotation>& rotations, EightVectors& z, Scratch& scratch,
                    ThreadTeam& team) const override;

  [[nodiscard]] std::size_t bytes() const override {
    return panels_.bytes() + sizeof(int) * row_.size();
  }

 private:
  /// Positions are those in Scratch::y.
  struct Supernode {
    FactorPanels::Panel panel;
    int first = 0;          ///< of its columns
    std::size_t below = 0;  ///< in row_: positions of the rows below the columns
  };
  /// Nodes that are eliminated together: their unknowns stand from `first` on, three by three,
  /// behind them the sums for rows of the top.
  struct Part {
    std::vector<Supernode> supernodes;
    std::vector<int> nodes;
    int first = 0;
    std::vector<int> above;  ///< positions in the top of those sums
  };
  void place(const SupernodalFactor& factor, const std::vector<int>& supernodes,
             std::vector<int>& position, Part& part);
  void add_panels(const SupernodalFactor& factor, const std::vector<int>& supernodes,
                  const std::vector<double>& root, const std::vector<int>& position, Part& part);
  /// The panel's tiles [begin, end) times its scaled columns, into y.
  void forward(const Supernode& supernode, const float* scaled, int begin, int end, float* y,
               float* rows) const;
  void gather_rows(const Supernode& supernode, const float* y, float* rows) const;
  void solve_top(float* y, float* columns, float* rows, ThreadTeam& team) const;
  void forward_eight(const Supernode& supernode, const float* scaled, int vectors, int begin,
                     int end, float* y, float* rows) const;
  void gather_tiles(const Supernode& supernode, const float* y, float* rows, float* tiles) const;
  void solve_top_eight(int vectors, float* y, float* columns, float* rows, float* tiles,
                       ThreadTeam& team) const;

  std::vector<double> inverse_root_;  ///< per node, 1/√(mean of its diagonal entries of A₀)
  FactorPanels panels_;
  std::vector<int> row_;
  std::vector<Part> parts_;
  Part top_;
  int size_ = 0;      ///< of Scratch::y
  int top_size_ = 0;  ///< of its beginning, where the top stands
  int most_columns_ = 0;
  int most_rows_ = 0;
};

}  // namespace tandem::fem

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fem_process/kernels/simd.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/matrix/node_rotations.h"

namespace tandem::fem {

/// A node's vector in single precision: three numbers and a zero.
struct alignas(16) Padded4 {
  float at[4];
};

/// A symmetric positive definite B ≈ A₀⁻¹, A₀ a step matrix at the reference positions, made once
/// and turned with the nodes as a preconditioner [Courtecuisse et al. 2010]. The same bits on every
/// processor and for any number of threads.
class RestInverse {
 public:
  virtual ~RestInverse() = default;

  /// Working memory of a solve: one per caller.
  struct Scratch {
    std::vector<float> y;
    std::vector<float> work;
    std::vector<double> products;
    std::vector<Padded4> levels;          ///< of RestMultigrid
    std::vector<Padded> coarse_residual;  ///< of its coarsest level
    std::vector<Padded> coarse_solution;
    std::vector<Padded> column_residual;  ///< one of eight
    std::vector<Padded> column_solution;
  };

  /// z = W B Wᵀ r, W = diag(`rotations`) or, when they are empty, I. `r_norm` = ‖r‖ keeps small
  /// numbers in the range of single precision. Returns r · z.
  virtual double solve(const std::vector<Padded>& r, double r_norm,
                       const std::vector<NodeRotation>& rotations, std::vector<Padded>& z,
                       Scratch& scratch, ThreadTeam& team) const = 0;

  /// The same for the first `vectors` of eight, the others zero. A scratch of its own.
  using Eight = Eigen::Array<double, 8, 1>;
  virtual Eight solve_eight(const EightVectors& r, const Eight& r_norms, int vectors,
                            const std::vector<NodeRotation>& rotations, EightVectors& z,
                            Scratch& scratch, ThreadTeam& team) const = 0;

  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

}  // namespace tandem::fem

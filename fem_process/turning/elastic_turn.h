#pragma once

#include <Eigen/Core>
#include <string>

#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// Elastic turning up to which shapes that add up linearly are good (rad). A bent bar of the length
/// l whose end has turned by θ is shorter by θ² l/6, which they cannot show. The falling beam of
/// docs/fem.md, section 9, is off by 1.5 % of its deflection at 0.064 rad and by 11 % at 0.24 rad:
/// by some 3 % here.
inline constexpr double kMostElasticTurn_rad = 0.1;

/// How far the elements of a body turn where its displacement is a sum of shapes, u = Σ_c B_c z_c:
///   θ_e = ½ curl u = ½ Σ_i ∇N_i × u_i.
/// It is followed at the elements that turn most in one of the shapes, so its cost does not grow
/// with the mesh.
class ElasticTurn {
 public:
  /// `shapes`: nodes × 3 n, three components for each of n shapes.
  ElasticTurn(const TetMesh& mesh, const Eigen::MatrixXd& shapes);

  /// max |θ_e| (rad) with the shapes' coordinates z.
  [[nodiscard]] double largest_rad(const Eigen::VectorXd& z) const;

 private:
  Eigen::MatrixXd turns_;  ///< 3 rows an element that is followed, a column for each shape
};

/// The largest turn of any element at the positions x, the body's own turning included (rad): what
/// the `linear` formulation takes for strain.
[[nodiscard]] double largest_turn_rad(const TetMesh& mesh, const Eigen::VectorXd& x);

}  // namespace tandem::fem

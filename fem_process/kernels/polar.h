#pragma once

#include <Eigen/Core>

namespace tandem::fem {

/// Below this fraction of ‖F‖³ the determinant's sign is not to be trusted to Newton's iteration.
inline constexpr double kSingularFraction = 1e-6;

struct PolarRotation {
  Eigen::Matrix3d R;
  bool inverted = false;  ///< det F ≤ 0, or so near to it that the robust road was taken
};

/// Rotation R of the polar decomposition F = R U to round-off, by Newton's iteration
///   R ← ½ (ζ R + (ζ R)⁻ᵀ),  ζ² = ‖R⁻ᵀ‖/‖R‖  [Higham 1986].
/// For det F ≤ 0 it would run to a reflection: there R = U diag(1, 1, det(U Vᵀ)) Vᵀ of the SVD
/// F = U Σ Vᵀ, the nearest rotation [Irving, Teran, Fedkiw 2004]. Deterministic, F finite.
[[nodiscard]] PolarRotation polar_rotation(const Eigen::Matrix3d& F);

}  // namespace tandem::fem

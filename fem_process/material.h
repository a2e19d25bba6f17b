#pragma once

#include <Eigen/Core>

namespace tandem::fem {

/// Isotropic linear elastic material.
struct Material {
  double young_Pa = 2.1e11;
  double poisson = 0.3;
  double density_kg_per_m3 = 7850.0;
};

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// σ = D ε, ε = [ε_xx ε_yy ε_zz γ_xy γ_yz γ_zx] (engineering shear), Pa.
[[nodiscard]] Matrix6d elasticity(const Material& material);

/// Throws a Usage error unless E > 0, −1 < ν < ½ and ρ > 0.
void check(const Material& material);

}  // namespace tandem::fem

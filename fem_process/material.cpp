#include "fem_process/material.h"

#include <cmath>
#include <string>

#include "protocol/contract/error.h"

namespace tandem::fem {

Matrix6d elasticity(const Material& material) {
  const double nu = material.poisson;
  const double lambda = material.young_Pa * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double mu = material.young_Pa / (2.0 * (1.0 + nu));
  Matrix6d D = Matrix6d::Zero();
  D.topLeftCorner<3, 3>().setConstant(lambda);
  D.diagonal() << lambda + 2.0 * mu, lambda + 2.0 * mu, lambda + 2.0 * mu, mu, mu, mu;
  return D;
}

void check(const Material& material) {
  require(material.young_Pa > 0.0 && std::isfinite(material.young_Pa),
          "fem: Young's modulus " + std::to_string(material.young_Pa) +
              " Pa must be positive. Give it in Pa.");
  require(material.poisson > -1.0 && material.poisson < 0.5,
          "fem: Poisson's ratio " + std::to_string(material.poisson) +
              " must be above -1 and below 0.5. Use 0.49 for nearly incompressible rubber.");
  require(material.density_kg_per_m3 > 0.0 && std::isfinite(material.density_kg_per_m3),
          "fem: density " + std::to_string(material.density_kg_per_m3) +
              " kg/m³ must be positive. Give it in kg/m³.");
}

}  // namespace tandem::fem

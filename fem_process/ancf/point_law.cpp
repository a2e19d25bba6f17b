#include "fem_process/ancf/point_law.h"

#include <cmath>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {

BeamMaterial BeamMaterial::from_young(ElasticLaw law, double young_Pa, double poisson) {
  return {.law = law,
          .mu_Pa = young_Pa / (2.0 * (1.0 + poisson)),
          .k_Pa = young_Pa / (3.0 * (1.0 - 2.0 * poisson))};
}

double lateral_stretch(const BeamMaterial& material, double stretch) {
  const auto lateral_stress = [&](double t) {
    if (material.law == ElasticLaw::SaintVenantKirchhoff) {
      const double along = 0.5 * (stretch * stretch - 1.0);
      const double across = 0.5 * (t * t - 1.0);
      const double lambda = material.k_Pa - 2.0 / 3.0 * material.mu_Pa;
      return lambda * (along + 2.0 * across) + 2.0 * material.mu_Pa * across;
    }
    const double J = stretch * t * t;
    const double I1 = stretch * stretch + 2.0 * t * t;
    return material.mu_Pa / std::cbrt(J * J) * (t * t - I1 / 3.0) + material.k_Pa * J * (J - 1.0);
  };
  // Grows with t: the secant between any two values around 1 leads to the root.
  double before = 1.0;
  double t = 1.0 - material.poisson() * (stretch - 1.0);
  double stress_before = lateral_stress(before);
  for (int step = 0; step < 50 && t != before; ++step) {
    const double stress = lateral_stress(t);
    if (stress == stress_before) break;
    const double next = t - stress * (t - before) / (stress - stress_before);
    before = t;
    stress_before = stress;
    t = next;
  }
  return t;
}

RuleLaws rule_laws(const BeamMaterial& material, Integration integration) {
  PointLaw whole;
  if (material.law == ElasticLaw::NeoHookean) {
    whole.mu = material.mu_Pa;
    whole.k = material.k_Pa;
  } else {
    whole.trace = material.k_Pa - 2.0 / 3.0 * material.mu_Pa;
    whole.full = 2.0 * material.mu_Pa;
  }
  RuleLaws laws{.volume = whole, .uses_axis = integration != Integration::Full};
  if (integration == Integration::VolumeOnAxis) {
    require(material.law == ElasticLaw::NeoHookean,
            "fem: volume_on_axis splits the neo-Hookean law only. Use axis_d0.");
    laws.volume.k = 0.0;
    laws.axis.k = material.k_Pa;
  } else if (integration == Integration::AxisD0) {
    const double shear = 2.0 * material.mu_Pa;
    const double normal = material.young_Pa() - shear;
    laws.volume = {.full = shear, .normal = normal};
    laws.axis = whole;
    laws.axis.full -= shear;
    laws.axis.normal -= normal;
  }
  laws.volume.bulk_viscosity = material.k_Pa * material.dilatation_s;
  laws.volume.shear_viscosity = material.mu_Pa * material.deviation_s;
  laws.volume.viscosity = material.viscosity;
  return laws;
}

}  // namespace tandem::fem::ancf

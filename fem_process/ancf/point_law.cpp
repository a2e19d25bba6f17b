#include "fem_process/ancf/point_law.h"

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {

BeamMaterial BeamMaterial::from_young(ElasticLaw law, double young_Pa, double poisson) {
  return {.law = law,
          .mu_Pa = young_Pa / (2.0 * (1.0 + poisson)),
          .k_Pa = young_Pa / (3.0 * (1.0 - 2.0 * poisson))};
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

#pragma once

namespace tandem::fem::ancf {

enum class ElasticLaw {
  NeoHookean,           ///< W = μ/2 (J^(−2/3) tr FᵀF − 3) + k/2 (J − 1)²
  SaintVenantKirchhoff  ///< W = λ/2 (tr E)² + G E:E
};

/// How the internal energy is integrated over the volume of an element.
enum class Integration {
  Full,          ///< as written: bends too stiffly where ν > 0 (Poisson locking)
  VolumeOnAxis,  ///< the volumetric part on the centre line only: bends too softly
  /// ∫_V ½ E:D₀:E dV + ∫_axis A [W(F₀) − ½ E₀:D₀:E₀] dx with D₀ = diag(E, E, E, G, G, G): the
  /// whole law for stretch and shear of the centre line, Young's modulus for bending
  AxisD0
};

enum class Viscosity {
  Spatial,  ///< Newtonian Cauchy stress: τ = J [(κ − 2η/3) tr D I + 2 η D]
  Green     ///< S = (κ − 2η/3) tr(E') I + 2 η E'
};

/// Material of a beam: elasticity, and viscosity κ = k γ_v, η = μ γ_d that vanishes with rigid
/// motion [García-Vallejo et al. 2005].
struct BeamMaterial {
  ElasticLaw law = ElasticLaw::NeoHookean;
  double mu_Pa = 0.0;  ///< shear modulus μ
  double k_Pa = 0.0;   ///< bulk modulus k
  double density_kg_per_m3 = 0.0;
  double dilatation_s = 0.0;  ///< γ_v
  double deviation_s = 0.0;   ///< γ_d
  Viscosity viscosity = Viscosity::Spatial;

  /// Young's modulus E = 9 k μ / (3 k + μ) of small strains (Pa).
  [[nodiscard]] double young_Pa() const { return 9.0 * k_Pa * mu_Pa / (3.0 * k_Pa + mu_Pa); }
  /// Poisson's ratio ν = (3 k − 2 μ) / (2 (3 k + μ)) of small strains.
  [[nodiscard]] double poisson() const {
    return (3.0 * k_Pa - 2.0 * mu_Pa) / (2.0 * (3.0 * k_Pa + mu_Pa));
  }
  [[nodiscard]] static BeamMaterial from_young(ElasticLaw law, double young_Pa, double poisson);
};

/// Stretch across a bar of this material, stretched along by `stretch`, that leaves its sides free
/// of stress.
[[nodiscard]] double lateral_stretch(const BeamMaterial& material, double stretch);

/// The stress of a material point: sum of
///   neo-Hookean       P = μ J^(−2/3) (F − (tr FᵀF / 3) F⁻ᵀ) + k (J − 1) J F⁻ᵀ
///   quadratic in E    P = F S,  S = trace tr(E) I + full E + normal diag(E)
///   viscous           see Viscosity
/// Coefficients in Pa and Pa s. A rule of integration has one of these.
struct PointLaw {
  double mu = 0.0;
  double k = 0.0;
  double trace = 0.0;
  double full = 0.0;
  double normal = 0.0;
  double bulk_viscosity = 0.0;
  double shear_viscosity = 0.0;
  Viscosity viscosity = Viscosity::Spatial;

  [[nodiscard]] bool neo_hookean() const { return mu != 0.0 || k != 0.0; }
  [[nodiscard]] bool quadratic() const { return trace != 0.0 || full != 0.0 || normal != 0.0; }
  [[nodiscard]] bool viscous() const { return bulk_viscosity != 0.0 || shear_viscosity != 0.0; }
};

/// The laws of the two rules of integration.
struct RuleLaws {
  PointLaw volume;
  PointLaw axis;
  bool uses_axis = false;
};
[[nodiscard]] RuleLaws rule_laws(const BeamMaterial& material, Integration integration);

}  // namespace tandem::fem::ancf

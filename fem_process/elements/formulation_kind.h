#pragma once

namespace tandem::fem {

/// How internal forces follow from positions; see make_formulation().
enum class FormulationKind {
  Linear,                  ///< small displacements
  Corotational,            ///< simplified tangent Σ R K Rᵀ
  ConsistentCorotational,  ///< the same forces, tangent with the rotation's derivative
  TotalLagrangian,         ///< St. Venant–Kirchhoff
  CraigBampton             ///< modes in a floating frame: ReducedBody
};

}  // namespace tandem::fem

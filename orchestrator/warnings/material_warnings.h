#pragma once

#include <vector>

#include "fem_process/body/model.h"
#include "orchestrator/warnings/finding.h"

namespace tandem::orchestrator {

/// Densities outside of 10 … 25000 kg/m³, with the unit that would explain them.
[[nodiscard]] std::vector<Finding> implausible_densities(const scenario::Node& root,
                                                         const fem::Model& model);

/// Moduli with which waves along a rod, √(E/ρ), would be slower than 1 m/s or faster than 20 km/s
/// (jelly and diamond lie between), or slower than 30 m/s in what is as dense as stone: with the
/// unit that would explain them. Densities that are implausible themselves are left alone.
[[nodiscard]] std::vector<Finding> implausible_moduli(const scenario::Node& root,
                                                      const fem::Model& model);

/// The same of the material of a chain; and where its integration locks: full integration bends
/// with the constrained modulus, (1 − ν)/((1 + ν)(1 − 2ν)) times as stiffly as a beam.
[[nodiscard]] std::vector<Finding> implausible_chain_material(const scenario::Node& root);

}  // namespace tandem::orchestrator

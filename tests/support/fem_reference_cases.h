#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem_process/body/params.h"

namespace tandem::fem::testing {

/// Displacement of the monitored node at one load factor (m).
struct ReferenceStep {
  double factor = 0.0;
  Eigen::Vector3d linear;  ///< CalculiX
  Eigen::Vector3d nlgeom;  ///< CalculiX with NLGEOM: St. Venant–Kirchhoff
  Eigen::Vector3d corot;   ///< an independent co-rotational program
};

/// A mesh with independent static solutions: clamped, dead loads, one monitored node.
struct ReferenceCase {
  std::string name;
  Params params;    ///< SI
  SetName monitor;  ///< the set of the monitored node
  std::vector<ReferenceStep> steps;
  [[nodiscard]] std::vector<double> factors() const;
};

/// Of hinge, lug, beam15, cantilever_c1, cantilever_c2, cantilever_c3.
[[nodiscard]] ReferenceCase reference_case(const std::string& name);

}  // namespace tandem::fem::testing

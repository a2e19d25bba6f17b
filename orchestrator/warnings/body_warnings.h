#pragma once

#include "fem_process/body/model.h"
#include "orchestrator/warnings/finding.h"
#include "protocol/contract/port.h"

namespace tandem::orchestrator {

/// Bodies longer than 30 m, heavier than 1000 t or smaller than a micrometre: with the factor that
/// the mesh was likely drawn in.
[[nodiscard]] std::optional<Finding> implausible_size(const scenario::Node& root,
                                                      const fem::Model& model);

/// Ports whose origin is further from their nearest node than three times the extent of their
/// nodes. `origins`: the ports at t = 0.
[[nodiscard]] std::vector<Finding> far_ports(const scenario::Node& root, const fem::Model& model,
                                             const MotionSet& origins);

/// How a body of first-order tetrahedra lies in its thinnest direction.
struct Slenderness {
  double length_m = 0.0;
  double thickness_m = 0.0;
  double elements_across = 0.0;
  double element_length_m = 0.0;  ///< along the length
  /// The part by which it is too stiff in bending, in the softer direction of its mesh:
  ///   (1.4 + 1.2 a²)/n²,   n elements across, a the ratio of their length to their height.
  /// Fitted to bars of cells of six tetrahedra against the same mesh of second order (first
  /// bending frequencies, n = 2 … 6, a = 1, 2, 4: within a seventh; docs/fem.md has the table).
  [[nodiscard]] double excess() const;
};
[[nodiscard]] Slenderness slenderness_of(const fem::TetMesh& mesh);

/// Bodies of first-order tetrahedra five times as long as thick or more, which bend too little by
/// more than a tenth.
[[nodiscard]] std::optional<Finding> coarse_in_bending(const scenario::Node& root,
                                                       const fem::Model& model);

}  // namespace tandem::orchestrator

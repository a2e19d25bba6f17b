#pragma once

#include <Eigen/Core>

#include "fem_process/ancf/beam_system.h"

namespace tandem::fem::ancf {

/// The lowest eigenfrequencies (Hz) of K(q) φ = ω² M φ about the shape q, fixed unknowns left out,
/// rising; rigid-body modes come first with what round-off leaves of them. Dense: for structures of
/// up to about 2000 unknowns. Throws a Usage error beyond.
[[nodiscard]] Eigen::VectorXd eigenfrequencies_Hz(const BeamSystem& system,
                                                  const Eigen::VectorXd& q, int count);

}  // namespace tandem::fem::ancf

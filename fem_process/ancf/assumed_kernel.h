#pragma once

#include <vector>

#include "fem_process/ancf/beam_kernel.h"

namespace tandem::fem::ancf {

/// The kernel's work with assumed strains (Strain::Assumed), of all elements. The rules have the
/// same stations, and references lie by station, rule, point.
/// Elastic and viscous forces (N, N m) of the elements at the coordinates e and rates e'.
void assumed_forces(const std::vector<BeamKernel::Rule>& rules,
                    const std::vector<BeamKernel::Batch>& batches, const LaneCoordinates* e,
                    const LaneCoordinates* e_rate, double* force, int& inverted);
/// Also the tangents ∂f/∂e + θ ∂f/∂e'.
void assumed_tangents(const std::vector<BeamKernel::Rule>& rules,
                      const std::vector<BeamKernel::Batch>& batches, const LaneCoordinates* e,
                      const LaneCoordinates* e_rate, double theta, double* force, double* tangent,
                      int& inverted);
/// Adds the elastic energy (J).
void assumed_energy(const std::vector<BeamKernel::Rule>& rules,
                    const std::vector<BeamKernel::Batch>& batches, const LaneCoordinates* e,
                    double& energy);

}  // namespace tandem::fem::ancf

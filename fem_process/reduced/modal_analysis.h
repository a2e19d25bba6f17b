#pragma once

#include <Eigen/Core>
#include <string>

#include "fem_process/body/model.h"

namespace tandem::fem {

struct Modes {
  Eigen::VectorXd frequencies_Hz;  ///< ascending
  Eigen::MatrixXd shapes;          ///< one column a mode, all nodes; φᵀ M φ = 1
};

/// Lowest vibration modes about the reference positions, prescribed nodes held:
///   K φ = ω² M φ,  f = ω/(2π).
/// Lanczos iteration with full reorthogonalisation (Spectra) on (K − σ M)⁻¹ M, factorised by
/// CHOLMOD; σ is slightly negative, so that a body free to move, whose K is singular, is no special
/// case: its rigid motions are modes of frequency 0.
/// Lanczos sees one vector of a multiple eigenvalue at a time, so the modes found are taken out and
/// the rest is searched until nothing lower appears: multiple modes are complete. Throws a Usage
/// error when `count` is not below the number of free displacements, NotSolved when the iteration
/// does not converge.
[[nodiscard]] Modes lowest_modes(const Model& model, int count);

}  // namespace tandem::fem

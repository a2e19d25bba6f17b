#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {

/// How the tip of examples/pendulum_beam bends while it falls: its displacement in the hub's axes
/// (m) at every macro step.
struct TipMotion {
  std::vector<Eigen::Vector3d> bending_m;
  [[nodiscard]] double largest_m() const;
};

/// The beam of Young's modulus `young_Pa`, released for `duration_s`, in-process by
/// interface_jacobian. Throws when a step fails.
[[nodiscard]] TipMotion falling_beam(const std::string& formulation, double young_Pa,
                                     double duration_s, int modes = 20);

/// Largest distance of the tips over all steps (m).
[[nodiscard]] double largest_distance_m(const TipMotion& a, const TipMotion& b);

}  // namespace tandem::coupled_test

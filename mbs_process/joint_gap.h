#pragma once

#include <cstddef>
#include <vector>

#include "mbs_process/params.h"
#include "mbs_process/state.h"
#include "protocol/contract/subsystem.h"

namespace tandem::mbs {

/// How far joints have come apart. With r₁, r₂ where the anchor A was in both bodies at t = 0,
///   e = p₁ + R₁ r₁ − (p₂ + R₂ r₂),
/// of a slider the part across its axis (which turns with body1). Sliders and fixed joints have no
/// anchor of their own: body1's centre at t = 0 stands for it.
/// |e| is held against the joint's arm: the longest way from the centre of mass of one of its
/// bodies to an anchor of that body; where both bodies have their anchors in their centres, the
/// longest of the mechanism. ODE removes e step by step and never makes it zero; the bodies of a
/// gap go where the mechanism cannot.
class JointGaps {
 public:
  explicit JointGaps(const Params& params);

  /// The joint whose gap is the largest part of its arm.
  [[nodiscard]] JointGap widest(const State& state) const;

 private:
  static constexpr std::size_t kWorld = static_cast<std::size_t>(-1);
  struct End {
    std::size_t body = kWorld;
    Eigen::Vector3d r = Eigen::Vector3d::Zero();  ///< in the body's frame; world: in W (m)
  };
  struct Joint {
    End first, second;
    Eigen::Vector3d free_axis = Eigen::Vector3d::Zero();  ///< in body1; zero: none
    double arm_m = 0.0;
  };
  [[nodiscard]] static Eigen::Vector3d place(const End& end, const State& state);

  std::vector<Joint> joints_;
};

}  // namespace tandem::mbs

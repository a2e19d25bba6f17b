#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "protocol/contract/energy.h"
#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"

namespace tandem::mbs {

/// Motion of a body frame B (origin at the centre of mass) in W. SI.
struct BodyState {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_WB = Eigen::Vector3d::Zero();
};

/// Force on a body and torque about its centre of mass, axes of W.
struct BodyWrench {
  Eigen::Vector3d f_B_W = Eigen::Vector3d::Zero();  ///< N
  Eigen::Vector3d t_B_W = Eigen::Vector3d::Zero();  ///< N·m
  /// Adds a force f at the point r from the centre of mass: torque r × f.
  void add_at(const Eigen::Vector3d& r, const Eigen::Vector3d& f) {
    f_B_W += f;
    t_B_W += r.cross(f);
  }
};

/// Everything that changes during a run: the world of ODE is refilled from it before every step, so
/// a copy of it is a complete checkpoint.
struct State {
  SimTime time{};
  std::vector<BodyState> bodies;  ///< in the order of Params::bodies
  /// Coordinates of every joint since t = 0 (rad, slider: m), counted through full turns; 0 where
  /// the joint has none.
  std::vector<std::array<double, 2>> joint_coordinates;
  /// λ̄ of WrenchRule, of all ports; empty before the first step and where no rule filters.
  WrenchSet filtered;
  EnergyBook book;  ///< works and losses since t = 0; its energies stay 0
};

/// Fingerprint over every bit of the state.
[[nodiscard]] std::uint64_t hash_of(const State& state);

}  // namespace tandem::mbs

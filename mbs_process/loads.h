#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mbs_process/params.h"
#include "mbs_process/state.h"
#include "mbs_process/step_work.h"

namespace tandem::mbs {

/// A place that moves with a body, or stands still in W.
struct Anchor {
  std::optional<std::size_t> body;                 ///< none = world
  Eigen::Vector3d p_BA = Eigen::Vector3d::Zero();  ///< in B, or in W without a body (m)
};

/// The forces that are functions of the state and time alone: springs, dampers and force laws.
/// Evaluated at the beginning of a micro step, laws at its end.
class Loads {
 public:
  /// `params` must have passed check().
  explicit Loads(const Params& params);

  /// Adds everything to `applied`, and apart to `sorted`; both have one entry per body. `t_end_s`
  /// is the time at the end of the micro step.
  void add_to(const State& state, double t_end_s, std::vector<BodyWrench>& applied,
              SortedWrenches& sorted) const;

  /// Energy of all springs (J).
  [[nodiscard]] double spring_energy_J(const State& state) const;

 private:
  struct Spring {
    Anchor end1, end2;
    double stiffness_N_per_m, damping_N_s_per_m, rest_length_m;
  };
  struct JointSpring {
    std::size_t joint, body1;
    std::optional<std::size_t> body2;
    Eigen::Vector3d axis_B1;  ///< of unit length
    bool slider;
    double stiffness, damping, rest;
  };
  struct Force {
    std::size_t body;
    bool torque;
    Eigen::Vector3d p_BF, direction_W;
    Law law;
  };

  void add_spring(const Spring& spring, const State& state, std::vector<BodyWrench>& applied,
                  SortedWrenches& sorted) const;
  void add_joint_spring(const JointSpring& spring, const State& state,
                        std::vector<BodyWrench>& applied, SortedWrenches& sorted) const;

  std::vector<Spring> springs_;
  std::vector<JointSpring> joint_springs_;
  std::vector<Force> forces_;
};

}  // namespace tandem::mbs

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

/// A spring of either kind, as a spring-damper on its rate: length or joint coordinate per second.
struct SpringData {
  std::string name;
  double stiffness = 0.0;  ///< N/m or N·m/rad
  double damping = 0.0;    ///< N·s/m or N·m·s/rad
  std::size_t body1 = 0;
  bool turns = false;  ///< its rate is an angle's
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

  /// Springs between points, then those in joints, both in the order of the parameters.
  [[nodiscard]] const std::vector<SpringData>& springs() const { return data_; }
  /// Adds what spring `i` exerts on its bodies when its effort against the rate is `effort` (N,
  /// N·m). Springs whose ends meet have no direction and add nothing.
  void add_effort(std::size_t i, double effort, const State& state,
                  std::vector<BodyWrench>& applied) const;
  /// d l/dt (m/s) or d θ/dt (rad/s, slider: m/s) of spring `i`.
  [[nodiscard]] double rate(std::size_t i, const State& state) const;

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

  [[nodiscard]] static double rate_of(const JointSpring& spring, const State& state);
  /// `effort` along the axis on body1, its reaction on body2.
  static void add_effort_on_body1(const JointSpring& spring, double effort, const State& state,
                                  std::vector<BodyWrench>& applied);
  void add_spring(const Spring& spring, const State& state, std::vector<BodyWrench>& applied,
                  SortedWrenches& sorted) const;
  void add_joint_spring(const JointSpring& spring, const State& state,
                        std::vector<BodyWrench>& applied, SortedWrenches& sorted) const;

  std::vector<Spring> springs_;
  std::vector<JointSpring> joint_springs_;
  std::vector<Force> forces_;
  std::vector<SpringData> data_;
};

}  // namespace tandem::mbs

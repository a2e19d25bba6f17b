#pragma once

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs_process/params.h"
#include "mbs_process/state.h"
#include "mbs_process/step_rule.h"

namespace tandem::mbs {

/// ODE gave up inside a call: a failed assertion, an error, or a complaint of its LCP solver. The
/// world that threw is unusable and must be built anew.
class OdeFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A stop or a motor in a step, as ODE took it.
struct EffortRow {
  std::size_t joint = 0;  ///< of Params::joints
  int axis = 1;
  bool motor = false;  ///< else a stop
  double cfm = 0.0;
  double speed = 0.0;  ///< of a motor
  double most = 0.0;   ///< of a motor: its largest effort in the step
  /// What it exerted on body1 beside what else acts in directions across its axis (slider: force,
  /// else torque).
  Eigen::Vector3d on_body1 = Eigen::Vector3d::Zero();
};

/// The one border to the Open Dynamics Engine: bodies and joints of a dWorld, stepped by dWorldStep
/// (direct LCP solver, semi-implicit Euler, double precision):
///   M (v⁺ − v) / h = f + Jᵀ μ,   J v⁺ + cfm μ = −(erp / h) φ,   x⁺ = x ⊕ h v⁺,
/// with the gyroscopic torque made implicit [Lacoursière 2006] and x ⊕ h v⁺ an exact finite
/// rotation about w⁺. No collision, damping, or auto-disabling. [R. Smith, Open Dynamics Engine,
/// 0.16]
///
/// A stop is a row J v⁺ + cfm μ ≥ −(erp / h) φ, μ ≥ 0 while its coordinate is at or beyond it; a
/// motor a row J v⁺ + cfm μ = speed, |μ| ≤ its largest effort. Both may act on one coordinate.
///
/// It keeps no state of its own: load(), step(), read() is a pure function of what was loaded.
/// Several worlds may live in one process; one world is used by one thread at a time.
class OdeWorld {
 public:
  /// `params` must have passed check(). Joints take their zero from the bodies' poses at t = 0.
  explicit OdeWorld(const Params& params);
  ~OdeWorld();
  OdeWorld(OdeWorld&&) noexcept;
  OdeWorld& operator=(OdeWorld&&) noexcept;
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  /// `joint_coordinates` are those that stops of angles act on, counted through full turns.
  void load(const std::vector<BodyState>& bodies,
            const std::vector<std::array<double, 2>>& joint_coordinates);
  /// Rate that the motor of `joint` aims at in the next step (rad/s, slider: m/s).
  void set_motor_speed(std::size_t joint, double speed);
  /// One dWorldStep of h_s by `rule` under `applied` (one entry per body). Throws OdeFault.
  void step(double h_s, const std::vector<BodyWrench>& applied, const StepRule& rule);
  void read(std::vector<BodyState>& bodies) const;
  /// Adds what was exerted on each body in the last step, by motors to `motors`, by joints and
  /// their stops to `joints`.
  void add_reactions(std::vector<BodyWrench>& motors, std::vector<BodyWrench>& joints) const;
  /// All stops, be they reached or not, and all motors, as they were in the last step.
  [[nodiscard]] std::vector<EffortRow> effort_rows() const;
  /// Present coordinates of a joint as ODE measures them: angles in [−π, π].
  [[nodiscard]] std::array<double, 2> coordinates(std::size_t joint) const;
  /// Their present rates (rad/s, slider: m/s).
  [[nodiscard]] std::array<double, 2> rates(std::size_t joint) const;

 private:
  /// Prepares what the next dWorldStep takes.
  void obey(const StepRule& rule, double h_s);

  struct Impl;
  struct Retire {
    void operator()(Impl* impl) const;
  };
  std::unique_ptr<Impl, Retire> impl_;
  Eigen::Vector3d gravity_m_per_s2_;
};

}  // namespace tandem::mbs

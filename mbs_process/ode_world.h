#pragma once

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs_process/params.h"
#include "mbs_process/state.h"

namespace tandem::mbs {

/// ODE gave up inside a call: a failed assertion, an error, or a complaint of its LCP solver. The
/// world that threw is unusable and must be built anew.
class OdeFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The one border to the Open Dynamics Engine: bodies and joints of a dWorld, stepped by dWorldStep
/// (direct LCP solver, semi-implicit Euler, double precision):
///   M (v⁺ − v) / h = f + Jᵀ λ,   J v⁺ + (cfm / h) λ = −(erp / h) φ,   x⁺ = x ⊕ h v⁺,
/// with the gyroscopic torque made implicit [Lacoursière 2006] and x ⊕ h v⁺ an exact finite
/// rotation about w⁺. No collision, damping, or auto-disabling. [R. Smith, Open Dynamics Engine,
/// 0.16]
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

  void load(const std::vector<BodyState>& bodies);
  /// Rate that the motor of `joint` aims at in the next step (rad/s, slider: m/s).
  void set_motor_speed(std::size_t joint, double speed);
  /// One dWorldStep of h_s under `applied` (one entry per body). Throws OdeFault.
  void step(double h_s, const std::vector<BodyWrench>& applied) { step(h_s, applied, 1.0, erp_); }
  /// The same with `share` of gravity and of `applied`, and another fraction erp. With half the
  /// forces the velocities gain what h/2 gives and the poses move by h.
  void step(double h_s, const std::vector<BodyWrench>& applied, double share, double erp);
  void read(std::vector<BodyState>& bodies) const;
  /// Adds what the joints (limits included) exerted on each body in the last step: those with a
  /// motor to `motors`, all others to `joints`.
  void add_reactions(std::vector<BodyWrench>& motors, std::vector<BodyWrench>& joints) const;
  /// Present coordinates of a joint as ODE measures them: angles in [−π, π].
  [[nodiscard]] std::array<double, 2> coordinates(std::size_t joint) const;

 private:
  struct Impl;
  struct Retire {
    void operator()(Impl* impl) const;
  };
  std::unique_ptr<Impl, Retire> impl_;
  Eigen::Vector3d gravity_m_per_s2_;
  double erp_;
};

}  // namespace tandem::mbs

#pragma once

#include <functional>
#include <optional>

#include "fem_process/ancf/beam_params.h"
#include "fem_process/ancf/beam_state.h"
#include "fem_process/ancf/beam_step.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem::ancf {

/// Work of the last advance, for reports.
struct BeamEffort {
  int iterations = 0;
  int factorisations = 0;
  int halvings = 0;
};

/// A chain or beam as the flexible side of a coupled run: motions of wheels and of the bodies at
/// its ends in, wrenches out. A port has no nodes: its body is felt through the band's contact,
/// whose wrench depends on the motion at the end of a step alone, or holds an end of the chain and
/// takes its reaction. The interface Jacobian is there when the macro step is one micro step.
/// Deterministic: the same calls give the same bits, with or without repetitions of steps.
class BeamBody final : public FemSide {
 public:
  explicit BeamBody(BeamParams params);

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override;
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override;
  void checkpoint() override;
  void rollback() override;
  Observation observe() override;

  [[nodiscard]] const BeamParams& params() const { return params_; }
  [[nodiscard]] const BeamSystem& system() const { return system_; }
  [[nodiscard]] const ContactModel& contact() const { return contact_; }
  [[nodiscard]] const BeamState& state() const { return now_.state; }
  /// What the surfaces feel at the present state, and where the wheels then are.
  [[nodiscard]] const ContactSums& sums() const { return now_.sums; }
  [[nodiscard]] const MotionSet& motions() const { return now_.motions; }
  /// Of all advances so far, discarded ones too.
  [[nodiscard]] const BeamEffort& effort() const { return effort_; }

  /// Position and velocity of a watched point.
  struct PointMotion {
    Eigen::Vector3d r, v;
  };
  [[nodiscard]] PointMotion motion_of(const WatchPoint& point) const;

  /// Called in checkpoint(): the state is accepted.
  void on_accepted(std::function<void(const BeamBody&)> observer) {
    observer_ = std::move(observer);
  }

 private:
  /// The state and what belongs to it.
  struct Moment {
    BeamState state;
    ContactSums sums;
    MotionSet motions;
    std::vector<int>
        swings;  ///< per wheel: successive macro steps in which its torque changed sign
    /// Per wheel: 2 for every large change of sign, −1 for every macro step without, at least 0:
    /// grows while such changes are less than three macro steps apart.
    std::vector<int> reversals;
  };
  void settle(const MotionSet& motions);
  void set_velocities();
  /// Counts the swings of `after`; says which wheel has swung too often, or nothing.
  [[nodiscard]] std::string count_swings(const ContactSums& before, Moment& after) const;
  [[nodiscard]] SimTime micro_step_of(SimTime macro_step) const;
  void check_request(const StepRequest<MotionSet>& request) const;

  BeamParams params_;
  Attachments attachments_;
  BeamSystem system_;
  ContactModel contact_;
  BeamStep step_;
  SubsystemInfo info_;
  bool initialized_ = false;
  Moment now_;
  Moment saved_;
  BeamEffort effort_;
  std::function<void(const BeamBody&)> observer_;
};

}  // namespace tandem::fem::ancf

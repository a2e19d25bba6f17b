#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "fem_process/body/flexible_side.h"
#include "fem_process/body/model.h"
#include "fem_process/body/params.h"
#include "fem_process/body/state.h"
#include "fem_process/transient/step_tangent.h"
#include "fem_process/transient/transient_step.h"
#include "protocol/contract/subsystem.h"

namespace tandem::fem {

/// A flexible body as the flexible side of a coupled run: port motions in, port wrenches out.
///
/// Nodes of rigid ports follow P: x_i = p_WP + R_WP r_i, v_i = v_WP + w_WP × R_WP r_i, with
/// r_i = R_WP(0)ᵀ (X_i − p_WP(0)) from initialize(). The wrench is the full dynamic reaction at the
/// end of the step: with g_i the force the node needs (inertia, damping, internal, minus external),
///   f_P_W = −Σ g_i,  t_P_W = −Σ (x_i − p) × g_i.
/// With backward Euler, g_i is the mean over the step, the nodes stand as in its middle, and p is
/// Po at the beginning of the macro step (see there); with all others everything is at the end.
/// Averaging ports and bushings: see LoosePorts.
/// With backward Euler linear momentum closes to round-off over every step:
/// h Σ f_P_W = −ΔP + h Σ f_ext (without fixed sets and mass-proportional damping).
/// Deterministic: the same calls give the same bits, with or without repetitions of steps.
class FlexibleBody final : public FlexibleSide {
 public:
  explicit FlexibleBody(Params params);

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override;
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override;
  void checkpoint() override;
  void rollback() override;
  /// See changed(): releases and fixes node sets, puts forces on them. The free nodes'
  /// accelerations start anew from the balance of forces; a set that is fixed is held where it is,
  /// its momentum taken by the ground. Where nodes change sides the step matrix is analysed and
  /// factorised anew.
  CommandResult command(const std::string& text) override;
  Observation observe() override;

  [[nodiscard]] const Model& model() const override { return model_; }
  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] State nodal_state() const override { return state_; }

  void on_accepted(std::function<void(const State&)> observer) override {
    observer_ = std::move(observer);
  }

 private:
  struct Advance {
    SolveReport report;
    TransientStep::Result last;
    InterfaceJacobian jacobian;
  };
  /// All micro steps of a macro step from the present state, which stays.
  Advance run(const StepRequest<MotionSet>& request);
  void hold(const std::vector<std::string>& sets);
  void check_changes();
  void make_scheduled_changes();
  void note_chords();
  void check_request(const StepRequest<MotionSet>& request) const;
  [[nodiscard]] SimTime micro_step_of(SimTime macro_step) const;

  Model model_;
  SubsystemInfo info_;
  PortArms arms_;
  std::vector<std::string> held_;  ///< the sets that the model holds now
  std::optional<TransientStep> step_;
  State state_;
  State saved_;
  std::uint64_t generations_ = 0;
  /// For the first micro step of a macro step, which is repeated, and for all others.
  std::array<Linearisation, 2> kept_;
  std::function<void(const State&)> observer_;
};

}  // namespace tandem::fem

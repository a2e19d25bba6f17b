#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "fem_process/body/flexible_side.h"
#include "fem_process/reduced/reduced_step.h"

namespace tandem::fem {

/// A flexible body reduced by component mode synthesis as the flexible side of a coupled run: port
/// motions in, port wrenches out, like FlexibleBody, at a cost that does not grow with the mesh.
/// Small deformations in a floating frame that may move at will; see ReducedModel and ReducedStep.
/// Deterministic: the same calls give the same bits, with or without repetitions of steps.
class ReducedBody final : public FlexibleSide {
 public:
  /// Computes the normal modes.
  explicit ReducedBody(Params params);

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  /// Computes the constraint modes: they turn about the ports' points.
  WrenchSet initialize(const MotionSet& motions) override;
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override;
  void checkpoint() override;
  void rollback() override;
  Observation observe() override;

  [[nodiscard]] const Model& model() const override { return model_; }
  [[nodiscard]] State nodal_state() const override;
  void on_accepted(std::function<void(const State&)> observer) override {
    observer_ = std::move(observer);
  }

  [[nodiscard]] const BoundaryModes& modes() const { return modes_; }
  /// After initialize().
  [[nodiscard]] const ReducedModel& reduced() const { return *reduced_; }
  [[nodiscard]] const ReducedState& state() const { return state_; }

 private:
  void run(const StepRequest<MotionSet>& request, StepResult<WrenchSet>& result);

  Model model_;
  BoundaryModes modes_;
  SubsystemInfo info_;
  std::optional<ReducedModel> reduced_;
  std::optional<ReducedStep> step_;
  ReducedState state_;
  ReducedState saved_;
  std::function<void(const State&)> observer_;
};

}  // namespace tandem::fem

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "protocol/contract/subsystem.h"

namespace tandem {

/// The flexible side with what makes junctions massless.
///
/// A junction is a frame without mass that ports of flexible bodies share: their wrenches and the
/// forces of joints on it are in balance. Both sides' causality asks for a body there that turns
/// wrenches into motions, so the multibody side gives it an inertia that stands in, m, and this one
/// adds to the wrench of one of its ports what that inertia takes up in the step,
///   λ⁺ = Λ⁺ + w⁺,   (1 − α_f) w⁺ + α_f w = m ((1 − α_m) a⁺ + α_m a),
///   a⁺ = ((V⁺ − V)/H − (1 − γ) a)/γ,
/// w and a those of the step before: with the rule of the multibody side's own integrator the sum
/// moves the inertia as it moves, whatever else acts. What remains for everything else is that it
/// is in balance by the same rule,
///   (1 − γ) f̄ + γ f̄⁺ = 0,   f = Σ Λ + the joints' forces.
/// At t = 0 w = a = 0.
///
/// So with Newton's method δm (Σ L_i) = −Σ λ_i at a junction of bodies L_i, the primal assembly of
/// substructures, while schemes know nothing but wrenches and motions.
class CounterInertia final : public FemSide {
 public:
  /// `ports`: as the multibody side knows them.
  CounterInertia(FemSide& inner, const std::vector<PortInfo>& ports);

  /// Whether any of the ports has one.
  [[nodiscard]] static bool needed(const std::vector<PortInfo>& ports);

  [[nodiscard]] const SubsystemInfo& info() const override { return inner_.info(); }
  WrenchSet initialize(const MotionSet& motions) override;
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override;
  void begin_advance(const StepRequest<MotionSet>& request) override;
  StepResult<WrenchSet> finish_advance() override;
  void checkpoint() override;
  void rollback() override;
  CommandResult command(const std::string& text) override { return inner_.command(text); }
  Observation observe() override;

 private:
  struct Junction {
    std::size_t port;
    StandInInertia inertia;
  };
  struct State {
    std::vector<Eigen::Vector<double, 6>> acceleration;  ///< a, of each junction
    std::vector<Eigen::Vector<double, 6>> wrench;        ///< w
    /// Work of w by the trapezoids of the interface's books less what the inertia takes up: with
    /// weights that damp the multibody side has booked it as work of the port and as lost by its
    /// steps. This side's books take both back.
    double work_J = 0.0;
  };

  void add(const StepRequest<MotionSet>& request, StepResult<WrenchSet>& result);

  FemSide& inner_;
  std::vector<Junction> junctions_;
  State state_, saved_;
  StepRequest<MotionSet> begun_;
};

}  // namespace tandem

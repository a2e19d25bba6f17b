#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fem_process/body/flexible_side.h"

namespace tandem::fem {

/// A free node as the multibody side needs it to make a body of.
struct NodeMass {
  std::string name;  ///< node_<tag of the mesh file>
  double mass_kg = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
};

/// The free nodes of a mesh with their lumped masses, in the order of the nodal body's ports.
[[nodiscard]] std::vector<NodeMass> node_masses(const Params& params);

/// A flexible body that owns no masses, the second implementation of [Marinkovic & Zehn 2012,
/// section 6]: every free node is a point mass of the multibody side, and this side evaluates the
/// internal forces alone. One port per free node; with x, v the nodes' positions and velocities
///   f_i = (f_ext(t) − f_int(x) − C v)_i,   t_i = 0,
/// and exactly −∂f_int/∂x, −C as interface Jacobian. No equation is solved and no time is stepped:
/// the multibody side's integrator is that of the flexible body, with its stability limit
/// H < 2/ω_max when the coupling is explicit. Fixed nodes stay. Deterministic.
class NodalBody final : public FlexibleSide {
 public:
  explicit NodalBody(Params params);

  [[nodiscard]] const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& motions) override;
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override;
  void checkpoint() override;
  void rollback() override { state_ = saved_; }
  Observation observe() override;

  [[nodiscard]] const Model& model() const override { return model_; }
  [[nodiscard]] State nodal_state() const override { return state_; }
  void on_accepted(std::function<void(const State&)> observer) override {
    observer_ = std::move(observer);
  }

 private:
  void take(const MotionSet& motions, State& state) const;
  [[nodiscard]] WrenchSet wrenches(State& state) const;
  void book(const State& begin, State& end) const;
  [[nodiscard]] InterfaceJacobian jacobian(const State& state) const;

  Model model_;
  SubsystemInfo info_;
  State state_;
  State saved_;
  std::function<void(const State&)> observer_;
};

}  // namespace tandem::fem

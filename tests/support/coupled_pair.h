#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fem_process/body/flexible_side.h"
#include "mbs_process/rigid_world.h"
#include "orchestrator/run/run.h"
#include "orchestrator/scenario/model.h"
#include "protocol/driver/coupled_run.h"

namespace tandem::coupled_test {

/// The interface at the end of an accepted macro step.
struct Sample {
  double t_s = 0.0;
  MotionSet motions;
  WrenchSet wrenches;  ///< the flexible side's answer
  WrenchSet applied;   ///< what moved the multibody side; empty at t = 0
  std::int32_t iterations = 0;
  double residual_N = 0.0;
};

/// Both sides of an example as objects of this process, and their coupled run. The flexible side
/// may be several bodies, the multibody side several worlds.
class CoupledPair {
 public:
  using Overrides = std::vector<scenario::Override>;
  using Observer = std::function<void(const Sample&)>;

  /// `scenario` is a path below examples/.
  CoupledPair(const std::string& scenario, const Overrides& overrides);

  /// Runs once; `observer` is called at t = 0 and after every accepted macro step, with both sides
  /// in the state that the sample belongs to.
  RunReport run(orchestrator::Mode mode, const Observer& observer);

  [[nodiscard]] const orchestrator::Model& model() const { return model_; }
  /// The first world.
  [[nodiscard]] const mbs::RigidWorld& mbs() const { return *worlds_.at(0); }
  /// The first flexible body on a mesh.
  [[nodiscard]] const fem::FlexibleSide& fem() const { return *meshed_.at(0); }
  /// Of all flexible bodies.
  [[nodiscard]] const std::vector<PortInfo>& ports() const { return fem_->info().ports; }

  /// Momentum of the rigid bodies and of all nodes (kg m/s), about the origin of W (kg m²/s).
  [[nodiscard]] Eigen::Vector3d linear_momentum() const;
  [[nodiscard]] Eigen::Vector3d angular_momentum() const;

 private:
  orchestrator::Model model_;
  std::unique_ptr<MbsSide> mbs_;
  std::vector<const mbs::RigidWorld*> worlds_;    ///< within mbs_, in the order of the scenario
  std::unique_ptr<FemSide> fem_;                  ///< as the scheme needs it
  std::vector<const fem::FlexibleSide*> meshed_;  ///< within fem_, in the order of the scenario
};

/// A number as the value of an override, with all its digits.
[[nodiscard]] std::string text_of(double value);

/// What a difference is relative to: the largest norm of that quantity in the first run, of that
/// port, or of any port, where some hardly move.
enum class Scale { OwnPort, AnyPort };

/// Largest relative difference of the port quantities of two runs over all steps.
struct RelativeDifference {
  double motions = 0.0;   ///< of p, q, v, w
  double wrenches = 0.0;  ///< of f, t
};
[[nodiscard]] RelativeDifference largest_relative_difference(const std::vector<Sample>& a,
                                                             const std::vector<Sample>& b,
                                                             Scale scale = Scale::OwnPort);

}  // namespace tandem::coupled_test

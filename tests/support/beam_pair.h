#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fem_process/ancf/beam_body.h"
#include "mbs_process/rigid_world.h"
#include "orchestrator/scenario/model.h"
#include "protocol/driver/coupled_run.h"

namespace tandem::coupled_test {

/// Both sides of an example with an ANCF chain as objects of this process, and their coupled run.
class BeamPair {
 public:
  using Overrides = std::vector<scenario::Override>;
  using Observer = std::function<void(const BeamPair&)>;

  /// `scenario` is a path below examples/; overrides as --set takes them: "run.duration_s=0.4".
  BeamPair(const std::string& scenario, const std::vector<std::string>& overrides);

  /// Runs once; `observer` is called at t = 0 and after every accepted macro step.
  RunReport run(const Observer& observer);

  [[nodiscard]] const orchestrator::Model& model() const { return model_; }
  [[nodiscard]] const fem::ancf::BeamBody& fem() const { return *fem_; }
  [[nodiscard]] double t_s() const { return to_seconds(mbs_->state().time); }
  [[nodiscard]] const mbs::BodyState& body(const std::string& name) const;

  /// Momentum of rigid bodies and chain (kg m/s), and their mass (kg).
  [[nodiscard]] Eigen::Vector3d momentum() const;
  [[nodiscard]] double mass_kg() const;

 private:
  orchestrator::Model model_;
  std::unique_ptr<mbs::RigidWorld> mbs_;
  std::unique_ptr<FemSide> fem_side_;  ///< the chain, or the line's end before it
  fem::ancf::BeamBody* fem_ = nullptr;
};

}  // namespace tandem::coupled_test

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fem_process/ancf/beam_step.h"
#include "fem_process/ancf/beam_system.h"
#include "fem_process/ancf/chain_path.h"
#include "fem_process/ancf/contact_model.h"
#include "protocol/contract/sim_time.h"

namespace tandem::fem::ancf {

/// A damped phase before t = 0 with all wheels held and without friction, after which the chain is
/// at rest: tension has found its equilibrium.
struct SettleParams {
  SimTime duration{};  ///< 0: none
  SimTime step{};
  double mass_damping_per_s = 300.0;
};

/// A named point of the centre line that is reported.
struct WatchPoint {
  std::string name;
  int element = 0;
  double xi = 0.0;
};

/// Velocities at t = 0: v(r) = linear + angular × (r − about).
struct VelocityField {
  Eigen::Vector3d linear_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d about_m = Eigen::Vector3d::Zero();
};

/// Everything about a beam structure as the flexible side of a run.
struct BeamParams {
  BeamModel model;
  std::vector<Wheel> wheels;
  std::vector<Ground> grounds;
  std::vector<Attachment> attachments;
  ContactGrid grid;
  StepParams step;
  SettleParams settle;
  VelocityField velocity;
  std::vector<WatchPoint> watch;
  std::vector<std::string> ports;
  SimTime micro_step{};
  bool follows_macro_step = false;  ///< fem.micro_step_s is left out: steps of adaptive length
};

/// What locking in thickness makes of the bending of a chain with compatible strains as it lies at
/// t = 0: sections are linear between the nodes, so an element of length l that bends by the angle
/// θ must get thinner by θ²/8 in its middle, and is stiffer by the part θ² (l/h)²/10. Assumed
/// strains do not lock, and pins take the bend. A sentence with the number of elements that brings
/// the part below 5 %, or none.
[[nodiscard]] std::optional<std::string> bending_warning(const BeamModel& model);

/// Throws a Usage error when the links do not fit the seats of a sprocket: the angle of a link on
/// the radius of its centre line must be that of a seat within 5 %.
void check_teeth(const BeamParams& params);

/// Throws a Usage error when a wheel or ground reaches further into the band than half its height.
void check_overlap(const BeamParams& params, const MotionSet& motions);

}  // namespace tandem::fem::ancf

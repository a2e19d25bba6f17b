// Motion of ANCF beams against an independent program: the flexible pendulum, the settled track.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_process/ancf/beam_step.h"
#include "tests/support/ancf_support.h"

namespace tandem::fem::ancf {
namespace {

using testing::number;
using testing::read_rows;
using testing::Row;

struct Swing {
  Eigen::Vector3d half, end;  ///< tip at 0.5 s and 1 s (m)
  double drift = 0.0;         ///< largest change of the energy over the largest kinetic one
};

/// L = 1 m, 0.02 × 0.02 m, released horizontal; its pinned end may turn.
Swing swing(const BeamMaterial& material, Integration integration, int elements, SimTime h,
            double rho_inf, SimTime duration) {
  BeamModel model =
      testing::straight_beam(1.0, elements, {0.02, 0.02}, material, integration, Support::Hinged);
  model.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  model.strain = Strain::Compatible;  // as the reference
  model.order = {5, 3, 3};
  const BeamSystem system(std::move(model));
  const ContactModel nothing;
  const BeamStep step(system, nothing, {.rho_inf = rho_inf, .tolerance_m = 1e-10});
  BeamState state{.q = system.mesh().q0, .v = Eigen::VectorXd::Zero(system.mesh().unknowns())};
  ContactSums sums;
  EXPECT_TRUE(step.balance({}, state, sums));
  const auto energy = [&] {
    return system.kinetic_J(state.v) + system.elastic_J(state.q) + system.potential_J(state.q);
  };
  const double start = energy();
  const int tip = system.mesh().end_position.back();
  Swing result;
  double most = 0.0;
  double kinetic = 0.0;
  while (state.time < duration) {
    BeamStep::Result next = step.advance(state, {}, h);
    EXPECT_EQ(next.outcome, Outcome::Done) << next.message;
    if (next.outcome != Outcome::Done) return result;
    state = std::move(next.state);
    most = std::max(most, std::abs(energy() - start));
    kinetic = std::max(kinetic, system.kinetic_J(state.v));
    if (state.time == SimTime(500'000'000)) result.half = state.q.segment<3>(3 * tip);
    if (state.time == SimTime(1'000'000'000)) result.end = state.q.segment<3>(3 * tip);
  }
  result.drift = most / kinetic;
  return result;
}

BeamMaterial pendulum_material(const std::string& law) {
  BeamMaterial material = BeamMaterial::from_young(
      law == "0" ? ElasticLaw::NeoHookean : ElasticLaw::SaintVenantKirchhoff, 2e6, 0.3);
  material.density_kg_per_m3 = 7200.0;
  if (law == "4_visc1e-3") material.dilatation_s = material.deviation_s = 1e-3;
  return material;
}

TEST(AncfPendulum, MovesAndDriftsAsTheReference) {
  int compared = 0;
  for (const Row& row : read_rows("pendulum_summary.csv")) {
    const std::string& law = row.at("law");
    const bool on_axis = law.starts_with("4");
    const Swing seen =
        swing(pendulum_material(law), on_axis ? Integration::AxisD0 : Integration::Full,
              std::stoi(row.at("ne")), sim_time_from_seconds(number(row, "h")),
              number(row, "rhoinf"), SimTime(1'200'000'000));
    const std::string where = law + ", " + row.at("ne") + " elements, h " + row.at("h");
    // The tables have eight digits after the point, and seven of the drift.
    EXPECT_NEAR(seen.half.x(), number(row, "x_tip(0.5)"), 2e-8) << where;
    EXPECT_NEAR(seen.half.z(), number(row, "z_tip(0.5)"), 2e-8) << where;
    EXPECT_NEAR(seen.end.x(), number(row, "x_tip(1.0)"), 2e-8) << where;
    EXPECT_NEAR(seen.end.z(), number(row, "z_tip(1.0)"), 2e-8) << where;
    const double drift = number(row, "max_rel_drift(|E-E0|/max KE)");
    EXPECT_NEAR(seen.drift, drift, 1e-3 * drift) << where;
    ++compared;
  }
  EXPECT_EQ(compared, 11);
}

/// The chain of the vehicle around sprocket, idler and two rollers at rest, without friction.
struct Settled {
  explicit Settled(Integration integration);

  BeamSystem system;
  ContactModel contact;
  MotionSet wheels;
  BeamState state;
  ContactSums sums;
};

constexpr double kDistance = 0.837320;

BeamModel track_model(Integration integration) {
  const LoopPath path{.center1 = {0.0, 0.0, 0.21},
                      .center2 = {kDistance, 0.0, 0.21},
                      .radius1_m = 0.2,
                      .radius2_m = 0.2};
  return {
      .mesh = join(lay(
          path,
          {.elements = 24, .strain = 0.05, .lateral_stretch = 0.97824553, .joint = Joint::Pin})),
      .section = testing::kTrackSection,
      .material = testing::track_rubber(),
      .integration = integration,
      .strain = Strain::Compatible,  // as the reference
      .gravity_m_per_s2 = {0.0, 0.0, -9.81}};
}

ContactModel track_contact(const BeamSystem& system) {
  const ContactParams rubber{.stiffness_N_per_m3 = 9e7,
                             .damping_N_s_per_m3 = 2e3,
                             .friction = 1.2,
                             .friction_slope_N_s_per_m3 = 1e6};
  const Teeth teeth{.count = 10,
                    .phase_rad = 0.0529,
                    .pin_radius_m = 0.01,
                    .backlash = 0.1,
                    .height_m = 0.025,
                    .stiffness_N_per_m = 7.2e5,
                    .damping_N_s_per_m = 16.0};
  std::vector<Wheel> wheels;
  for (int port = 0; port < 4; ++port) {
    wheels.push_back({.port = port, .radius_m = port < 2 ? 0.19 : 0.09, .contact = rubber});
  }
  wheels.front().teeth = teeth;
  return {system.mesh(), system.model().section, wheels, {Ground{.contact = rubber}}, {}};
}

Settled::Settled(Integration integration)
    : system(track_model(integration)), contact(track_contact(system)), wheels(4) {
  for (int k = 0; k < 4; ++k) {
    wheels[static_cast<std::size_t>(k)].p_WP = {k == 0   ? 0.0
                                                : k == 1 ? kDistance
                                                         : kDistance * (k - 1) / 3.0,
                                                0.0, k < 2 ? 0.21 : 0.11};
  }
  const BeamStep step(system, contact, {.mass_damping_per_s = 300.0, .friction = false});
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(system.mesh().unknowns());
  state = {.q = system.mesh().q0, .v = zero, .a = zero, .A = zero};
  state.motions = wheels;
  state.wheels = WrenchSet(wheels.size());
  for (int k = 0; k < 600; ++k) {
    BeamStep::Result next = step.advance(state, {wheels, wheels}, SimTime(100'000));
    require(next.outcome == Outcome::Done, next.message);
    state = std::move(next.state);
    sums = next.sums;
  }
}

/// Mean of r_x − 1 over the centre line between the wheels.
double strain_of(const Settled& settled, int element) {
  const BeamVectors e = settled.system.mesh().gather(element, settled.state.q);
  const double length = settled.system.mesh().elements[static_cast<std::size_t>(element)].length_m;
  return (e * shape_gradients(length, 0.5, 0.0, 0.0)).col(0).norm() - 1.0;
}

TEST(AncfTrack, SettlesAsTheReference) {
  const Settled settled(Integration::Full);
  // Four digits of the energy, of the axle force and of the strain are stated.
  EXPECT_NEAR(settled.system.elastic_J(settled.state.q), 3269.0, 1.0);
  EXPECT_NEAR(settled.sums.wheels[1].f_P_W.x(), -136.0e3, 100.0);
  EXPECT_NEAR(settled.sums.depth_m, 0.0125, 0.0001);
  EXPECT_NEAR(strain_of(settled, 3), 0.0302, 0.0001);
  EXPECT_NEAR(strain_of(settled, 15), 0.0302, 0.0001);
  for (const Row& row : read_rows("settled_geometry.csv")) {
    const auto joint = static_cast<std::size_t>(std::stoi(row.at("joint")));
    const Eigen::Vector3d r =
        settled.state.q.segment<3>(3 * settled.system.mesh().end_position[2 * joint]);
    // Six digits after the point; the last oscillations of both runs are that large.
    EXPECT_NEAR(r.x(), number(row, "x"), 2e-6) << joint;
    EXPECT_NEAR(r.z(), number(row, "z"), 2e-6) << joint;
    EXPECT_NEAR(r.y(), 0.0, 1e-15) << joint;
  }
}

TEST(AncfTrack, SettlesAsTheReferenceWithAxisD0) {
  const Settled settled(Integration::AxisD0);
  EXPECT_NEAR(settled.system.elastic_J(settled.state.q), 3121.0, 1.0);
  EXPECT_NEAR(settled.sums.wheels[1].f_P_W.x(), -132.2e3, 100.0);
  EXPECT_NEAR(settled.sums.depth_m, 0.0115, 0.0001);
  EXPECT_NEAR(strain_of(settled, 3), 0.0293, 0.0001);
}

TEST(AncfTrack, PinsSitInTheSeats) {
  const Settled settled(Integration::Full);
  // Joints 20 … 23 inside the wrap of the sprocket: 36° apart at 0.1939 m.
  double before = 0.0;
  for (std::size_t joint = 20; joint < 24; ++joint) {
    const Eigen::Vector3d r =
        settled.state.q.segment<3>(3 * settled.system.mesh().end_position[2 * joint]) -
        settled.wheels[0].p_WP;
    EXPECT_NEAR(r.norm(), 0.1939, 1e-4);
    const double angle = std::atan2(r.x(), r.z());
    if (joint > 20) {
      EXPECT_NEAR(angle - before, 0.2 * std::numbers::pi, 0.1 * std::numbers::pi / 180);
    }
    before = angle;
  }
}

}  // namespace
}  // namespace tandem::fem::ancf

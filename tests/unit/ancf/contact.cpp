#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "fem_process/ancf/contact_model.h"
#include "tests/support/ancf_support.h"

namespace tandem::fem::ancf {
namespace {

const ContactParams kRubber{.stiffness_N_per_m3 = 9e7,
                            .damping_N_s_per_m3 = 2e3,
                            .friction = 1.2,
                            .friction_slope_N_s_per_m3 = 1e6};

Motion spinning_wheel() {
  Motion wheel;
  wheel.p_WP = {0.3, -0.1, 0.5};
  wheel.q_WP = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 0.3, -0.2).normalized());
  wheel.v_WP = {0.2, 0.1, -0.3};
  wheel.w_WP = {1.0, 12.0, -2.0};
  return wheel;
}

/// A point of the band inside a cylinder of 0.19 m, at a depth.
Eigen::Vector3d inside_point(const Motion& wheel, double depth_m) {
  const double rho = 0.19 - depth_m;
  return wheel.p_WP + wheel.q_WP * Eigen::Vector3d(rho * std::sin(0.7), 0.1, rho * std::cos(0.7));
}

Traction on_wheel(const Motion& wheel, const Eigen::Vector3d& r, const Eigen::Vector3d& v) {
  Traction out;
  ContactPoint point;
  EXPECT_TRUE(on_cylinder(0.19, wheel.q_WP * Eigen::Vector3d::UnitY(), wheel, r, v, true, point) &&
              traction(kRubber, point, true, out));
  return out;
}

TEST(AncfContact, CylinderTangentsAreTheDerivativesInStickAndInSlip) {
  const Motion wheel = spinning_wheel();
  // At 5 mm damping acts in full, at 4 µm it comes in.
  for (const double depth : {5e-3, 4e-6}) {
    const Eigen::Vector3d r = inside_point(wheel, depth);
    const Eigen::Vector3d carried = wheel.v_WP + wheel.w_WP.cross(r - wheel.p_WP);
    const Eigen::Vector3d outwards =
        wheel.q_WP * Eigen::Vector3d(std::sin(0.7), 0.0, std::cos(0.7));
    const Eigen::Vector3d along =
        wheel.q_WP * Eigen::Vector3d(0.8 * std::cos(0.7), 0.6, -0.8 * std::sin(0.7));
    // Sticks; slips.
    for (const double speed : {1e-4, 2.0}) {
      const Eigen::Vector3d v = carried + speed * along - 0.05 * outwards;
      const Traction at = on_wheel(wheel, r, v);
      Eigen::Matrix3d by_r;
      Eigen::Matrix3d by_v;
      const double step = 1e-8;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(k);
        by_r.col(k) =
            (on_wheel(wheel, r + d, v).force - on_wheel(wheel, r - d, v).force) / (2 * step);
        by_v.col(k) =
            (on_wheel(wheel, r, v + d).force - on_wheel(wheel, r, v - d).force) / (2 * step);
      }
      // Central differences of 1e-8 m of a depth that has a round-off of 1e-17 m.
      EXPECT_LT((at.by_position - by_r).norm(), 1e-6 * by_r.norm()) << depth << " " << speed;
      EXPECT_LT((at.by_velocity - by_v).norm(), 1e-6 * by_v.norm()) << depth << " " << speed;
    }
  }
}

TEST(AncfContact, PressureBeginsAtZeroHoweverFastThePointComes) {
  // As printed it would begin at c d' = 2e3 Pa here; from d₀ on it is k d + c d'.
  ContactPoint point{.normal = Eigen::Vector3d::UnitZ(), .approach = {0.0, 0.0, -1.0}};
  Traction out;
  point.depth = 1e-12;
  ASSERT_TRUE(traction(kRubber, point, false, out));
  EXPECT_LT(out.pressure, 1e-3);
  for (const double depth : {1e-5, 1e-4}) {
    point.depth = depth;
    ASSERT_TRUE(traction(kRubber, point, false, out));
    EXPECT_NEAR(out.pressure, 9e7 * depth + 2e3, 1e-9);
  }
}

TEST(AncfContact, FrictionIsTrilinear) {
  const ContactPoint still{.normal = Eigen::Vector3d::UnitZ(), .depth = 1e-3};
  const double p = 9e7 * 1e-3;
  const double v_0 = 1.2 * p / 1e6;
  for (const double slip : {-3.0 * v_0, -0.5 * v_0, 0.0, 0.25 * v_0, 0.999 * v_0, 20.0 * v_0}) {
    ContactPoint point = still;
    point.slip = {slip, 0.0, 0.7};  // the normal part is no slip
    Traction out;
    ASSERT_TRUE(traction(kRubber, point, false, out));
    EXPECT_NEAR(out.force.z(), p, 1e-12 * p);
    EXPECT_NEAR(out.force.x(), -std::clamp(1e6 * slip, -1.2 * p, 1.2 * p), 1e-9 * p) << slip;
  }
}

TEST(AncfContact, ThereIsNoAdhesion) {
  ContactPoint point{.normal = Eigen::Vector3d::UnitZ(), .depth = 1e-4};
  point.approach = {0.0, 0.0, 100.0};  // leaves fast: k d + c d' < 0
  Traction out;
  out.force = {1.0, 2.0, 3.0};  // of another point
  ASSERT_TRUE(traction(kRubber, point, true, out));
  EXPECT_EQ(out.force.norm() + out.by_position.norm() + out.by_velocity.norm(), 0.0);
}

// Whatever its speed, what a point on its way out does to the band and what is lost are what it has
// stored: p d' = k d d' + loss; without adhesion the spring's energy is lost as fast as it falls.
TEST(AncfContact, FastSeparationLosesWhatWasStored) {
  const double k = 9e7, depth = 1e-4;
  for (const double leaving : {0.1, 4.4, 4.6, 100.0}) {  // p = 0 at k d/c = 4.5 m/s
    const ContactPoint point{
        .normal = Eigen::Vector3d::UnitZ(), .approach = {0.0, 0.0, leaving}, .depth = depth};
    Traction out;
    ASSERT_TRUE(traction(kRubber, point, false, out));
    EXPECT_DOUBLE_EQ(out.stored, 0.5 * k * depth * depth);
    EXPECT_NEAR(out.loss, (k * depth - out.pressure) * leaving, 1e-12 * k * depth * leaving);
    EXPECT_EQ(out.pressure > 0.0, leaving < 4.5) << leaving;
  }
}

TEST(AncfContact, OutsideThereIsNoPoint) {
  const Motion wheel;
  ContactPoint point;
  EXPECT_FALSE(on_cylinder(0.19, Eigen::Vector3d::UnitY(), wheel, {0.0, 5.0, 0.1901},
                           Eigen::Vector3d::Zero(), false, point));
  EXPECT_FALSE(on_plane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), {0.0, 0.0, 1e-9},
                        Eigen::Vector3d::Zero(), point));
}

const Teeth kTeeth{.count = 10,
                   .phase_rad = 0.05,
                   .pin_radius_m = 0.01,
                   .backlash = 0.1,
                   .height_m = 0.025,
                   .stiffness_N_per_m = 7.2e5,
                   .damping_N_s_per_m = 16.0};

Eigen::Vector3d pin_at(double angle, double radius) {
  return {radius * std::sin(angle), 0.0, radius * std::cos(angle)};
}

TEST(AncfTeeth, PushAPinBackToItsSeatBeyondTheBacklash) {
  const Motion wheel;
  const double seat = kTeeth.phase_rad + 3 * 0.2 * std::numbers::pi;
  for (const double away : {-0.05, -0.004, 0.004, 0.05}) {
    const Eigen::Vector3d r = pin_at(seat + away, 0.194);
    EXPECT_NEAR(seat_angle(kTeeth, wheel, r), away, 1e-14);
    ToothForce out;
    const double depth = 0.194 * std::sin(std::abs(away)) - 0.001;
    ASSERT_EQ(tooth_force(kTeeth, 0.19, wheel, r, Eigen::Vector3d::Zero(), out), depth > 0.0);
    if (depth <= 0.0) continue;
    // Fully engaged below R + h − r_pin = 0.205 m; along the circle, against the deviation.
    EXPECT_NEAR(out.force.norm(), 7.2e5 * depth, 1e-6);
    const Eigen::Vector3d along(std::cos(seat + away), 0.0, -std::sin(seat + away));
    EXPECT_NEAR(out.force.dot(along), -std::copysign(7.2e5 * depth, away), 1e-6);
  }
}

TEST(AncfTeeth, LetGoAboveTheirTips) {
  ToothForce out;
  const double angle = kTeeth.phase_rad + 0.1;
  EXPECT_FALSE(
      tooth_force(kTeeth, 0.19, Motion{}, pin_at(angle, 0.2151), Eigen::Vector3d::Zero(), out));
  ASSERT_TRUE(
      tooth_force(kTeeth, 0.19, Motion{}, pin_at(angle, 0.21), Eigen::Vector3d::Zero(), out));
  EXPECT_NEAR(out.force.norm(), 0.5 * 7.2e5 * (0.21 * std::sin(0.1) - 0.001), 1e-6);
}

TEST(AncfTeeth, TurnWithTheWheel) {
  Motion wheel;
  wheel.q_WP = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
  EXPECT_NEAR(seat_angle(kTeeth, wheel, pin_at(kTeeth.phase_rad + 0.3, 0.19)), 0.0, 1e-14);
}

// What a tooth and a pin do to each other is what the tooth's energy loses, or is booked as lost:
// F·w = −dU/dt − loss, by central differences of U along the motion of pin and wheel, engaged in
// full and on the way out, on either flank. Without damping, too: the tangential force is not the
// gradient of U, a pin that leaves its seat outwards takes U with it.
TEST(AncfTeeth, BookWhatTheirEnergyLosesAndTheForceDoesNotDo) {
  for (const double damping : {0.0, 16.0}) {
    Teeth teeth = kTeeth;
    teeth.damping_N_s_per_m = damping;
    for (const double away : {-0.06, 0.02, 0.2}) {
      for (const double radius : {0.194, 0.2081, 0.2135}) {
        const Motion wheel = spinning_wheel();
        const Eigen::Vector3d r = wheel.p_WP + wheel.q_WP * pin_at(teeth.phase_rad + away, radius);
        const Eigen::Vector3d v(0.7, 0.3, 0.4);
        const auto stored_J = [&](double dt) {
          Motion moved = wheel;
          moved.p_WP += dt * wheel.v_WP;
          const double angle = dt * wheel.w_WP.norm();
          moved.q_WP = Eigen::AngleAxisd(angle, wheel.w_WP.normalized()) * wheel.q_WP;
          ToothForce out;
          return tooth_force(teeth, 0.19, moved, r + dt * v, v, out) ? out.stored_J : 0.0;
        };
        ToothForce out;
        ASSERT_TRUE(tooth_force(teeth, 0.19, wheel, r, v, out));
        const Eigen::Vector3d w = v - wheel.v_WP - wheel.w_WP.cross(r - wheel.p_WP);
        constexpr double kDelta = 1e-7;
        const double stored_W = (stored_J(kDelta) - stored_J(-kDelta)) / (2.0 * kDelta);
        const double scale_W = out.force.norm() * w.norm() + std::abs(stored_W);
        EXPECT_NEAR(out.loss_W, -out.force.dot(w) - stored_W, 1e-6 * scale_W)
            << away << " rad, " << radius << " m, " << damping << " N s/m";
      }
    }
  }
}

TEST(AncfContactModel, WheelsAndGroundFeelWhatTheBandLoses) {
  // Momentum and moment of momentum: the generalised forces of a rigid translation and rotation of
  // the band are the sums of the contact forces.
  const BeamMesh mesh =
      join(lay(LinePath{.start = {-0.3, 0.0, 0.0}, .length_m = 0.6}, {.elements = 5}));
  Wheel wheel{.port = 0, .radius_m = 0.2, .contact = kRubber};
  wheel.teeth = kTeeth;
  wheel.teeth->phase_rad = 0.0;  // the pin at x = 0.06 m stands 0.05 rad from it
  const ContactModel contact(
      mesh, testing::kTrackSection, {wheel},
      {Ground{
          .point_m = {0.0, 0.0, 0.005}, .normal = -Eigen::Vector3d::UnitZ(), .contact = kRubber}},
      {});
  MotionSet motions(1);
  motions[0].p_WP = {0.05, 0.0, -0.2};
  motions[0].w_WP = {0.0, 5.0, 0.0};
  Eigen::VectorXd v = Eigen::VectorXd::Zero(mesh.unknowns());
  for (int end : mesh.end_position) v.segment<3>(3 * end) = Eigen::Vector3d(0.5, 0.1, 0.0);
  ElementArrays elements{std::vector<double>(5 * kCoordinates), {}};
  ContactSums sums;
  contact.add(mesh.q0, v, motions, true, std::nullopt, elements, sums);
  EXPECT_GT(sums.wheels[0].f_P_W.norm(), 1.0);
  EXPECT_GT(sums.ground.norm(), 1.0);
  EXPECT_GT(sums.seated_pins, 0);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int e = 0; e < 5; ++e) {
    const BeamVectors vectors = mesh.gather(e, mesh.q0);
    const double* f = elements.force_of(e);
    for (int slot = 0; slot < kVectors; ++slot) {
      const Eigen::Vector3d part(f[3 * slot], f[3 * slot + 1], f[3 * slot + 2]);
      if (slot % 4 == 0) force -= part;
      moment -= vectors.col(slot).cross(part);
    }
  }
  EXPECT_LT((force + sums.wheels[0].f_P_W + sums.ground).norm(), 1e-10 * force.norm());
  // The ground's own moment is not summed: take it out of the balance by a band without ground.
  const ContactModel wheel_only(mesh, testing::kTrackSection, {wheel}, {}, {});
  std::fill(elements.force.begin(), elements.force.end(), 0.0);
  wheel_only.add(mesh.q0, v, motions, true, std::nullopt, elements, sums);
  moment.setZero();
  for (int e = 0; e < 5; ++e) {
    const BeamVectors vectors = mesh.gather(e, mesh.q0);
    const Eigen::Map<const BeamVectors> f(elements.force_of(e));
    for (int slot = 0; slot < kVectors; ++slot) moment -= vectors.col(slot).cross(f.col(slot));
  }
  const Wrench& wrench = sums.wheels[0];
  const Eigen::Vector3d on_wheel = wrench.t_P_W + motions[0].p_WP.cross(wrench.f_P_W);
  EXPECT_LT((moment + on_wheel).norm(), 1e-10 * on_wheel.norm());
}

TEST(AncfContactModel, TangentIsTheDerivativeOfTheForces) {
  const BeamMesh mesh =
      join(lay(LinePath{.start = {-0.15, 0.0, 0.0}, .length_m = 0.3}, {.elements = 2}));
  // Without teeth, whose derivatives leave out those of direction and engagement.
  const Wheel wheel{.port = 0, .radius_m = 0.2, .contact = kRubber};
  const ContactModel contact(mesh, testing::kTrackSection, {wheel}, {}, {});
  MotionSet motions(1);
  motions[0].p_WP = {0.05, 0.0, -0.2};
  motions[0].w_WP = {0.0, 5.0, 0.0};
  Eigen::VectorXd v = Eigen::VectorXd::Zero(mesh.unknowns());
  for (int end : mesh.end_position) v.segment<3>(3 * end) = Eigen::Vector3d(0.5, 0.1, 0.0);
  const auto forces = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& rate) {
    ElementArrays elements{std::vector<double>(2 * kCoordinates), {}};
    ContactSums sums;
    contact.add(q, rate, motions, true, std::nullopt, elements, sums);
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(elements.force.data(), 2 * kCoordinates));
  };
  const double theta = 1e3;
  ElementArrays elements{std::vector<double>(2 * kCoordinates),
                         std::vector<double>(2 * kCoordinates * kCoordinates)};
  ContactSums sums;
  contact.add(mesh.q0, v, motions, true, theta, elements, sums);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(2 * kCoordinates, mesh.unknowns());
  for (int e = 0; e < 2; ++e) {
    const Eigen::Map<const Eigen::Matrix<double, kCoordinates, kCoordinates, Eigen::RowMajor>> K_e(
        elements.tangent_of(e));
    for (const Term& term : mesh.elements[static_cast<std::size_t>(e)].terms) {
      K.block(kCoordinates * e, 3 * term.vector, kCoordinates, 3) +=
          K_e.middleCols<3>(3 * term.slot);
    }
  }
  Eigen::MatrixXd expected(2 * kCoordinates, mesh.unknowns());
  const double step = 1e-8;
  for (Eigen::Index j = 0; j < mesh.unknowns(); ++j) {
    const Eigen::VectorXd d = step * Eigen::VectorXd::Unit(mesh.unknowns(), j);
    expected.col(j) = (forces(mesh.q0 + d, v) - forces(mesh.q0 - d, v)) / (2 * step) +
                      theta * (forces(mesh.q0, v + d) - forces(mesh.q0, v - d)) / (2 * step);
  }
  // Steps of 1e-8 keep every point on its side of contact and slip; round-off 1e-7.
  EXPECT_LT((K - expected).norm(), 1e-6 * expected.norm());
}

}  // namespace
}  // namespace tandem::fem::ancf

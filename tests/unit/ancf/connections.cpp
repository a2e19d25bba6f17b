#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "tests/support/ancf_support.h"

namespace tandem::fem::ancf {
namespace {

using testing::kTrackSection;
using testing::track_rubber;

LoopPath track_path() {
  return {.center1 = {0.0, 0.0, 0.21},
          .center2 = {0.83732, 0.0, 0.21},
          .radius1_m = 0.2,
          .radius2_m = 0.2};
}

TEST(AncfConnections, ClosedPinnedChainOf24HasThePapers432Unknowns) {
  const BeamMesh mesh = join(lay(track_path(), {.elements = 24, .joint = Joint::Pin}));
  EXPECT_EQ(mesh.unknowns(), 432);
  const BeamSystem system({.mesh = mesh, .section = kTrackSection, .material = track_rubber()});
  EXPECT_EQ(system.solver().pattern().entries(), 12960U);
}

TEST(AncfConnections, PinsShareThePointAndTheGradientAlongTheAxisOnly) {
  const BeamMesh mesh = join(lay(track_path(), {.elements = 24, .joint = Joint::Pin}));
  Eigen::VectorXd q = mesh.q0;
  for (Eigen::Index i = 0; i < q.size(); ++i) q(i) += 0.01 * std::sin(1.7 * static_cast<double>(i));
  for (int e = 0; e < 24; ++e) {
    const BeamVectors left = mesh.gather(e, q);
    const BeamVectors right = mesh.gather((e + 1) % 24, q);
    EXPECT_EQ(left.col(4), right.col(0));
    EXPECT_EQ(left.col(6), right.col(2));
    EXPECT_NE(left.col(5), right.col(1));
    EXPECT_NE(left.col(7), right.col(3));
  }
}

TEST(AncfConnections, AnObliquePinSharesTheGradientAlongItsAxis) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 0.9, -0.4).normalized();
  const BeamMesh mesh =
      join(lay(LinePath{.length_m = 1.0}, {.elements = 3, .joint = Joint::Pin, .pin_axis = axis}));
  Eigen::VectorXd q = mesh.q0;
  for (Eigen::Index i = 0; i < q.size(); ++i) q(i) += 0.1 * std::sin(2.3 * static_cast<double>(i));
  for (int e = 0; e < 2; ++e) {
    const Eigen::Matrix3d left = mesh.gather(e, q).block<3, 3>(0, 5);
    const Eigen::Matrix3d right = mesh.gather(e + 1, q).block<3, 3>(0, 1);
    // The common gradient r_α; nothing else of the two is the same.
    EXPECT_LT((left * axis - right * axis).norm(), 1e-15);
    EXPECT_GT((left - right).norm(), 0.1);
  }
  // Shared: r and one gradient of three at each of two pins.
  EXPECT_EQ(mesh.unknowns(), 3 * 24 - 2 * 6);
  // At rest the projection gives back the frames it was made of.
  EXPECT_LT((mesh.gather(1, mesh.q0).block<3, 3>(0, 1) - Eigen::Matrix3d::Identity()).norm(),
            1e-15);
}

TEST(AncfConnections, PinsCarryNoMoment) {
  // Two elements, the second turned about the pin: no force arises.
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0.0, 1.0, 0.0), Eigen::Vector3d(0.6, 0.8, 0.0)}) {
    const BeamMesh straight = join(
        lay(LinePath{.length_m = 0.24}, {.elements = 2, .joint = Joint::Pin, .pin_axis = axis}));
    Chain chain =
        lay(LinePath{.length_m = 0.24}, {.elements = 2, .joint = Joint::Pin, .pin_axis = axis});
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7, axis).toRotationMatrix();
    chain.ends[2].gradients = R;
    chain.ends[3].gradients = R;
    chain.ends[3].r = chain.ends[2].r + 0.12 * R.col(0);
    const BeamMesh bent = join(chain);
    ASSERT_EQ(bent.unknowns(), straight.unknowns());
    const BeamSystem system({.mesh = bent, .section = kTrackSection, .material = track_rubber()});
    ElementArrays elements = system.element_arrays();
    system.kernel().forces(bent.q0, Eigen::VectorXd::Zero(bent.unknowns()), elements);
    Eigen::VectorXd f = Eigen::VectorXd::Zero(bent.unknowns());
    system.add_forces(elements, f);
    EXPECT_LT(f.cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(AncfConnections, AssembledTangentIsTheDerivativeOfTheAssembledForces) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.2, 0.9, 0.1).normalized();
  BeamMesh mesh =
      join(lay(LinePath{.length_m = 0.5}, {.elements = 5, .joint = Joint::Pin, .pin_axis = axis}));
  support(mesh, false, Support::Clamped);
  const BeamSystem system({.mesh = mesh, .section = kTrackSection, .material = track_rubber()});
  const Eigen::Index n = mesh.unknowns();
  Eigen::VectorXd q = mesh.q0;
  for (Eigen::Index i = 0; i < n; ++i) q(i) += 2e-3 * std::sin(3.1 * static_cast<double>(i));
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n);
  ElementArrays elements = system.element_arrays();
  const auto force = [&](const Eigen::VectorXd& at) {
    system.kernel().forces(at, rest, elements);
    Eigen::VectorXd f = Eigen::VectorXd::Zero(n);
    system.add_forces(elements, f);
    system.clear_fixed(f);
    return f;
  };
  system.kernel().tangents(q, rest, 0.0, elements);
  std::vector<double> values;
  system.assemble(elements, 7.0, values);
  const ColumnPattern& pattern = system.solver().pattern();
  double scale = 0.0;
  double worst = 0.0;
  for (int j = 0; j < n; ++j) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(n);
    const auto at = static_cast<std::size_t>(j);
    for (int p = pattern.column_start[at]; p < pattern.column_start[at + 1]; ++p) {
      column(pattern.row[static_cast<std::size_t>(p)]) = values[static_cast<std::size_t>(p)];
    }
    Eigen::VectorXd expected = Eigen::VectorXd::Unit(n, j);
    if (!mesh.fixed[at / 3]) {
      const Eigen::VectorXd d = 1e-6 * Eigen::VectorXd::Unit(n, j);
      expected = (force(q + d) - force(q - d)) / 2e-6 +
                 7.0 * system.mass_times(Eigen::VectorXd::Unit(n, j));
      system.clear_fixed(expected);
    }
    scale = std::max(scale, expected.norm());
    worst = std::max(worst, (column - expected).norm());
  }
  EXPECT_LT(worst, 1e-7 * scale);
}

TEST(AncfConnections, LoopClosesOnItselfWithUnequalWheels) {
  const LoopPath path{
      .center1 = {0.1, 0.0, 0.3}, .center2 = {1.1, 0.0, 0.5}, .radius1_m = 0.3, .radius2_m = 0.15};
  const double length = path.length_m();
  EXPECT_LT((path.at(0.0).r - path.at(length * (1.0 - 1e-12)).r).norm(), 1e-9);
  double summed = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const PathPoint a = path.at(length * i / n);
    const PathPoint b = path.at(length * (i + 1) / n);
    summed += (b.r - a.r).norm();
    EXPECT_NEAR(a.axes.determinant(), 1.0, 1e-12);
    // Along the path, and outward of the line between the centres.
    EXPECT_GT((b.r - a.r).normalized().dot(a.axes.col(0)), 1.0 - 1e-6);
    EXPECT_GT(a.axes.col(2).dot(a.r - Eigen::Vector3d(0.6, 0.0, 0.4)), 0.0);
  }
  // Chords of arcs of 1.5e-4 m.
  EXPECT_NEAR(summed, length, 1e-6);
}

TEST(AncfConnections, MassAndWeightAreThoseOfTheBand) {
  BeamModel model{
      .mesh = join(lay(track_path(), {.elements = 24, .strain = 0.05, .joint = Joint::Pin})),
      .section = kTrackSection,
      .material = track_rubber(),
      .gravity_m_per_s2 = {0.0, 0.0, -9.81}};
  const double length = model.mesh.elements.front().length_m;
  EXPECT_NEAR(length, 0.116321, 1e-6);
  const BeamSystem system(std::move(model));
  const double mass = 24 * 0.008 * length * 2000.0;
  EXPECT_NEAR(system.mass_kg(), mass, 1e-12 * mass);
  EXPECT_NEAR(mass, 44.7, 0.05);
  // Translation at 2 m/s: momentum and energy of a rigid body.
  Eigen::VectorXd v = Eigen::VectorXd::Zero(system.mesh().unknowns());
  for (int end : system.mesh().end_position) v(3 * end) = 2.0;
  EXPECT_NEAR(system.kinetic_J(v), 2.0 * mass, 1e-12 * mass);
  EXPECT_NEAR(system.momentum(v).x(), 2.0 * mass, 1e-12 * mass);
}

}  // namespace
}  // namespace tandem::fem::ancf

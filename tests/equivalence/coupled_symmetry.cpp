// Two equal flexible bodies on one rigid body, each the other's image: so are their answers.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

/// What maps the right body's force and torque, and the hub's v and w, to those of the image.
struct Image {
  Eigen::Vector3d force, torque;
};
const Image kHalfTurn{{-1, -1, 1}, {-1, -1, 1}};
const Image kMirrorX{{-1, 1, 1}, {1, -1, -1}};

/// Largest over all steps: f (N), t (N m), v (m/s), w (rad/s).
struct Asymmetry {
  double f = 0.0, t = 0.0, v = 0.0, w = 0.0;
  double largest_f = 0.0, largest_t = 0.0;
};

Asymmetry asymmetry(Mode mode, const Image& image, const CoupledPair::Overrides& overrides) {
  CoupledPair pair("../tests/data/coupled/systems/wings.yaml", overrides);
  Asymmetry found;
  const RunReport report = pair.run(mode, [&](const Sample& sample) {
    const auto keep = [](double& largest, const Eigen::Vector3d& a) {
      largest = std::max(largest, a.norm());
    };
    const Wrench& right = sample.wrenches.at(0);
    const Wrench& left = sample.wrenches.at(1);
    const Motion& hub = sample.motions.at(0);
    keep(found.f, left.f_P_W - image.force.cwiseProduct(right.f_P_W));
    keep(found.t, left.t_P_W - image.torque.cwiseProduct(right.t_P_W));
    keep(found.v, hub.v_WP - image.force.cwiseProduct(hub.v_WP));
    keep(found.w, hub.w_WP - image.torque.cwiseProduct(hub.w_WP));
    keep(found.largest_f, right.f_P_W);
    keep(found.largest_t, right.t_P_W);
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  // The force of 300 N shakes all of 20 kg and two bodies of 3 kg.
  EXPECT_GT(found.largest_f, 10.0);
  EXPECT_GT(found.largest_t, 1.0);
  return found;
}

const CoupledPair::Overrides kMirrored = {
    {"fem.left.mesh.file",
     std::string(TANDEM_SOURCE_DIR) + "/tests/data/coupled/systems/two_bodies_mirrored.inp"},
    {"fem.left.mesh.position_m", "[-0.15, -0.25, -0.05]"},
    {"fem.left.mesh.orientation_wxyz", "[1, 0, 0, 0]"}};

// A half turn about z changes signs of x and y, and nothing else of any operation: the elements,
// their nodes and the unknowns stand in the same order. What is added on the hub, f + f', has the
// bits of f' + f. The spin brings in centrifugal forces. (The default formulation and pcg round a
// turned body differently; see below.)
TEST(Symmetry, OfAHalfTurnIsInTheBits) {
  for (const char* formulation : {"linear", "corotational_consistent"}) {
    const Asymmetry found = asymmetry(Mode::Inproc, kHalfTurn,
                                      {{"coupling.scheme", "explicit_serial"},
                                       {"fem.right.formulation", formulation},
                                       {"fem.left.formulation", formulation},
                                       {"mbs.bodies.hub.angular_velocity_rad_per_s", "[0, 0, 5]"}});
    EXPECT_EQ(found.f, 0.0) << formulation;
    EXPECT_EQ(found.t, 0.0) << formulation;
    EXPECT_EQ(found.v, 0.0) << formulation;
    EXPECT_EQ(found.w, 0.0) << formulation;
  }
}

// The Newton matrix is eliminated port after port, and the mirrored mesh has its elements' nodes in
// another order: both round differently on the two sides. Each of 100 steps leaves up to 1e-11 of
// the wrench where the residual ends, and half of that asymmetrically: 1e-10 of it at any time.
// Over 0.1 s that is 1e-10 × 120 N × 0.1 s on 20 kg, and 30 N m on 0.4 kg m².
TEST(Symmetry, OfAHalfTurnAndAMirrorIsKeptToRoundOff) {
  for (const bool mirrored : {false, true}) {
    CoupledPair::Overrides overrides = mirrored ? kMirrored : CoupledPair::Overrides{};
    overrides.push_back(
        {"mbs.bodies.hub.angular_velocity_rad_per_s", mirrored ? "[3, 0, 0]" : "[0, 0, 5]"});
    for (const Mode mode : {Mode::Monolithic, Mode::Inproc}) {
      const Asymmetry found = asymmetry(mode, mirrored ? kMirrorX : kHalfTurn, overrides);
      EXPECT_LT(found.f, 1e-10 * found.largest_f) << mirrored;
      EXPECT_LT(found.t, 1e-10 * found.largest_t) << mirrored;
      EXPECT_LT(found.v, 1e-10 * 120.0 * 0.1 / 20.0) << mirrored;
      EXPECT_LT(found.w, 1e-10 * 30.0 * 0.1 / 0.4) << mirrored;
    }
  }
}

}  // namespace
}  // namespace tandem::coupled_test

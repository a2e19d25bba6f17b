#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/support/fem_ports.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// Nodes 0 … n − 1 at fixed, irregular places; `planar`: in a plane that is no coordinate plane.
struct Cloud {
  std::vector<int> nodes;
  std::vector<double> weights;
  std::vector<Eigen::Vector3d> arms;
  NodeAverage average() const { return {nodes, weights, arms}; }
};

Cloud cloud(bool planar) {
  Cloud made;
  for (int i = 0; i < 9; ++i) {
    Eigen::Vector3d r(std::sin(1.0 + 2.0 * i), std::cos(3.0 * i), std::sin(5.0 * i * i));
    if (planar) r = rotation({0.5, 0.9, -0.4}) * Eigen::Vector3d(r.x(), r.y(), 0.0);
    made.nodes.push_back(i);
    made.weights.push_back(1.0 + 0.3 * (i % 4));
    made.arms.push_back(0.1 * r + Eigen::Vector3d(0.2, -0.1, 0.3));
  }
  return made;
}

Eigen::VectorXd placed(const Cloud& cloud, const Motion& motion, double noise = 0.0) {
  Eigen::VectorXd x(27);
  for (int i = 0; i < 9; ++i) {
    x.segment<3>(3 * i) = motion.p_WP + motion.q_WP * cloud.arms[static_cast<std::size_t>(i)];
  }
  for (int c = 0; c < 27; ++c) x(c) += noise * std::sin(11.0 + 13.0 * c);
  return x;
}

// Round-off: 0.1 m sets at 1 m from the origin, and an eigenvalue gap of a tenth of the largest.
TEST(NodeAverage, FrameFollowsRigidMotionsOfAnySize) {
  for (bool planar : {false, true}) {
    const Cloud nodes = cloud(planar);
    for (const Eigen::Vector3d& turn : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.3, 2.0, -1.0),
                                        Eigen::Vector3d(3.1, 0, 0.2)}) {
      const Motion motion{.p_WP = {0.4, -0.7, 0.2}, .q_WP = rotation(turn)};
      const Vector12 q = nodes.average().coordinates(placed(nodes, motion));
      EXPECT_LT((NodeAverage::rotation(q) - motion.q_WP.toRotationMatrix()).norm(), 1e-13);
      EXPECT_LT((q - rigid_coordinates(nodes.average(), motion)).norm(), 1e-15);
    }
  }
}

// The frame makes the weighted squares smallest: no small turn of it lowers them.
TEST(NodeAverage, FrameIsTheLeastSquaresOne) {
  const Cloud nodes = cloud(false);
  const NodeAverage average = nodes.average();
  const Eigen::VectorXd x = placed(nodes, {.q_WP = rotation({0.9, -1.4, 0.3})}, 0.02);
  const Vector12 q = average.coordinates(x);
  const auto squares = [&](const Eigen::Matrix3d& R) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 9; ++i) {
      const Eigen::Vector3d gap = x.segment<3>(3 * static_cast<Eigen::Index>(i)) - q.head<3>() -
                                  R * (nodes.arms[i] - average.centroid());
      sum += nodes.weights[i] * gap.squaredNorm();
    }
    return sum;
  };
  const Eigen::Matrix3d R = NodeAverage::rotation(q);
  for (int axis = 0; axis < 3; ++axis) {
    for (double angle : {-0.01, 0.01}) {
      const Eigen::Matrix3d turned =
          rotation(angle * Eigen::Vector3d::Unit(axis)).toRotationMatrix() * R;
      EXPECT_GT(squares(turned), squares(R));
    }
  }
}

// f_i = w_i (F + τ × R r_i/ℓ) has the resultants that the twelve forces say, and their power.
TEST(NodeAverage, NodalForcesHaveTheirResultantsAndPower) {
  const Cloud nodes = cloud(true);
  const NodeAverage average = nodes.average();
  const Eigen::VectorXd x = placed(nodes, {.q_WP = rotation({0.9, -1.4, 0.3})}, 0.05);
  const Eigen::VectorXd v = placed(nodes, {}, 1.0);
  const Vector12 phi = Vector12::Random();
  Eigen::VectorXd f = Eigen::VectorXd::Zero(27);
  average.add_forces(phi, 1.0, f);
  const Vector12 q = average.coordinates(x);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Eigen::Vector3d of_phi = Eigen::Vector3d::Zero();
  for (int i = 0; i < 27; i += 3) {
    force += f.segment<3>(i);
    moment += Eigen::Vector3d(x.segment<3>(i)).cross(Eigen::Vector3d(f.segment<3>(i)));
  }
  for (int j = 0; j < 12; j += 3) {
    of_phi += Eigen::Vector3d(q.segment<3>(j)).cross(Eigen::Vector3d(phi.segment<3>(j)));
  }
  EXPECT_LT((force - phi.head<3>()).norm(), 1e-14);
  EXPECT_LT((moment - of_phi).norm(), 1e-14);
  EXPECT_NEAR(f.dot(v), phi.dot(average.coordinates(v)), 1e-13);
}

/// A view with the nodes turned by about 1.2 rad against the port, deformed and moving.
PortView moved_view(const Cloud& nodes) {
  const Motion relative{.p_WP = {0.02, -0.03, 0.01}, .q_WP = rotation({0.7, -0.9, 0.4})};
  return {.q = nodes.average().coordinates(placed(nodes, relative, 0.02)),
          .u = nodes.average().coordinates(placed(nodes, {}, 1.0)),
          .w = {0.4, -1.0, 2.0},
          .phi = Vector12::Zero()};
}

// Power of the elastic forces: −dV/dt, V taken by central differences (error h² |V'''|/6).
TEST(Bushing, ForcesAreTheGradientOfItsEnergyAtLargeRotations) {
  for (bool planar : {false, true}) {
    const Cloud nodes = cloud(planar);
    const NodeAverage average = nodes.average();
    scenario::BushingParams params = full_bushing().bushing;
    params.damping.setZero();
    const Bushing spring(params);
    const PortView view = moved_view(nodes);
    const Vector12 phi = -spring.relation(average, view).F;
    const double scale = spring.energy_J(spring.deflection(average, view.q)) / 0.1;
    // Changes of q that nodes can make: those of a planar set leave q in its plane.
    const Eigen::VectorXd y = placed(nodes, {.q_WP = rotation({0.3, 0.8, 1.1})}, 0.3);
    const Vector12 dq = average.coordinates(y);
    const double amount = 1e-5;
    const auto energy = [&](double s) {
      return spring.energy_J(spring.deflection(average, view.q + s * dq));
    };
    EXPECT_NEAR(phi.dot(dq), -(energy(amount) - energy(-amount)) / (2 * amount), 1e-7 * scale);
  }
}

// Damping takes energy at every twist, and the elastic part none of it: φ·q˙ + V˙ = −ν D ν.
TEST(Bushing, DampingNeverGivesEnergy) {
  const Cloud nodes = cloud(false);
  const NodeAverage average = nodes.average();
  scenario::BushingParams params = full_bushing().bushing;
  params.stiffness.setZero();
  const Bushing damper(params);
  PortView view = moved_view(nodes);
  view.w.setZero();
  for (int k = 0; k < 20; ++k) {
    view.u = Vector12::Random();
    EXPECT_LE((-damper.relation(average, view).F).dot(view.u), 0.0);
  }
}

// Central differences over 1e-6 of values up to 1e5 that vary over 0.1: 1e-7 of the largest.
TEST(PortRelation, DerivativesMatchCentralDifferences) {
  for (bool planar : {false, true}) {
    const Cloud nodes = cloud(planar);
    const NodeAverage average = nodes.average();
    const Bushing bushing(full_bushing().bushing);
    for (bool averages : {false, true}) {
      const auto relation = [&](const PortView& view) {
        return averages ? averaging_relation(average, view) : bushing.relation(average, view);
      };
      const PortView view = moved_view(nodes);
      const PortRelation at = relation(view);
      for (int c = 0; c < 12; ++c) {
        if (planar && c >= 3) continue;  // single coordinates leave the plane
        const auto difference = [&](Vector12 PortView::*member) {
          PortView above = view;
          PortView below = view;
          (above.*member)(c) += 1e-6;
          (below.*member)(c) -= 1e-6;
          return Vector12((relation(above).F - relation(below).F) / 2e-6);
        };
        EXPECT_LT((difference(&PortView::q) - at.F_q.col(c)).norm(), 1e-6 * (1 + at.F_q.norm()));
        EXPECT_LT((difference(&PortView::u) - at.F_u.col(c)).norm(), 1e-6 * (1 + at.F_u.norm()));
        EXPECT_LT((difference(&PortView::phi) - at.F_phi.col(c)).norm(), 1e-6);
      }
      for (int c = 0; c < 3; ++c) {
        PortView above = view;
        PortView below = view;
        above.w(c) += 1e-6;
        below.w(c) -= 1e-6;
        EXPECT_LT(((relation(above).F - relation(below).F) / 2e-6 - at.F_w.col(c)).norm(),
                  1e-6 * (1 + at.F_w.norm()));
      }
    }
  }
}

}  // namespace
}  // namespace tandem::fem

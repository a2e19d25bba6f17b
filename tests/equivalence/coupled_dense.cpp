#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

/// The coupled backward Euler step of free rigid bodies and a mesh, all in one dense system:
///   M (v⁺ − v) + h (f_int(x) + h K_R v⁺) = h g              every node; g = 0 off the ports
///   m (V⁺ − V) = −h Σ g_i
///   (I − h [I w]×) w* = I w,  I (w⁺ − w*) = −h Σ (R r_i) × g_i   R, I at the beginning of the step
///   v_i⁺ = V⁺ + w⁺ × (R⁺ r_i),  R⁺ = exp(h w⁺) R                 port nodes
/// in the unknowns (v⁺, V⁺, w⁺, h g). R⁺ is found by repeating the solve. Written from the
/// equations with the mesh's matrices alone: no Schur complement, no ports' Jacobians, no ODE, no
/// scheme.
class DensePair {
 public:
  explicit DensePair(const CoupledPair& pair)
      : model_(pair.fem().model()),
        params_(pair.mbs().params()),
        x(model_.reference()),
        v(model_.initial_velocities()) {
    for (const mbs::BodyParams& body : params_.bodies) {
      bodies.push_back({body.p_WB, body.q_WB, body.v_WB, body.w_WB});
    }
    const Eigen::Index n = x.size();
    M_ = Eigen::MatrixXd::Zero(n, n);
    const fem::BlockPattern& pattern = model_.pattern();
    for (int i = 0; i < pattern.rows(); ++i) {
      for (int b = pattern.row_start[static_cast<std::size_t>(i)];
           b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
        M_.block<3, 3>(3 * i, 3 * pattern.column[static_cast<std::size_t>(b)]).diagonal().array() +=
            model_.mass[static_cast<std::size_t>(b)];
      }
    }
    for (std::size_t p = 0; p < model_.ports.size(); ++p) {
      for (int node : model_.ports[p].nodes) {
        const Eigen::Vector3d r =
            bodies[p].q_WB.conjugate() * (x.segment<3>(3 * node) - bodies[p].p_WB);
        ties_.push_back({node, p, r});
        v.segment<3>(3 * node) = bodies[p].v_WB + bodies[p].w_WB.cross(bodies[p].q_WB * r);
      }
    }
  }

  void step(double h) {
    Eigen::VectorXd right(size());
    Eigen::MatrixXd system = free_system(h, right);
    std::vector<mbs::BodyState> next = bodies;
    Eigen::VectorXd unknown;
    for (int repeat = 0; repeat < 12; ++repeat) {
      tie(next, system);
      const Eigen::PartialPivLU<Eigen::MatrixXd> lu(system);
      unknown = lu.solve(right);
      unknown += lu.solve(right - system * unknown);
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        const Eigen::Index at = x.size() + 6 * static_cast<Eigen::Index>(b);
        next[b].v_WB = unknown.segment<3>(at);
        next[b].w_WB = unknown.segment<3>(at + 3);
        const double angle = h * next[b].w_WB.norm();
        next[b].q_WB = bodies[b].q_WB;
        if (angle > 0.0) {
          next[b].q_WB = Eigen::AngleAxisd(angle, next[b].w_WB.normalized()) * bodies[b].q_WB;
        }
        next[b].p_WB = bodies[b].p_WB + h * next[b].v_WB;
      }
    }
    v = unknown.head(x.size());
    x += h * v;
    bodies = next;
    wrenches.assign(bodies.size(), Wrench{});
    for (std::size_t k = 0; k < ties_.size(); ++k) {
      const Tie& t = ties_[k];
      x.segment<3>(3 * t.node) = bodies[t.body].p_WB + bodies[t.body].q_WB * t.r_B;
      wrenches[t.body].f_P_W -= unknown.segment<3>(multiplier(k)) / h;
    }
  }

  std::vector<mbs::BodyState> bodies;
  WrenchSet wrenches;  ///< forces alone

 private:
  struct Tie {
    int node;
    std::size_t body;
    Eigen::Vector3d r_B;
  };
  const fem::Model& model_;
  const mbs::Params& params_;
  std::vector<Tie> ties_;
  Eigen::MatrixXd M_;

 public:
  Eigen::VectorXd x, v;

 private:
  [[nodiscard]] Eigen::Index multiplier(std::size_t k) const {
    return x.size() + 6 * static_cast<Eigen::Index>(bodies.size()) +
           3 * static_cast<Eigen::Index>(k);
  }
  [[nodiscard]] Eigen::Index size() const { return multiplier(ties_.size()); }

  static Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
  }

  /// Momentum equations of all nodes and bodies, with the multipliers in them.
  Eigen::MatrixXd free_system(double h, Eigen::VectorXd& right) const {
    const Eigen::Index n = x.size();
    Eigen::VectorXd f_int;
    fem::BlockValues values;
    model_.formulation->evaluate(x, f_int, values);
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(size(), size());
    system.topLeftCorner(n, n) = M_;
    const fem::BlockPattern& pattern = model_.pattern();
    for (int i = 0; i < pattern.rows(); ++i) {
      for (int b = pattern.row_start[static_cast<std::size_t>(i)];
           b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
        system.block<3, 3>(3 * i, 3 * pattern.column[static_cast<std::size_t>(b)]) +=
            h * h * fem::block(values, b);
      }
    }
    right.setZero();
    right.head(n) = M_ * v - h * f_int;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Eigen::Index at = n + 6 * static_cast<Eigen::Index>(b);
      const Eigen::Matrix3d R = bodies[b].q_WB.toRotationMatrix();
      const Eigen::Matrix3d I = R * params_.bodies[b].inertia_B() * R.transpose();
      const Eigen::Vector3d L = I * bodies[b].w_WB;
      const Eigen::Vector3d w_free = (I - h * cross_matrix(L)).partialPivLu().solve(L);
      system.block<3, 3>(at, at) = params_.bodies[b].mass_kg * Eigen::Matrix3d::Identity();
      system.block<3, 3>(at + 3, at + 3) = I;
      right.segment<3>(at) = params_.bodies[b].mass_kg * bodies[b].v_WB;
      right.segment<3>(at + 3) = I * w_free;
    }
    for (std::size_t k = 0; k < ties_.size(); ++k) {
      const Tie& t = ties_[k];
      const Eigen::Index at = n + 6 * static_cast<Eigen::Index>(t.body);
      system.block<3, 3>(3 * t.node, multiplier(k)) = -Eigen::Matrix3d::Identity();
      system.block<3, 3>(at, multiplier(k)) = Eigen::Matrix3d::Identity();
      system.block<3, 3>(at + 3, multiplier(k)) = cross_matrix(bodies[t.body].q_WB * t.r_B);
    }
    return system;
  }

  /// Rows of the constraints for the present guess of the poses at the end.
  void tie(const std::vector<mbs::BodyState>& next, Eigen::MatrixXd& system) const {
    for (std::size_t k = 0; k < ties_.size(); ++k) {
      const Tie& t = ties_[k];
      const Eigen::Index at = x.size() + 6 * static_cast<Eigen::Index>(t.body);
      system.block<3, 3>(multiplier(k), 3 * t.node).setIdentity();
      system.block<3, 3>(multiplier(k), at) = -Eigen::Matrix3d::Identity();
      system.block<3, 3>(multiplier(k), at + 3) = cross_matrix(next[t.body].q_WB * t.r_B);
    }
  }
};

// Both solve the same equations in double precision. The step matrix is M + h² K: its eigenvalues
// lie between the smallest nodal mass, 1e-4 kg, and h² K, 1e-6 s² × 1e6 N/m = 1 kg, plus 2 kg
// bodies, so its condition is about 1e4 and 1e4 ε = 2e-12 bounds the round-off of velocities of
// 1 m/s; the vibration's damping keeps it from adding up. A force of ΔV m / h shows it times m / h.
TEST(MonolithicStep, EqualsTheDenseSystemOfAllUnknowns) {
  const double h = 1e-3;
  CoupledPair pair("two_masses/scenario.yaml", {{"run.duration_s", "0.025"}});
  DensePair dense(pair);
  int steps = 0;
  double velocity_gap = 0.0, twist_gap = 0.0, pose_gap = 0.0, force_gap = 0.0;
  const RunReport report = pair.run(orchestrator::Mode::Monolithic, [&](const Sample& sample) {
    if (sample.applied.empty()) return;
    dense.step(h);
    ++steps;
    velocity_gap =
        std::max(velocity_gap, (dense.v - pair.fem().nodal_state().v).lpNorm<Eigen::Infinity>());
    for (std::size_t b = 0; b < 2; ++b) {
      const mbs::BodyState& expected = dense.bodies[b];
      const mbs::BodyState& body = pair.mbs().state().bodies[b];
      twist_gap = std::max(
          {twist_gap, (expected.v_WB - body.v_WB).norm(), (expected.w_WB - body.w_WB).norm()});
      pose_gap = std::max(
          {pose_gap, (expected.p_WB - body.p_WB).norm(), expected.q_WB.angularDistance(body.q_WB)});
      force_gap = std::max(force_gap, (dense.wrenches[b].f_P_W - sample.wrenches[b].f_P_W).norm());
    }
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_EQ(steps, 25);
  EXPECT_LT(velocity_gap, 2e-12);
  EXPECT_LT(twist_gap, 2e-12);
  EXPECT_LT(pose_gap, 1e-13);
  EXPECT_LT(force_gap, 2.0 * 2e-12 / h);
}

}  // namespace
}  // namespace tandem::coupled_test

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "fem_process/sides/flexible_body.h"
#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// The two masses at rest but for the stretching: v(X) = (2 X_x, 0, 0), bodies at ±0.5 m/s.
CoupledPair stretched_pair(double h_s, double duration_s,
                           const std::string& integrator = "backward_euler",
                           const std::string& formulation = "corotational") {
  return CoupledPair("two_masses/scenario.yaml",
                     {{"fem.integrator.kind", integrator},
                      {"fem.formulation", formulation},
                      {"run.duration_s", text_of(duration_s)},
                      {"run.macro_step_s", text_of(h_s)},
                      {"mbs.bodies.left.velocity_m_per_s", "[-0.5, 0, 0]"},
                      {"mbs.bodies.left.angular_velocity_rad_per_s", "[0, 0, 0]"},
                      {"mbs.bodies.right.velocity_m_per_s", "[0.5, 0, 0]"},
                      {"mbs.bodies.right.angular_velocity_rad_per_s", "[0, 0, 0]"},
                      {"fem.initial_velocity.angular_rad_per_s", "[0, 0, 0]"}});
}

/// Frequency (Hz) of the mode of the assembled system that stretches the pair most: stiffness and
/// mass of the mesh with its port nodes tied to the rigid bodies, u_i = u_B + θ_B × r_i.
double assembled_frequency_Hz(const CoupledPair& pair) {
  const fem::Model& model = pair.fem().model();
  const auto free = static_cast<Eigen::Index>(3 * model.free.size());
  const Eigen::Index n = 3 * model.mesh.nodes();
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n, free + 12);
  for (std::size_t k = 0; k < model.free.size(); ++k) {
    T.block<3, 3>(3 * model.free[k], 3 * static_cast<Eigen::Index>(k)).setIdentity();
  }
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(free + 12, free + 12);
  for (Eigen::Index p = 0; p < 2; ++p) {
    const mbs::BodyParams& body = pair.mbs().params().bodies[static_cast<std::size_t>(p)];
    for (int node : model.ports[static_cast<std::size_t>(p)].nodes) {
      const Eigen::Vector3d r = model.mesh.X[static_cast<std::size_t>(node)] - body.p_WB;
      T.block<3, 3>(3 * node, free + 6 * p).setIdentity();
      for (int axis = 0; axis < 3; ++axis) {
        T.block<3, 1>(3 * node, free + 6 * p + 3 + axis) = Eigen::Vector3d::Unit(axis).cross(r);
      }
    }
    mass.block<3, 3>(free + 6 * p, free + 6 * p) = body.mass_kg * Eigen::Matrix3d::Identity();
    mass.block<3, 3>(free + 6 * p + 3, free + 6 * p + 3) = body.inertia_B();
  }
  Eigen::VectorXd f_int;
  fem::BlockValues values;
  model.formulation->evaluate(model.reference(), f_int, values);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n);
  const fem::BlockPattern& pattern = model.pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (int b = pattern.row_start[row]; b < pattern.row_start[row + 1]; ++b) {
      const int j = pattern.column[static_cast<std::size_t>(b)];
      K.block<3, 3>(3 * i, 3 * j) = fem::block(values, b);
      M.block<3, 3>(3 * i, 3 * j).diagonal().array() = model.mass[static_cast<std::size_t>(b)];
    }
  }
  mass += T.transpose() * M * T;
  Eigen::MatrixXd stiffness = T.transpose() * K * T;
  stiffness = (0.5 * (stiffness + stiffness.transpose())).eval();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(stiffness, mass);
  // The first mode whose two bodies move mostly along x and against each other.
  for (Eigen::Index k = 6; k < modes.eigenvalues().size(); ++k) {
    const auto shape = modes.eigenvectors().col(k);
    const double stretch = shape(free + 6) - shape(free);
    if (std::abs(stretch) > 0.5) return std::sqrt(modes.eigenvalues()(k)) / kTurn;
  }
  return 0.0;
}

/// Frequency (Hz) of the relative velocity from its first and last zero crossing.
double simulated_frequency_Hz(CoupledPair& pair) {
  std::vector<double> crossings_s;
  double last_t = 0.0, last_v = 0.0;
  const RunReport report = pair.run(orchestrator::Mode::Monolithic, [&](const Sample& sample) {
    const double v = sample.motions[1].v_WP.x() - sample.motions[0].v_WP.x();
    if (sample.t_s > 0.0 && v * last_v < 0.0) {
      crossings_s.push_back(last_t + (sample.t_s - last_t) * last_v / (last_v - v));
    }
    last_t = sample.t_s;
    last_v = v;
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  EXPECT_GE(crossings_s.size(), 15U);
  return 0.5 * static_cast<double>(crossings_s.size() - 1) /
         (crossings_s.back() - crossings_s.front());
}

/// Lowest antisymmetric frequency (Hz) of an elastic rod of mass m between two rigid masses M:
///   β tan β = m / (2 M),  ω = 2 β c / L,  c² = E / ρ
/// (half a rod clamped in the middle with M at its end) [S. S. Rao, Mechanical Vibrations, 5th ed.,
/// section 8.3].
double rod_between_masses_Hz(double mass_ratio, double wave_speed, double length) {
  double low = 0.0, high = 0.5 * std::numbers::pi - 1e-9;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (middle * std::tan(middle) < 0.5 * mass_ratio ? low : high) = middle;
  }
  return 2.0 * low * wave_speed / length / kTurn;
}

// Backward Euler lowers a frequency by the part (ω h)²/3: 8e-5 at 24 Hz and h = 1e-4 s.
TEST(TwoMassesVibration, HasTheFrequencyOfTheAssembledEigenproblem) {
  CoupledPair pair = stretched_pair(1e-4, 0.4);
  const double assembled_Hz = assembled_frequency_Hz(pair);
  // The first axial frequency as the reference's own assembly has it, to its printed digits.
  EXPECT_NEAR(assembled_Hz, 24.060887, 1e-5);
  const double simulated_Hz = simulated_frequency_Hz(pair);
  EXPECT_NEAR(simulated_Hz, assembled_Hz, 1e-3 * assembled_Hz);
  // The bar is no rod: its ends cannot contract sideways, which stiffens it by 0.5 %; 3 % is the
  // project's bound.
  const double rod_Hz =
      rod_between_masses_Hz(0.5 * 0.05 * 0.05 * 1000.0 / 2.0, std::sqrt(5e6 / 1000.0), 0.5);
  EXPECT_NEAR(simulated_Hz, rod_Hz, 0.03 * rod_Hz);
}

// A bar without inertia between two masses is a spring: ω² = k (1/m₁ + 1/m₂), k the stiffness that
// the bar has against a small stretch. The step of the coupled pair, velocities from the force at
// its end, is backward Euler's: the frequency is arctan(ω h)/(2π h). What is left is the
// interpolation of the crossings, (ω h)²/24 of a step each.
TEST(TwoMassesVibration, OfAQuasiStaticBarIsThatOfASpring) {
  const double h_s = 1e-3;
  CoupledPair pair = stretched_pair(h_s, 0.4, "quasi_static", "linear");
  fem::FlexibleBody bar(pair.fem().model().params);
  MotionSet rest(2);
  for (std::size_t p = 0; p < 2; ++p) rest[p].p_WP = pair.mbs().params().bodies[p].p_WB;
  bar.initialize(rest);
  MotionSet stretched = rest;
  stretched[1].p_WP.x() += 1e-4;
  const auto result = bar.advance({.step = sim_time_from_seconds(h_s), .input = {rest, stretched}});
  ASSERT_EQ(result.outcome, Outcome::Done) << result.message;
  const double k = -result.output[1].f_P_W.x() / 1e-4;
  // Ends that cannot contract sideways stiffen the bar by a few percent.
  EXPECT_NEAR(k, 5e6 * 0.05 * 0.05 / 0.5, 0.05 * k);
  const double inverse_mass =
      1.0 / pair.mbs().params().bodies[0].mass_kg + 1.0 / pair.mbs().params().bodies[1].mass_kg;
  const double spring_Hz = std::atan(std::sqrt(k * inverse_mass) * h_s) / (kTurn * h_s);
  EXPECT_NEAR(simulated_frequency_Hz(pair), spring_Hz, 1e-3 * spring_Hz);
}

}  // namespace
}  // namespace tandem::coupled_test

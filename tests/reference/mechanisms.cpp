#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/support/columns.h"
#include "tests/support/tandem_process.h"

// The examples with several flexible bodies against closed forms and a published figure.
namespace tandem::test {
namespace {

constexpr double kGravity = 9.81;

/// Runs an example in one process to `duration_s`, which it has to reach.
Columns columns_of(const std::string& example, double duration_s, const std::string& table,
                   const std::vector<std::string>& more = {}) {
  const TemporaryFolder folder("tandem_mechanisms");
  std::vector<std::string> arguments{"--transport", "inproc", "--set",
                                     "run.duration_s=" + std::to_string(duration_s)};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Ended ended = run_command(run_of(example, folder / "run", arguments), {}, 400.0);
  EXPECT_EQ(ended.code, 0) << ended.output;
  return read_columns(folder / "run" / table);
}

// --- robot_arm ---------------------------------------------------------------------------------

struct SquareBar {
  double length_m, side_m;
  static constexpr double kYoung_Pa = 7e10, kDensity_kg_per_m3 = 2700;
  [[nodiscard]] double mass_kg() const { return kDensity_kg_per_m3 * side_m * side_m * length_m; }
  /// Deflection (m) and slope of the end of a cantilever under force and moment at its end and its
  /// own weight; Euler and Bernoulli.
  [[nodiscard]] std::array<double, 2> bent(double force_N, double moment_Nm) const {
    const double EI = kYoung_Pa * std::pow(side_m, 4) / 12;
    const double l = length_m;
    const double q = mass_kg() * kGravity / l;
    return {(force_N * l * l * l / 3 + moment_Nm * l * l / 2 + q * l * l * l * l / 8) / EI,
            (force_N * l * l / 2 + moment_Nm * l + q * l * l * l / 6) / EI};
  }
};

// Half a second after the motors have stopped the arm hangs still, stretched along y: 2 kg at the
// end, 0.5 kg at the elbow.
TEST(RobotArm, HangsAsTwoCantileversInARow) {
  const SquareBar upper{.length_m = 0.5, .side_m = 0.02};
  const SquareBar fore{.length_m = 0.4, .side_m = 0.016};
  const double payload_kg = 2.0, elbow_kg = 0.5;
  const double force_N = (payload_kg + elbow_kg + fore.mass_kg()) * kGravity;
  const double moment_Nm = (payload_kg + fore.mass_kg() / 2) * kGravity * fore.length_m;
  const auto [elbow_m, slope] = upper.bent(force_N, moment_Nm);
  const double wrist_m = elbow_m + slope * fore.length_m + fore.bent(payload_kg * kGravity, 0)[0];

  auto ports = columns_of("robot_arm", 2.6, "ports.csv");
  ASSERT_FALSE(ports["t_s"].empty());
  ASSERT_NEAR(ports["t_s"].back(), 2.6, 1e-9);
  // Bonded end faces cannot contract across: 1.2 % stiffer over some thickness at each end (with
  // attachment: averaging the same bars hang 0.6 % lower than the formula).
  EXPECT_NEAR(-ports["elbow.p_z_m"].back(), elbow_m, 0.015 * elbow_m);
  EXPECT_NEAR(-ports["wrist.p_z_m"].back(), wrist_m, 0.015 * wrist_m);
  // A quarter of a turn: the rates' pieces add up to π/2 within 1e-6, and both hang in the plane.
  EXPECT_NEAR(ports["wrist.p_x_m"].back(), 0.0, 2e-5);
  // The length that hanging takes, about (slope)²/2 of it.
  EXPECT_NEAR(ports["wrist.p_y_m"].back(), 0.9, 1e-4);

  // Equilibrium of the whole arm. What is left of the vibration, e^(−ζ ω t) with ζ = ω β/2 = 0.08
  // and ω = 40 rad/s, is 0.3 per mille of the weight.
  const double weight_N = force_N + upper.mass_kg() * kGravity;
  EXPECT_NEAR(ports["shoulder.f_z_N"].back(), -weight_N, 1e-3 * weight_N);
  const double torque_Nm = moment_Nm + (force_N + upper.mass_kg() * kGravity / 2) * upper.length_m;
  EXPECT_NEAR(ports["shoulder.t_x_Nm"].back(), -torque_Nm, 1e-3 * torque_Nm);
}

// --- four_bar ----------------------------------------------------------------------------------

// Rigid bars could not move. C at 2.4 s, 0.1 rad before crank and coupler are in line, by a program
// of geometrically exact beams, 8 elements a bar (github.com/vspsonn/mb_sef_py,
// examples/beam_fourbar). Beams have no extent at their ends, bars of 16 mm have: a few per mille
// of their stiffness, and so of z. So near the dead centre x and y change by what z, the stretch of
// the bars and the steps do to the rocker's slant: 5 and 17 µm are seen.
// Damping takes the energy of strain rates, not of a turn whose steps go along chords: the links
// turn by 3 rad/s, and ω² h/2 of their length would be a strain rate that damps 400 times as much.
TEST(RobotArm, LosesToDampingWhatItsVibrationHas) {
  const std::string every = "output.energy_every_steps=1";
  const auto lost_J = [&](const std::vector<std::string>& more) {
    return columns_of("robot_arm", 1.2, "energy.csv", more)["fem.damping_loss_J"].back();
  };
  const double second_order_J = lost_J({"--set", every});
  const double first_order_J = lost_J({"--set", every, "--set", "mbs.integrator=euler", "--set",
                                       "fem.upper_arm.integrator={kind: backward_euler}", "--set",
                                       "fem.forearm.integrator={kind: backward_euler}"});
  EXPECT_GT(second_order_J, 0.01);
  EXPECT_NEAR(first_order_J / second_order_J, 1.0, 0.7);
}

TEST(FourBar, TheMisalignedHingeIsBentAside) {
  auto ports = columns_of("four_bar", 2.4, "ports.csv");
  ASSERT_FALSE(ports["t_s"].empty());
  ASSERT_NEAR(ports["t_s"].back(), 2.4, 1e-9);
  EXPECT_NEAR(ports["bc_c.p_x_m"].back(), 0.358947, 2e-5);
  EXPECT_NEAR(ports["bc_c.p_y_m"].back(), 0.015141, 5e-5);
  EXPECT_NEAR(ports["bc_c.p_z_m"].back(), -3.743e-3, 0.005 * 3.743e-3);
  // The hinge has not come apart.
  EXPECT_NEAR(ports["cd_c.p_z_m"].back(), ports["bc_c.p_z_m"].back(), 1e-6);
}

// --- double_wishbone ---------------------------------------------------------------------------

constexpr double kRoad_Hz = 2.5;

/// Mean and amplitude of the last whole period: three coefficients of Fourier, exact sums for
/// equally spaced samples of a whole period.
struct Wave {
  double mean, amplitude;
};
Wave last_wave(const std::vector<double>& t_s, const std::vector<double>& value) {
  Wave wave{0.0, 0.0};
  std::complex<double> sum = 0.0;
  int samples = 0;
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    if (t_s[i] < t_s.back() - 1 / kRoad_Hz + 1e-9) continue;
    wave.mean += value[i];
    sum += value[i] * std::polar(1.0, -2 * std::numbers::pi * kRoad_Hz * t_s[i]);
    ++samples;
  }
  wave.mean /= samples;
  wave.amplitude = 2 * std::abs(sum) / samples;
  return wave;
}

struct Corner {
  double chassis_m, wheel_m;
};

/// Amplitudes of chassis and wheel on the road a sin ω t by the model of two masses: parallel arms
/// of the length l, the coil at half of it. A uniform arm (mass m) adds m/3 to both and m/6 between
/// them; its bushings turn by the stroke over l; each leg of the lower arm is a beam on two
/// supports that the coil bends, k = 48 E I/s³, and a quarter of the coil's force acts on each
/// bushing below.
Corner two_mass_model() {
  const double l = 0.35, s = std::hypot(0.15, l);
  const double I = 0.03 * std::pow(0.02, 3) / 12;
  const double arms_kg = 2 * 7850 * 2 * s * 0.03 * 0.02;
  const double chassis_kg = 300, wheel_kg = 20 + 5 + 2 * 0.3;
  const std::complex<double> iw(0.0, 2 * std::numbers::pi * kRoad_Hz);
  const double arm = 1 / (1 / (2 * 48 * 2.1e11 * I / (s * s * s)) + 1 / (4 * 2 * 2e6));
  const auto coil = 1.0 / (1.0 / (1.2e5 + iw * 6000.0) + 1.0 / arm);
  const auto stroke = coil / 4.0 + 4 * 30.0 / (l * l);
  const auto tyre = 2e5 + iw * 100.0;
  const auto A11 = iw * iw * (chassis_kg + arms_kg / 3) + stroke;
  const auto A12 = iw * iw * arms_kg / 6.0 - stroke;
  const auto A22 = iw * iw * (wheel_kg + arms_kg / 3) + stroke + tyre;
  const auto road = tyre * 0.01 / (A11 * A22 - A12 * A12);
  return {std::abs(A12 * road), std::abs(A11 * road)};
}

// The first-order error of the step is taken out by two steps, 2 a(H/2) − a(H); it is 2.4 % of the
// wheel's at 5 ms. What is left: legs clamped to each other at the ball joint are 20 % stiffer than
// on two supports, which is 0.3 % of the chassis' amplitude, and the start, some 10 mm that
// swing at another frequency and fade by e^(−2.5 t), 0.2 %.
TEST(DoubleWishbone, FollowsTheTwoMassModel) {
  std::array<Corner, 2> at{};
  for (const int half : {0, 1}) {
    auto bodies =
        columns_of("double_wishbone", 3.2, "bodies.csv",
                   {"--set", std::string("run.macro_step_s=") + (half == 0 ? "0.005" : "0.0025")});
    ASSERT_FALSE(bodies["t_s"].empty());
    // Both steps fit into a period, and the run is eight of them.
    ASSERT_NEAR(bodies["t_s"].back(), 3.2, 1e-9);
    const Wave wheel = last_wave(bodies["t_s"], bodies["wheel.p_z_m"]);
    at[static_cast<std::size_t>(half)] = {
        last_wave(bodies["t_s"], bodies["chassis.p_z_m"]).amplitude, wheel.amplitude};
    // The tyre carries the whole weight at its compression at the start: 2 N of 3265 N.
    EXPECT_NEAR(wheel.mean, 0.125, 1e-5);
  }
  const Corner expected = two_mass_model();
  EXPECT_NEAR(2 * at[1].chassis_m - at[0].chassis_m, expected.chassis_m, 0.01 * expected.chassis_m);
  EXPECT_NEAR(2 * at[1].wheel_m - at[0].wheel_m, expected.wheel_m, 0.005 * expected.wheel_m);
}

}  // namespace
}  // namespace tandem::test

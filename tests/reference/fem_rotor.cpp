// Flapping of a turning blade: its frequency rises with the speed as Southwell's formula and the
// tables of the uniform rotating cantilever say.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

constexpr int kCubes = 12;  // a blade of 12 m, 1 m thick, about its clamped end
constexpr double kYoung_Pa = 1e9;
constexpr double kDensity = 1000.0;
const Eigen::Vector3d kRoot(0.0, 0.5, 0.5);

/// √(E I/(ρ A L⁴)), the unit of angular frequencies in the tables (rad/s).
double unit_rad_per_s() {
  return std::sqrt(kYoung_Pa / (12.0 * kDensity)) / (double{kCubes} * kCubes);
}

/// The angular frequency of the small vibration of the tip across the plane of turning, from its
/// zero crossings over twelve half periods (rad/s).
double flapping_rad_per_s(double rate_rad_per_s, double guess_rad_per_s) {
  static const std::filesystem::path file = temporary_file("blade.inp", box_inp(kCubes));
  Params params;
  params.mesh.file = file;
  params.mesh.order = 2;
  params.integrator = {.kind = IntegratorKind::GeneralisedAlpha, .rho_infinity = 0.8};
  params.material = {.young_Pa = kYoung_Pa, .poisson = 0.0, .density_kg_per_m3 = kDensity};
  params.ports = {{"hub", {"LEFT"}, kRoot}};
  // The blade starts without tension: what it then does along its length has to be over, at 130
  // rad/s within some 0.2 s. Flapping at 7 to 15 rad/s is hardly damped.
  params.damping.beta_s = 2e-3;
  // Turning, and a first push across: the clamped cross-section does not follow it.
  params.initial_velocity = {.angular_rad_per_s = {0.0, -0.02, rate_rad_per_s}, .about_m = kRoot};
  const double h = 2.0 * M_PI / guess_rad_per_s / 200.0;
  params.micro_step = sim_time_from_seconds(h);
  FlexibleBody body(params);
  const double step_s = to_seconds(params.micro_step);
  const auto hub = [&](double t) {
    const Eigen::Vector3d w(0.0, 0.0, rate_rad_per_s);
    return MotionSet{{.p_WP = kRoot, .q_WP = rotation(w * t), .w_WP = w}};
  };
  body.initialize(hub(0.0));
  const std::vector<int>& tip = find_set(body.model().mesh, {"RIGHT"}).nodes;
  const auto height = [&] {
    double sum = 0.0;
    for (int node : tip) sum += body.state().x(3 * node + 2) - kRoot.z();
    return sum / static_cast<double>(tip.size());
  };
  std::vector<double> crossings;
  double before = height();
  for (int k = 1; crossings.size() < 13 && k < 4000; ++k) {
    const auto result =
        body.advance(request(hub((k - 1) * step_s), hub(k * step_s), params.micro_step));
    EXPECT_EQ(result.outcome, Outcome::Done) << result.message;
    const double now = height();
    if (before * now < 0.0 && k > 200)
      crossings.push_back((k - 1 + before / (before - now)) * step_s);
    before = now;
  }
  if (crossings.size() < 13) return 0.0;
  return 12.0 * M_PI / (crossings.back() - crossings.front());
}

// First flapping frequency of the uniform blade without hub radius, in units of √(E I/(ρ A L⁴)), at
// speeds of 0 … 6 units [Wright, Smith, Thresher and Wang, J. Appl. Mech. 49 (1982), table 1]. The
// blade's own frequency at rest is lower than the thin beam's by its shear and rotary inertia at
// L/t = 12, and higher by its mesh; what turning adds to its square is of the load alone:
// Southwell's ω² = ω_0² + S Ω². Within 2 %: shear and rotary inertia change S, too.
TEST(FemRotor, FlapsFasterAsTheTablesOfRotatingBeamsSay) {
  const std::vector<std::pair<double, double>> table = {
      {2.0, 4.1373}, {4.0, 5.5850}, {6.0, 7.3604}};
  constexpr double kAtRest = 3.5160;
  const double unit = unit_rad_per_s();
  const double at_rest = flapping_rad_per_s(0.0, kAtRest * unit) / unit;
  EXPECT_NEAR(at_rest, kAtRest, 0.03 * kAtRest);
  for (const auto& [speed, listed] : table) {
    const double found = flapping_rad_per_s(speed * unit, listed * unit) / unit;
    const double southwell = (listed * listed - kAtRest * kAtRest) / (speed * speed);
    EXPECT_NEAR((found * found - at_rest * at_rest) / (speed * speed), southwell, 0.02 * southwell)
        << speed << ": " << found << " for " << listed;
  }
}

}  // namespace
}  // namespace tandem::fem

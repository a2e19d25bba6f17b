// The second-order step, coupled: mbs.integrator verlet with the trapezoidal flexible side.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/support/truth_case.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

CoupledPair::Overrides second_order(const std::string& beta) {
  return {{"mbs.integrator", "verlet"},
          {"mbs.newmark_beta", beta},
          {"fem.integrator.kind", "hht"},
          {"fem.integrator.hht_alpha", "0"}};
}

// Against the RK4 trajectory of the uncut system, two-sided over the first 0.1 s. Wrenches carry
// waves that no step here resolves, so they are not asked.
TEST(SecondOrder, PortMotionsOfTwoMassesConvergeToTheReferenceWithOrderTwo) {
  const Trajectory reference = reference_of(two_masses());
  const auto errors_of = [&](const std::string& beta, double h_s) {
    TruthCase truth = two_masses();
    for (const scenario::Override& o : second_order(beta)) truth.overrides.push_back(o);
    return largest_errors(truth, monolithic_trajectory(truth, h_s), reference);
  };
  std::map<std::string, double> coarser;
  for (double h_s : {5e-4, 2.5e-4, 1.25e-4, 6.25e-5}) {
    const auto errors = errors_of("0.25", h_s);
    for (const char* quantity : {"left_pos", "right_pos", "distance"}) {
      const double error = errors.at(quantity);
      if (coarser.contains(quantity)) {
        EXPECT_NEAR(std::log2(coarser.at(quantity) / error), 2.0, 0.15)
            << quantity << " at " << h_s << " s";
      }
      coarser[quantity] = error;
      // With the masses' error of fourth order the bar's is left: it has less than a quarter of
      // the mass.
      if (h_s == 2.5e-4) {
        EXPECT_LT(errors_of("0.0833333333333333", h_s).at(quantity), 0.3 * error) << quantity;
      }
    }
  }
}

/// c of d(t) ≈ offset + Re(c e^{iωt}), by least squares over rows with t in [from_s, to_s].
std::complex<double> vibration_of(const std::vector<double>& t, const std::vector<double>& d,
                                  double omega, double from_s, double to_s) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (t[i] >= from_s && t[i] <= to_s) rows.push_back(i);
  }
  Eigen::MatrixXd A(static_cast<Eigen::Index>(rows.size()), 3);
  Eigen::VectorXd b(A.rows());
  for (Eigen::Index k = 0; k < A.rows(); ++k) {
    const double time = t[rows[static_cast<std::size_t>(k)]];
    A.row(k) << 1.0, std::cos(omega * time), -std::sin(omega * time);
    b[k] = d[rows[static_cast<std::size_t>(k)]];
  }
  const Eigen::Vector3d fit = A.colPivHouseholderQr().solve(b);
  return {fit[1], fit[2]};
}

// The axial vibration of 24.06 Hz, of which a first-order step leaves nothing after a second,
// fitted over the last 0.1 s at H = 1e-3 s: amplitude within 2 %, phase within 5°, in every scheme
// that converges.
TEST(SecondOrder, TwoMassesKeepTheirVibrationForASecond) {
  const Trajectory reference = read_trajectory(std::filesystem::path(TANDEM_SOURCE_DIR) /
                                               "tests/data/coupled" / "two_masses_distance.csv");
  std::vector<double> t, d;
  for (const std::vector<double>& row : reference.rows) t.push_back(row[0]), d.push_back(row[1]);
  const double omega = 2.0 * std::numbers::pi * 24.060887;
  const std::complex<double> expected = vibration_of(t, d, omega, 0.9, 1.0);
  ASSERT_GT(std::abs(expected), 1e-3);
  for (const char* scheme : {"interface_jacobian", "implicit"}) {
    CoupledPair::Overrides overrides = second_order("0.0833333333333333");
    overrides.push_back({"coupling.scheme", scheme});
    overrides.push_back({"coupling.relaxation", "iqn_ils"});
    CoupledPair pair("two_masses/scenario.yaml", overrides);
    std::vector<double> t_run, d_run;
    const RunReport report = pair.run(Mode::Inproc, [&](const Sample& s) {
      t_run.push_back(s.t_s);
      d_run.push_back((s.motions[1].p_WP - s.motions[0].p_WP).norm());
    });
    ASSERT_EQ(report.status, RunStatus::Done) << report.message;
    const std::complex<double> ratio = vibration_of(t_run, d_run, omega, 0.9, 1.0) / expected;
    EXPECT_NEAR(std::abs(ratio), 1.0, 0.02) << scheme;
    EXPECT_LT(std::abs(std::arg(ratio)), 5.0 * std::numbers::pi / 180.0) << scheme;
  }
}

}  // namespace
}  // namespace tandem::coupled_test

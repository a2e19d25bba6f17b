// Order in H of every scheme and of every ratio of micro steps: port motions of two_masses against
// the RK4 trajectory of the uncut system. Forces and angular velocities carry kHz waves of the
// sudden start that no step here resolves, so they are not asked.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/truth_case.h"

namespace tandem::coupled_test {
namespace {

struct OrderCase {
  std::string name;
  CoupledPair::Overrides overrides;
  int mbs_micro_steps = 1;
  int fem_micro_steps = 1;
  int order = 1;
  double longest_step_s = 5e-4;
  int halvings = 4;
  double end_s = 0.02;
  /// Lines of a fixed impedance Z = k H, whose mass Z H and compliance H/Z vanish with the step.
  double line_impedance_Ns_per_m = 0.0;
  std::vector<std::string> quantities = {"left_pos", "right_pos", "left_vel", "distance"};
};

double to_nanoseconds(double seconds) { return std::round(seconds * 1e9) * 1e-9; }

std::map<std::string, double> errors_of(const OrderCase& c, double H_s,
                                        const Trajectory& reference) {
  TruthCase truth = two_masses();
  truth.overrides = {{"run.duration_s", text_of(c.end_s)},
                     {"mbs.micro_step_s", text_of(to_nanoseconds(H_s / c.mbs_micro_steps))},
                     {"fem.micro_step_s", text_of(to_nanoseconds(H_s / c.fem_micro_steps))}};
  truth.overrides.insert(truth.overrides.end(), c.overrides.begin(), c.overrides.end());
  if (c.line_impedance_Ns_per_m > 0.0) {
    truth.overrides.push_back(
        {"coupling.tlm.stiffness_N_per_m", text_of(c.line_impedance_Ns_per_m / H_s)});
  }
  return largest_errors(truth, trajectory(truth, H_s, orchestrator::Mode::Inproc, reference),
                        reference);
}

class CoupledOrder : public testing::TestWithParam<OrderCase> {};

TEST_P(CoupledOrder, IsThatOfTheIntegrators) {
  const OrderCase& c = GetParam();
  const Trajectory reference = beginning_of(reference_of(two_masses()), c.end_s);
  std::map<std::string, double> coarser;
  for (int halving = 0; halving <= c.halvings; ++halving) {
    const double H_s = c.longest_step_s / (1 << halving);
    const auto errors = errors_of(c, H_s, reference);
    for (const std::string& quantity : c.quantities) {
      if (halving > 0) {
        EXPECT_NEAR(std::log2(coarser[quantity] / errors.at(quantity)), c.order, 0.15)
            << quantity << ", H = " << H_s << " s, error " << errors.at(quantity);
      }
      coarser[quantity] = errors.at(quantity);
    }
  }
}

const CoupledPair::Overrides kWaveform = {{"coupling.scheme", "implicit"},
                                          {"coupling.relaxation", "iqn_ils"}};

CoupledPair::Overrides second_order() {
  CoupledPair::Overrides overrides = kWaveform;
  overrides.insert(overrides.end(), {{"mbs.integrator", "verlet"},
                                     {"mbs.newmark_beta", "0.25"},
                                     {"fem.integrator.kind", "hht"},
                                     {"fem.integrator.hht_alpha", "0"}});
  return overrides;
}

const OrderCase kCases[] = {
    {.name = "explicit_serial_hold",
     .overrides = {{"coupling.scheme", "explicit_serial"}, {"coupling.prediction", "hold"}}},
    {.name = "explicit_serial_linear", .overrides = {{"coupling.scheme", "explicit_serial"}}},
    {.name = "explicit_serial_quadratic",
     .overrides = {{"coupling.scheme", "explicit_serial"}, {"coupling.prediction", "quadratic"}}},
    {.name = "explicit_serial_with_retained_inertia",
     .overrides = {{"coupling.scheme", "explicit_serial"},
                   {"coupling.retained_inertia.factor", "1"}}},
    {.name = "explicit_parallel_linear", .overrides = {{"coupling.scheme", "explicit_parallel"}}},
    {.name = "explicit_parallel_quadratic",
     .overrides = {{"coupling.scheme", "explicit_parallel"},
                   {"coupling.prediction", "quadratic"},
                   {"coupling.motion_prediction", "quadratic"}}},
    {.name = "implicit_aitken", .overrides = {{"coupling.scheme", "implicit"}}},
    {.name = "implicit_iqn_ils", .overrides = kWaveform},
    {.name = "implicit_parallel_iqn_imvj",
     .overrides = {{"coupling.scheme", "implicit"},
                   {"coupling.iteration", "parallel"},
                   {"coupling.relaxation", "iqn_imvj"}}},
    {.name = "interface_jacobian", .overrides = {}},
    {.name = "tlm", .overrides = {{"coupling.scheme", "tlm"}}, .line_impedance_Ns_per_m = 100.0},
    {.name = "mbs_4_fem_1", .overrides = {}, .mbs_micro_steps = 4, .longest_step_s = 1e-3},
    {.name = "mbs_1_fem_4", .overrides = kWaveform, .fem_micro_steps = 4, .longest_step_s = 1e-3},
    {.name = "mbs_2_fem_5",
     .overrides = kWaveform,
     .mbs_micro_steps = 2,
     .fem_micro_steps = 5,
     .longest_step_s = 1e-3},
    {.name = "explicit_mbs_2_fem_5",
     .overrides = {{"coupling.scheme", "explicit_serial"}, {"coupling.prediction", "hold"}},
     .mbs_micro_steps = 2,
     .fem_micro_steps = 5,
     .longest_step_s = 1e-3},
    {.name = "second_order_mbs_4_fem_1",
     .overrides = second_order(),
     .mbs_micro_steps = 4,
     .order = 2,
     .halvings = 3,
     .end_s = 0.1,
     .quantities = {"left_pos", "right_pos", "distance"}},
};

INSTANTIATE_TEST_SUITE_P(TwoMasses, CoupledOrder, testing::ValuesIn(kCases),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tandem::coupled_test

// Flexible bodies that meet without a rigid one: at massless junctions, and at joints between two.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/coupled_pair.h"

namespace tandem::coupled_test {
namespace {

using orchestrator::Mode;

const std::string kJunctions = "../tests/data/coupled/systems/junctions.yaml";
const std::string kFreeJunctions = "../tests/data/coupled/systems/free_junctions.yaml";

const CoupledPair::Overrides kFirstOrder = {};
const CoupledPair::Overrides kSecondOrder = {{"mbs.integrator", "verlet"},
                                             {"fem.spar.integrator.kind", "hht"},
                                             {"fem.spar.integrator.hht_alpha", "0"},
                                             {"fem.strut.integrator.kind", "hht"},
                                             {"fem.strut.integrator.hht_alpha", "0"}};
const CoupledPair::Overrides kDamped = {{"mbs.integrator", "generalised_alpha"},
                                        {"fem.spar.integrator.kind", "generalised_alpha"},
                                        {"fem.strut.integrator.kind", "generalised_alpha"}};

CoupledPair::Overrides with(CoupledPair::Overrides a, const CoupledPair::Overrides& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<Sample> samples_of(const std::string& scenario, Mode mode,
                               const CoupledPair::Overrides& overrides) {
  CoupledPair pair(scenario, overrides);
  std::vector<Sample> samples;
  const RunReport report = pair.run(mode, [&](const Sample& sample) { samples.push_back(sample); });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  return samples;
}

void expect_same(const std::vector<Sample>& a, const std::vector<Sample>& b, double tolerance,
                 const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  const RelativeDifference difference = largest_relative_difference(a, b, Scale::AnyPort);
  EXPECT_LT(difference.motions, tolerance) << what;
  EXPECT_LT(difference.wrenches, tolerance) << what;
}

/// As for bodies with mass: the project's bound.
constexpr double kAgree = 1e-9;

class Junctions : public testing::TestWithParam<int> {
 protected:
  static const CoupledPair::Overrides& integrators() {
    static const CoupledPair::Overrides all[] = {kFirstOrder, kSecondOrder, kDamped};
    return all[GetParam()];
  }
};

TEST_P(Junctions, EqualTheMonolithicStepInEverySchemeThatIterates) {
  const std::vector<Sample> monolithic = samples_of(kJunctions, Mode::Monolithic, integrators());
  const std::vector<CoupledPair::Overrides> schemes = {{{"coupling.scheme", "interface_jacobian"}},
                                                       {{"coupling.scheme", "implicit"},
                                                        {"coupling.max_iterations", "100"},
                                                        {"coupling.relaxation", "iqn_imvj"}}};
  for (const CoupledPair::Overrides& scheme : schemes) {
    expect_same(monolithic, samples_of(kJunctions, Mode::Inproc, with(integrators(), scheme)),
                kAgree, scheme.front().value);
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, Junctions, testing::Values(0, 1, 2));

CoupledPair::Overrides standing_in(double mass_kg) {
  CoupledPair::Overrides overrides;
  for (const char* name : {"foot", "heel", "hub"}) {
    const std::string junction = std::string("mbs.junctions.") + name;
    overrides.push_back({junction + ".stand_in_mass_kg", text_of(mass_kg)});
    overrides.push_back({junction + ".stand_in_inertia_kg_m2", text_of(0.01 * mass_kg)});
  }
  return overrides;
}

// What stands in while a step is made is nowhere in the result: 100 g, a ton or ten.
TEST(StandInInertia, IsNowhereInTheResultOfTheFirstOrderPair) {
  const std::vector<Sample> ton = samples_of(kJunctions, Mode::Inproc, kFirstOrder);
  for (const double mass_kg : {0.1, 1e4}) {
    expect_same(ton, samples_of(kJunctions, Mode::Inproc, with(kFirstOrder, standing_in(mass_kg))),
                kAgree, text_of(mass_kg));
  }
}

/// Largest distance (m) of the ports' origins in two runs.
double distance_m(const std::vector<Sample>& a, const std::vector<Sample>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0.0;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n) {
    for (std::size_t p = 0; p < a[n].motions.size(); ++p) {
      largest = std::max(largest, (a[n].motions[p].p_WP - b[n].motions[p].p_WP).norm());
    }
  }
  return largest;
}

// The halves of a second-order step see springs and joints in two places: what that does to a
// junction is of the step's own order.
TEST(StandInInertia, IsInTheResultOfSecondOrderByTheOrderOfTheStep) {
  for (const auto& integrators : {kSecondOrder, kDamped}) {
    const auto between = [&](double H_s) {
      const auto steps = with(integrators, {{"run.macro_step_s", text_of(H_s)}});
      return distance_m(samples_of(kJunctions, Mode::Inproc, with(steps, standing_in(0.5))),
                        samples_of(kJunctions, Mode::Inproc, with(steps, standing_in(2.0))));
    };
    const double coarse_m = between(1e-4), fine_m = between(0.5e-4);
    EXPECT_NEAR(std::log2(coarse_m / fine_m), 2.0, 0.3) << coarse_m;
    // The bodies are 0.2 m long.
    EXPECT_LT(coarse_m, 1e-5);
  }
}

/// What the two ports at one place exert together.
Wrench sum_of(const Sample& sample, std::size_t one, std::size_t other) {
  const Wrench &a = sample.wrenches[one], &b = sample.wrenches[other];
  return {.f_P_W = a.f_P_W + b.f_P_W, .t_P_W = a.t_P_W + b.t_P_W};
}

/// Largest |Σ f| and |Σ t| of two ports from step `first` on, by the largest |f| and |t|.
void expect_balance(const std::vector<Sample>& samples, std::size_t one, std::size_t other,
                    std::size_t first, double tolerance) {
  double f = 0.0, t = 0.0, largest_f = 0.0, largest_t = 0.0;
  for (std::size_t n = first; n < samples.size(); ++n) {
    const Wrench sum = sum_of(samples[n], one, other);
    f = std::max(f, sum.f_P_W.norm());
    t = std::max(t, sum.t_P_W.norm());
    const Wrench& a = samples[n].wrenches[one];
    largest_f = std::max(largest_f, a.f_P_W.norm());
    largest_t = std::max(largest_t, a.t_P_W.norm());
  }
  EXPECT_GT(largest_f, 1.0) << "N";
  EXPECT_LT(f, tolerance * largest_f);
  EXPECT_LT(t, tolerance * largest_t);
}

CoupledPair::Overrides of_free_chain(const std::string& mbs, const std::string& fem) {
  CoupledPair::Overrides all = {{"mbs.integrator", mbs}};
  for (const char* body : {"first", "second", "third"}) {
    all.push_back({std::string("fem.") + body + ".integrator.kind", fem});
  }
  return all;
}

// Ports at one place, nothing else: action and reaction. The residual is 1e-11 of the wrench.
TEST(FreeJunctions, BalanceTheWrenchesOfTheirPorts) {
  const std::vector<Sample> first =
      samples_of(kFreeJunctions, Mode::Inproc, of_free_chain("euler", "backward_euler"));
  const std::vector<Sample> second =
      samples_of(kFreeJunctions, Mode::Inproc, of_free_chain("verlet", "generalised_alpha"));
  const std::vector<Sample> damped = samples_of(
      kFreeJunctions, Mode::Inproc, of_free_chain("generalised_alpha", "generalised_alpha"));
  for (const std::size_t port : {1U, 3U}) {
    expect_balance(first, port, port + 1, 1, 1e-9);
    // Half, or 0.8, of what is out of balance at t = 0 is kept from step to step.
    expect_balance(second, port, port + 1, 40, 1e-9);
    expect_balance(damped, port, port + 1, 80, std::pow(0.8, 70));
  }
}

TEST(FreeJunctions, KeepTheMomentumOfTheWhole) {
  CoupledPair pair(kFreeJunctions, {});
  Eigen::Vector3d linear, angular;
  double drift = 0.0, turn = 0.0;
  bool first = true;
  const RunReport report = pair.run(Mode::Inproc, [&](const Sample&) {
    if (first) {
      linear = pair.linear_momentum();
      angular = pair.angular_momentum();
    }
    first = false;
    drift = std::max(drift, (pair.linear_momentum() - linear).norm());
    turn = std::max(turn, (pair.angular_momentum() - angular).norm());
  });
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  // Some 20 kg that move with 1 m/s.
  EXPECT_LT(drift, 1e-9 * 20.0);
  // The moments of a step of semi-implicit Euler are those of its beginning: of first order.
  EXPECT_LT(turn, 2e-2 * angular.norm());
}

// Energy that goes through a junction stays: what the flexible sides give to it they get back, up
// to what the coupling leaves; no energy is booked for the inertia that stands in.
TEST(FreeJunctions, HoldNoEnergy) {
  for (const auto& overrides :
       {of_free_chain("euler", "backward_euler"), of_free_chain("verlet", "generalised_alpha")}) {
    CoupledPair pair(kFreeJunctions, overrides);
    const RunReport report = pair.run(Mode::Inproc, [](const Sample&) {});
    ASSERT_EQ(report.status, RunStatus::Done) << report.message;
    const EnergyBook &begin = report.energy_start.mbs, &end = report.energy_end.mbs;
    const double moves_J = report.energy_start.sum().kinetic_J;
    // The two balls: what they hold came over the interface but for what the steps lose.
    EXPECT_NEAR(end.kinetic_J - begin.kinetic_J, end.interface_work_J - end.numerical_loss_J,
                1e-9 * moves_J);
    EXPECT_NEAR(report.energy_end.mbs.interface_work_J, -report.energy_end.fem.interface_work_J,
                1e-6 * moves_J);
  }
}

// A body of mass m in the junction's place is off by what is proportional to m.
TEST(FreeJunctions, AreTheLimitOfLightBodies) {
  const std::vector<Sample> massless = samples_of(kFreeJunctions, Mode::Inproc, {});
  double heavier_m = 0.0;
  for (const double mass_kg : {0.4, 0.2, 0.1, 0.05}) {
    const double inertia = 0.01 * mass_kg;
    const auto body = [&](const std::string& name, const std::string& at, const std::string& v) {
      const std::string I = text_of(inertia);
      return "{name: " + name + ", mass_kg: " + text_of(mass_kg) + ", inertia_kg_m2: [" + I + ", " +
             I + ", " + I + "], position_m: " + at + ", velocity_m_per_s: " + v +
             ", angular_velocity_rad_per_s: [2, 1, 3]}";
    };
    const std::string ends =
        "{name: a, mass_kg: 2, inertia_kg_m2: [0.01, 0.01, 0.01], position_m: [-0.475, 0, 0], "
        "velocity_m_per_s: [0, -1.425, 0.475], angular_velocity_rad_per_s: [2, 1, 3]}, "
        "{name: d, mass_kg: 3, inertia_kg_m2: [0.02, 0.02, 0.02], position_m: [0.475, 0, 0], "
        "velocity_m_per_s: [0, 1.425, -0.475], angular_velocity_rad_per_s: [2, 1, 3]}";
    const std::vector<Sample> light = samples_of(
        "../tests/data/coupled/systems/free_chain.yaml", Mode::Inproc,
        {{"mbs.bodies", "[" + ends + ", " + body("b", "[-0.125, 0, 0]", "[0, -0.375, 0.125]") +
                            ", " + body("c", "[0.125, 0, 0]", "[0, 0.375, -0.125]") + "]"},
         {"run.duration_s", "0.1"}});
    ASSERT_EQ(light.size(), massless.size());
    const double off_m = distance_m(massless, light);
    if (heavier_m > 0.0) {
      EXPECT_NEAR(heavier_m / off_m, 2.0, 0.3) << mass_kg;
    }
    heavier_m = off_m;
  }
  EXPECT_LT(heavier_m, 1e-2);
}

}  // namespace
}  // namespace tandem::coupled_test

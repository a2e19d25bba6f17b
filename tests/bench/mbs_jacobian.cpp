// Prints, for docs/coupling.md, what the multibody side's Jacobian costs on hinged chains,
// by the step's own response and by probing, against one step. CPU times; no test.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "protocol/driver/process_memory.h"
#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

/// `bodies` links of 0.1 m on hinges about y, hung from the world, with ports spread over them.
Params chain(std::size_t bodies, std::size_t ports) {
  Params params = params_with_step(kMillisecond);
  params.gravity_m_per_s2 = {0.0, 0.0, -9.81};
  params.cfm = 1e-10;
  for (std::size_t i = 0; i < bodies; ++i) {
    const double x = 0.1 * static_cast<double>(i);
    params.bodies.push_back(
        body_at(numbered("b", i), 0.1, {x + 0.05, 0.0, 0.0}, {1e-4, 1e-4, 1e-4}));
    params.joints.push_back(joint_between(numbered("j", i), JointKind::Hinge, numbered("b", i),
                                          i == 0 ? kWorld : numbered("b", i - 1), {x, 0.0, 0.0},
                                          Eigen::Vector3d::UnitY()));
  }
  for (std::size_t i = 0; i < ports; ++i) {
    params.ports.push_back(port_on(numbered("p", i), numbered("b", i * bodies / ports)));
  }
  return params;
}

/// Median CPU time (s), the system's included, of advances from the accepted state.
double advance_s(RigidWorld& world, bool linearize, RigidWorld::Linearization how) {
  const WrenchSet wrenches(world.params().ports.size());
  auto request = step_of(kMillisecond, wrenches, wrenches);
  request.linearize = linearize;
  world.linearize_by(how);
  std::vector<double> times;
  double total = 0.0;
  while (times.empty() || (times.size() < 101 && total < 0.3)) {
    world.rollback();
    const std::clock_t started = std::clock();
    const auto result = world.advance(request);
    times.push_back(static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC);
    total += times.back();
    if (result.outcome != Outcome::Done) throw Error(ErrorKind::NotSolved, result.message);
  }
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2),
                   times.end());
  return times[times.size() / 2];
}

void print_row(std::size_t bodies, std::size_t ports) {
  RigidWorld world(chain(bodies, ports));
  world.initialize(WrenchSet(ports));
  run(world, kMillisecond, 5, WrenchSet(ports));
  world.checkpoint();
  const double step_s = advance_s(world, false, RigidWorld::Linearization::Response);
  const double response_s = advance_s(world, true, RigidWorld::Linearization::Response) - step_s;
  const int probed = world.probed_columns();
  const double probing_s = advance_s(world, true, RigidWorld::Linearization::Probing) - step_s;
  fmt::print("| {} | {} | {:.3g} | {:.3g} | {:.3g} | {:.3g} |{}\n", bodies, ports, 1e3 * step_s,
             1e3 * probing_s, 1e3 * response_s, probing_s / response_s,
             probed > 0 ? fmt::format(" {} columns probed!", probed) : "");
  std::fflush(stdout);
}

}  // namespace
}  // namespace tandem::mbs::testing

int main() {
  tandem::keep_freed_memory();  // as tandem and tandem-mbs do
  fmt::print("| bodies | ports | step (ms) | B by probing (ms) | B by response (ms) | ratio |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  for (const std::size_t bodies : {5U, 10U, 20U, 50U, 100U, 200U}) {
    for (const std::size_t ports : {1U, 5U, 20U, 40U}) {
      if (ports <= bodies) tandem::mbs::testing::print_row(bodies, ports);
    }
  }
  return 0;
}

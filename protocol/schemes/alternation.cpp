#include "protocol/schemes/alternation.h"

#include <fmt/format.h>

namespace tandem {
namespace {

constexpr double kMemory = 1.0 / 16.0;
/// Smooth wrenches have next to nothing, independent ones 0.6.
constexpr double kMuch = 0.3;

}  // namespace

void Alternation::add(const InterfaceState& state) {
  if (state.history.size() < 2) return;
  const Eigen::VectorXd now = stack(state.wrenches);
  const Eigen::VectorXd before = stack(state.history[0].wrenches);
  const Eigen::VectorXd first = stack(state.history[1].wrenches);
  const auto norm_N = [&](const Eigen::VectorXd& stacked) {
    return wrench_norm_N(unstack_wrenches(stacked), ports_);
  };
  const double size_N = norm_N(now) + 2.0 * norm_N(before) + norm_N(first);
  const double part = size_N > 0.0 ? norm_N(now - 2.0 * before + first) / size_N : 0.0;
  part_ += kMemory * (part - part_);
}

std::string Alternation::remark() const {
  if (!(part_ > kMuch)) return {};
  return fmt::format(
      " The port wrenches have alternated from step to step ({:.2g} of their size over the last 16 "
      "steps): stiff parts that the step does not resolve are not damped. With integrators of "
      "second order set mbs.integrator and fem.integrator.kind to generalised_alpha, rho_infinity "
      "0.8, on both sides, or shorten run.macro_step_s.",
      part_);
}

}  // namespace tandem

#include "protocol/schemes/prediction.h"

#include <algorithm>
#include <array>

namespace tandem {
namespace {

/// Weights of the values at t_n, t_{n−1}, t_{n−2} in the extrapolating polynomial's value at
/// t_n + H, and in its mean over [t_n, t_n + H].
struct Weights {
  std::array<double, 3> end{1.0, 0.0, 0.0};
  std::array<double, 3> mean{1.0, 0.0, 0.0};
};

Weights weights_of(Prediction prediction, const InterfaceState& state, SimTime H) {
  Weights weights;
  const std::size_t degree =
      std::min<std::size_t>(static_cast<std::size_t>(prediction), state.history.size());
  if (degree == 0) return weights;
  // In units of H: the step before is a long, the one before that b.
  const auto ratio = [H](SimTime step) {
    return static_cast<double>(step.count()) / static_cast<double>(H.count());
  };
  const double a = ratio(state.time - state.history[0].time);
  // Newton's form, y(s) = y0 + s d1 + s (s + a) d2 at s = 1, and its mean over s in [0, 1].
  weights.end = {1.0 + 1.0 / a, -1.0 / a, 0.0};
  weights.mean = {1.0 + 0.5 / a, -0.5 / a, 0.0};
  if (degree == 1) return weights;
  const double b = ratio(state.history[0].time - state.history[1].time);
  const std::array<double, 3> d2{1.0 / (a * (a + b)), -1.0 / (a * b), 1.0 / (b * (a + b))};
  for (std::size_t i = 0; i < 3; ++i) {
    weights.end[i] += (1.0 + a) * d2[i];
    weights.mean[i] += (1.0 / 3.0 + 0.5 * a) * d2[i];
  }
  return weights;
}

}  // namespace

Eigen::VectorXd twists(const MotionSet& motions) {
  Eigen::VectorXd stacked(6 * static_cast<Eigen::Index>(motions.size()));
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const auto row = 6 * static_cast<Eigen::Index>(i);
    stacked.segment<3>(row) = motions[i].v_WP;
    stacked.segment<3>(row + 3) = motions[i].w_WP;
  }
  return stacked;
}

namespace {

Eigen::VectorXd combine(const std::array<double, 3>& weights,
                        const std::vector<Eigen::VectorXd>& values) {
  Eigen::VectorXd sum = weights[0] * values[0];
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (weights[i] != 0.0) sum += weights[i] * values[i];
  }
  return sum;
}

}  // namespace

Eigen::VectorXd extrapolate(Prediction prediction, const InterfaceState& state, SimTime H,
                            const std::vector<Eigen::VectorXd>& values) {
  return combine(weights_of(prediction, state, H).end, values);
}

WrenchSet predict_wrenches(Prediction prediction, const InterfaceState& state, SimTime H) {
  std::vector<Eigen::VectorXd> values{stack(state.wrenches)};
  for (const InterfaceSample& sample : state.history) values.push_back(stack(sample.wrenches));
  return unstack_wrenches(extrapolate(prediction, state, H, values));
}

MotionSet predict_motions(Prediction prediction, const InterfaceState& state, SimTime H) {
  const Weights weights = weights_of(prediction, state, H);
  std::vector<Eigen::VectorXd> values{twists(state.motions)};
  for (const InterfaceSample& sample : state.history) values.push_back(twists(sample.motions));
  const Eigen::VectorXd path = to_seconds(H) * combine(weights.mean, values);
  const Eigen::VectorXd change = combine(weights.end, values) - values[0];
  Eigen::VectorXd xi(2 * path.size());
  for (Eigen::Index i = 0; 6 * i < path.size(); ++i) {
    xi.segment<6>(12 * i) = path.segment<6>(6 * i);
    xi.segment<6>(12 * i + 6) = change.segment<6>(6 * i);
  }
  return displaced(state.motions, xi);
}

}  // namespace tandem

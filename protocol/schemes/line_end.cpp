#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/contract/hash.h"
#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/residual_floor.h"
#include "protocol/schemes/transmission_line.h"

namespace tandem {
namespace {

constexpr double kTolerance = 1e-12;
constexpr std::int32_t kMostEvaluations = 30;
constexpr std::int32_t kPatience = 4;

/// ∂Λ/∂V⁺ where the poses follow the velocities: columns of twists plus H times those of poses.
Eigen::MatrixXd by_twist(const InterfaceJacobian& fem, double H_s) {
  Eigen::MatrixXd columns(fem.rows(), fem.cols() / 2);
  for (Eigen::Index i = 0; 12 * i < fem.cols(); ++i) {
    columns.middleCols<6>(6 * i) = fem.middleCols<6>(12 * i + 6) + H_s * fem.middleCols<6>(12 * i);
  }
  return columns;
}

}  // namespace

LineEnd::LineEnd(std::unique_ptr<FemSide> inner, double stiffness_N_per_m)
    : inner_(std::move(inner)), info_(inner_->info()), stiffness_N_per_m_(stiffness_N_per_m) {
  require(info_.can_linearize,
          "coupling.scheme: tlm needs the interface Jacobian of the fem side, which has none. Use "
          "implicit or explicit_serial.");
  info_.can_linearize = false;  // the line hides how the side answers
}

WrenchSet LineEnd::initialize(const MotionSet& motions) {
  WrenchSet wrenches = inner_->initialize(motions);
  state_ = {.motions = motions, .lambda2 = stack(wrenches)};
  saved_ = state_;
  return wrenches;
}

StepResult<WrenchSet> LineEnd::advance(const StepRequest<MotionSet>& request) {
  const double start_s = now_s();
  const State begin = state_;
  const Eigen::VectorXd Z = line_impedance(stiffness_N_per_m_, request.step, info_.ports);
  if (state_.Z.size() == 0) {
    state_.Z = Z;
    state_.a1_next = state_.lambda2 + state_.Z.cwiseProduct(twists(state_.motions));
    state_.a1 = state_.a1_next;
  }
  // λ1 = a1 − Z V1 arrived with V1; what leaves end 1 is λ1 − Z V1, with the Z of that step.
  const Eigen::VectorXd a2 = state_.a1 - 2.0 * state_.Z.cwiseProduct(twists(request.input.begin));
  state_.Z = Z;
  MotionSet motions;
  StepResult<WrenchSet> result = solve(request, a2, motions);
  if (result.outcome == Outcome::Failed) {
    state_ = begin;
  } else {
    state_.motions = std::move(motions);
    state_.lambda2 = stack(result.output);
    state_.a1 = std::exchange(state_.a1_next, 2.0 * state_.lambda2 - a2);
  }
  result.jacobian.reset();
  result.cost.compute_s = now_s() - start_s;
  return result;
}

MotionSet LineEnd::moved(const MotionSet& from, const Eigen::VectorXd& V, double H_s) const {
  Eigen::VectorXd xi(2 * V.size());
  const Eigen::VectorXd change = V - twists(from);
  for (Eigen::Index i = 0; 6 * i < V.size(); ++i) {
    xi.segment<6>(12 * i) = H_s * V.segment<6>(6 * i);
    xi.segment<6>(12 * i + 6) = change.segment<6>(6 * i);
  }
  return displaced(from, xi);
}

StepResult<WrenchSet> LineEnd::solve(const StepRequest<MotionSet>& request,
                                     const Eigen::VectorXd& a2, MotionSet& motions) {
  const double H_s = to_seconds(request.step);
  const Eigen::VectorXd& Z = state_.Z;
  Eigen::VectorXd V = twists(state_.motions);
  bool linearize = state_.block.begin_step(request.step);
  MotionSet last_motions;
  Eigen::VectorXd last_lambda;
  const auto norm_N = [this](const Eigen::VectorXd& x) {
    return wrench_norm_N(unstack_wrenches(x), info_.ports);
  };
  ResidualFloor floor(kPatience, 0.0);
  floor.begin_step(norm_N(state_.lambda2));
  for (std::int32_t k = 1;; ++k) {
    if (k > 1) inner_->rollback();
    motions = moved(state_.motions, V, H_s);
    StepResult<WrenchSet> result = inner_->advance(
        {.step = request.step, .input = {state_.motions, motions}, .linearize = linearize});
    if (result.outcome == Outcome::Failed) return result;
    const Eigen::VectorXd lambda = stack(result.output);
    if (k > 1) (void)state_.block.learn(difference(last_motions, motions), lambda - last_lambda);
    if (linearize) state_.block.take(result.jacobian.value());
    const Eigen::VectorXd damped = Z.cwiseProduct(V);
    const Eigen::VectorXd residual = lambda - a2 - damped;
    const double scale_N = std::max({norm_N(a2), norm_N(damped), norm_N(lambda)});
    const double round_off_N = wrench_round_off_N(motions, state_.block.value(), info_.ports);
    const bool at_floor = floor.reached(norm_N(residual), scale_N, round_off_N);
    if (norm_N(residual) <= kTolerance * scale_N + round_off_N || at_floor) return result;
    if (k == kMostEvaluations) {
      result.outcome = Outcome::NotConverged;
      result.message = fmt::format(
          "fem: the line's end leaves {:.3g} N after {} evaluations. Lower run.macro_step_s.",
          norm_N(residual), k);
      return result;
    }
    Eigen::MatrixXd matrix = by_twist(state_.block.value(), H_s);
    matrix.diagonal() -= Z;
    last_lambda = lambda;
    last_motions = motions;
    V -= matrix.partialPivLu().solve(residual);
    linearize = k % kPatience == 0;
  }
}

void LineEnd::checkpoint() {
  inner_->checkpoint();
  saved_ = state_;
}

void LineEnd::rollback() {
  inner_->rollback();
  state_ = saved_;
}

Observation LineEnd::observe() {
  Observation seen = inner_->observe();
  StateHash hash;
  hash.add(seen.state_hash);
  for (const Eigen::VectorXd& x :
       {Eigen::VectorXd(difference(MotionSet(state_.motions.size()), state_.motions)),
        state_.lambda2, state_.Z, state_.a1, state_.a1_next}) {
    hash.add(std::span<const double>(x.data(), static_cast<std::size_t>(x.size())));
  }
  seen.state_hash = hash.value();
  return seen;
}

std::unique_ptr<FemSide> prepared_for(const CouplingParams& params, std::unique_ptr<FemSide> side) {
  if (params.scheme != SchemeKind::Tlm) return side;
  return std::make_unique<LineEnd>(std::move(side), params.tlm.stiffness_N_per_m);
}

}  // namespace tandem

#include "protocol/schemes/retained_inertia.h"

#include <utility>

#include "protocol/schemes/evaluation.h"

namespace tandem {
namespace {

/// diag(R, R | …): turns twists and wrenches from the axes of the ports to those of W.
Eigen::MatrixXd rotations(const MotionSet& motions) {
  const auto n = 6 * static_cast<Eigen::Index>(motions.size());
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const auto row = 6 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix3d R_WP = motions[i].q_WP.toRotationMatrix();
    R.block<3, 3>(row, row) = R_WP;
    R.block<3, 3>(row + 3, row + 3) = R_WP;
  }
  return R;
}

}  // namespace

MacroStepEnd RetainedInertia::advance(SimTime H, const InterfaceState& state,
                                      const WrenchSet& predicted, const MotionSet* motions,
                                      MbsSide& mbs, FemSide& fem) {
  std::int32_t evaluations = 1;
  if (begin_step(H, state)) {
    const Evaluation trial = evaluate(H, state, predicted, {.fem = true}, mbs, fem, ports_);
    if (trial.outcome == Outcome::Failed) return end_of(trial, predicted, evaluations);
    take(trial.fem_jacobian, H, state.motions);
    roll_back(mbs, fem);
    ++evaluations;
  }
  const Equation wrench = equation(state, H, predicted);
  if (motions != nullptr) fem.begin_advance({.step = H, .input = {state.motions, *motions}});
  const ImpedanceEnd rigid =
      rigid_side_.advance(H, state.wrenches, wrench.a, wrench.Z, predicted, mbs);
  StepResult<WrenchSet> flexible;
  if (motions != nullptr) {
    flexible = fem.finish_advance();
    book(H, *motions);
  } else if (rigid.result.outcome == Outcome::Failed) {
    return {.outcome = Outcome::Failed, .message = rigid.result.message, .iterations = evaluations};
  } else {
    flexible = fem.advance({.step = H, .input = {state.motions, rigid.result.output}});
    book(H, rigid.result.output);
  }
  return end_of(joined(rigid.result, flexible, rigid.applied, ports_), rigid.applied, evaluations);
}

bool RetainedInertia::begin_step(SimTime H, const InterfaceState& state) {
  if (!begun_) {
    booked_ = {.given = twists(state.motions),
               .accelerations = {Eigen::VectorXd::Zero(twists(state.motions).size())}};
  } else if (state.time > *begun_ && pending_) {
    booked_ = *pending_;
    ++age_;
  }
  pending_.reset();
  begun_ = state.time;
  const bool other_step = std::exchange(step_, H) != H;
  return other_step || (params_.retained_inertia.refresh_steps > 0 &&
                        age_ >= params_.retained_inertia.refresh_steps);
}

void RetainedInertia::take(const InterfaceJacobian& fem, SimTime H, const MotionSet& motions) {
  const double H_s = to_seconds(H);
  Eigen::MatrixXd inertia(fem.rows(), fem.cols() / 2);
  for (Eigen::Index i = 0; 12 * i < fem.cols(); ++i) {
    inertia.middleCols<6>(6 * i) =
        -H_s * (fem.middleCols<6>(12 * i + 6) + H_s * fem.middleCols<6>(12 * i));
  }
  const Eigen::MatrixXd R = rotations(motions);
  inertia_P_ = R.transpose() * inertia * R;
  age_ = 0;
}

RetainedInertia::Equation RetainedInertia::equation(const InterfaceState& state, SimTime H,
                                                    const WrenchSet& predicted) const {
  const Eigen::MatrixXd R = rotations(state.motions);
  const Eigen::MatrixXd inertia =
      params_.retained_inertia.factor * (R * inertia_P_ * R.transpose());
  const double H_s = to_seconds(H);
  const Eigen::VectorXd booked = extrapolate(params_.prediction, state, H, booked_.accelerations);
  return {.a = stack(predicted) + inertia * (booked + twists(state.motions) / H_s),
          .Z = inertia / H_s};
}

void RetainedInertia::book(SimTime H, const MotionSet& given) {
  pending_ = booked_;
  pending_->given = twists(given);
  pending_->accelerations.insert(pending_->accelerations.begin(),
                                 (pending_->given - booked_.given) / to_seconds(H));
  if (pending_->accelerations.size() > InterfaceState::kHistory + 1) {
    pending_->accelerations.pop_back();
  }
}

}  // namespace tandem

#include "fem_process/ancf/beam_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tandem::fem::ancf {
namespace {

/// An iteration that contracts less than this calls for a new matrix.
constexpr double kContraction = 0.3;

/// So many iterations with matrices of their own that do not even halve the change go round.
constexpr double kRound = 0.5;
constexpr int kMostRounds = 3;

/// Of a damped correction.
constexpr double kShortest = 1.0 / 64.0;

std::uint64_t fingerprint(const BeamState& state, double h_s) {
  StateHash hash;
  hash.add(h_s);
  hash.add(std::span<const double>(state.q.data(), static_cast<std::size_t>(state.q.size())));
  hash.add(std::span<const double>(state.v.data(), static_cast<std::size_t>(state.v.size())));
  return hash.value();
}

}  // namespace

BeamStep::BeamStep(const BeamSystem& system, const ContactModel& contact, const StepParams& params,
                   const Attachments* attachments)
    : system_(system), contact_(contact), attachments_(attachments), params_(params) {}

BeamStep::Alpha BeamStep::alpha(double h_s) const {
  const double rho = params_.rho_inf;
  Alpha a{.am = (2.0 * rho - 1.0) / (rho + 1.0), .af = rho / (rho + 1.0), .h = h_s};
  a.gamma = 0.5 + a.af - a.am;
  a.beta = 0.25 * (a.gamma + 0.5) * (a.gamma + 0.5);
  return a;
}

bool BeamStep::imbalance(const BeamState& state, const MotionSet& motions, double t_s,
                         double damping, std::optional<double> theta, ElementArrays& elements,
                         ContactSums& sums, Eigen::VectorXd& r) const {
  const int inverted = theta ? system_.kernel().tangents(state.q, state.v, *theta, elements)
                             : system_.kernel().forces(state.q, state.v, elements);
  if (inverted > 0) return false;
  contact_.add(state.q, state.v, motions, params_.friction, theta, elements, sums);
  r = system_.mass_times(damping == 0.0 ? state.a : Eigen::VectorXd(state.a + damping * state.v));
  system_.add_forces(elements, r);
  r = system_.external_forces(t_s) - r;
  return true;
}

bool BeamStep::residual(const BeamState& state, const MotionSet& motions, double t_s,
                        double damping, std::optional<double> theta, ElementArrays& elements,
                        ContactSums& sums, Eigen::VectorXd& r) const {
  if (!imbalance(state, motions, t_s, damping, theta, elements, sums, r)) return false;
  system_.clear_fixed(r);
  return true;
}

bool BeamStep::balance(const MotionSet& motions, BeamState& state, ContactSums& sums) const {
  ElementArrays elements = system_.element_arrays();
  state.a.setZero(state.q.size());
  Eigen::VectorXd r;
  if (!residual(state, motions, to_seconds(state.time), params_.mass_damping_per_s, std::nullopt,
                elements, sums, r)) {
    return false;
  }
  std::fill(elements.tangent.begin(), elements.tangent.end(), 0.0);
  std::vector<double> values;
  system_.assemble(elements, 1.0, values);
  const auto factor = system_.solver().factorize(values);
  if (!factor) return false;
  factor->solve(r);
  state.a = r;
  state.A = r;
  return note_forces(motions, state, sums);
}

bool BeamStep::factorize(const Alpha& alpha, const ElementArrays& elements, Result& result) const {
  BeamState& state = result.state;
  std::vector<double> values;
  system_.assemble(elements, alpha.mass() + alpha.rate() * params_.mass_damping_per_s, values);
  ++result.factorisations;
  auto factor = system_.solver().factorize(values);
  if (!factor) return false;
  state.matrix = std::make_shared<const StepMatrix>(
      StepMatrix{std::move(factor), alpha.h, params_.mass_damping_per_s, params_.friction,
                 fingerprint(state, alpha.h)});
  return true;
}

void BeamStep::correct(const Alpha& alpha, const Eigen::VectorXd& d, BeamState& state) {
  state.q += d;
  state.v += alpha.rate() * d;
  const Eigen::VectorXd of_A = d / alpha.position();
  state.A += of_A;
  state.a += (1.0 - alpha.am) / (1.0 - alpha.af) * of_A;
}

BeamStep::Try BeamStep::newton(const Alpha& alpha, const MotionSet& motions, double t_s,
                               Result& result) const {
  BeamState& state = result.state;
  // Kept between calls: its memory is larger than the arithmetic's.
  static thread_local ElementArrays elements;
  if (elements.force.size() != system_.mesh().elements.size() * kCoordinates) {
    elements = system_.element_arrays();
  }
  const bool usable = state.matrix && state.matrix->h_s == alpha.h &&
                      state.matrix->friction == params_.friction &&
                      state.matrix->mass_damping_per_s == params_.mass_damping_per_s;
  if (!usable) state.matrix.reset();
  double before = std::numeric_limits<double>::infinity();
  int rounds = 0;
  Eigen::VectorXd r;
  for (int k = 0; k < params_.newton_steps; ++k) {
    ++result.iterations;
    const bool fresh = !state.matrix;
    const std::optional<double> theta = fresh ? std::optional<double>(alpha.rate()) : std::nullopt;
    if (!residual(state, motions, t_s, params_.mass_damping_per_s, theta, elements, result.sums,
                  r)) {
      return {End::Inverted};
    }
    if (fresh && !factorize(alpha, elements, result)) return {End::Singular};
    state.matrix->factor->solve(r);
    const double change = r.cwiseAbs().maxCoeff();
    if (!std::isfinite(change)) return {End::Singular};
    correct(alpha, r, state);
    if (change < params_.tolerance_m) return {End::Converged, change};
    if (fresh && change > kRound * before && ++rounds == kMostRounds) {
      return damped_newton(alpha, motions, t_s, params_.newton_steps - k, elements, result);
    }
    if (change > kContraction * before) state.matrix.reset();
    before = change;
  }
  return {End::Stalled, before};
}

BeamStep::Try BeamStep::damped_newton(const Alpha& alpha, const MotionSet& motions, double t_s,
                                      int most, ElementArrays& elements, Result& result) const {
  BeamState& state = result.state;
  const auto balance_of = [&](const BeamState& at, std::optional<double> theta,
                              Eigen::VectorXd& r) {
    ++result.iterations;
    return residual(at, motions, t_s, params_.mass_damping_per_s, theta, elements, result.sums, r);
  };
  Eigen::VectorXd d, next;
  double change = 0.0;
  for (int k = 0; k < most; ++k) {
    if (!balance_of(state, alpha.rate(), d)) return {End::Inverted};
    if (!factorize(alpha, elements, result)) return {End::Singular};
    state.matrix->factor->solve(d);
    change = d.cwiseAbs().maxCoeff();
    if (!std::isfinite(change)) return {End::Singular};
    const BeamState begin = state;
    for (double part = 1.0; part >= kShortest; part *= 0.5) {
      state = begin;
      correct(alpha, part * d, state);
      if (change < params_.tolerance_m) return {End::Converged, change};
      if (!balance_of(state, std::nullopt, next)) continue;
      state.matrix->factor->solve(next);
      if (next.norm() <= (1.0 - 0.5 * part) * d.norm()) break;
    }
  }
  return {End::Stalled, change};
}

void BeamStep::cut(const BeamState& begin, const Segment<MotionSet>& input, double s0, double s1,
                   SimTime h, int depth, Result& result) const {
  const double length_s = (s1 - s0) * to_seconds(h);
  const Alpha coefficients = alpha(length_s);
  const MotionSet motions = interpolate(input, s1, h);
  const double t_s = to_seconds(begin.time) + length_s;
  BeamState& state = result.state;
  state = begin;
  // Guess: the algorithmic acceleration stays.
  state.q += length_s * begin.v + (0.5 * length_s * length_s) * begin.A;
  state.v += length_s * begin.A;
  state.a = (begin.A - coefficients.af * begin.a) / (1.0 - coefficients.af);
  if (attachments_ != nullptr) {
    attachments_->advance(motions, length_s, begin.v, begin.A, state.q, state.v, state.a, state.A);
  }
  const Try end = newton(coefficients, motions, t_s, result);
  if (end.end == End::Converged) {
    state.time = begin.time + SimTime(std::llround(length_s * 1e9));
    // The wrenches belong to the state as it is after the last correction.
    if (!note_forces(motions, state, result.sums)) {
      result.outcome = Outcome::Failed;
      result.message = "an element is turned inside out (det F ≤ 0). Shorten run.macro_step_s.";
      return;
    }
    book(begin, length_s, state);
    return;
  }
  if (depth == params_.halvings) {
    result.outcome = Outcome::Failed;
    const char* what = end.end == End::Inverted   ? "an element is turned inside out (det F ≤ 0)"
                       : end.end == End::Singular ? "the step matrix is singular or not finite"
                                                  : "Newton's iteration stalled";
    result.message = fmt::format(
        "{} in a step of {:.3g} s, the {}-th part of the step (last change {:.3g} m, limit {:.3g} "
        "m). Shorten run.macro_step_s or fem.micro_step_s; check that no wheel reaches far into "
        "the "
        "band, and let a strained chain settle first (fem.ancf.settle).",
        what, length_s, 1 << depth, end.change_m, params_.tolerance_m);
    return;
  }
  ++result.halvings;
  const double middle = 0.5 * (s0 + s1);
  cut(begin, input, s0, middle, h, depth + 1, result);
  if (result.outcome != Outcome::Done) return;
  const BeamState half = result.state;
  cut(half, input, middle, s1, h, depth + 1, result);
}

BeamStep::Result BeamStep::advance(const BeamState& begin, const Segment<MotionSet>& input,
                                   SimTime h) const {
  Result result;
  cut(begin, input, 0.0, 1.0, h, 0, result);
  if (result.outcome != Outcome::Done) return result;
  result.state.time = begin.time + h;
  return result;
}

}  // namespace tandem::fem::ancf

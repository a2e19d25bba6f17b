#include "fem_process/transient/static_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fem_process/body/held.h"
#include "fem_process/body/round_off.h"
#include "fem_process/elements/make_formulation.h"
#include "fem_process/matrix/node_vectors.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

/// Solves without a smaller residual after which an iteration counts as stalled.
constexpr int kPatience = 12;
/// Halvings of a load increment: 1/1024 of it.
constexpr int kMostCuts = 10;

/// The blocks between free nodes.
void gather_interior(const Model& model, const BlockValues& K, BlockValues& interior) {
  interior.resize(9 * model.interior.pattern.blocks());
  for (std::size_t b = 0; b < model.interior.source.size(); ++b) {
    block(interior, static_cast<int>(b)) = block(K, model.interior.source[b]);
  }
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

void check(const StaticParams& params) {
  require(!params.load_factors.empty(), "fem: the static analysis needs a load factor.");
  for (double factor : params.load_factors) {
    require(std::isfinite(factor), "fem: load factors must be finite.");
  }
  require(params.tolerance > 0.0 && params.tolerance < 1.0,
          "fem: the static tolerance must be above 0 and below 1.");
  require(params.max_iterations > 0, "fem: the static max_iterations must be positive.");
  require(std::isfinite(params.law_time_s), "fem: the static law time must be finite.");
}

StaticAnalysis::StaticAnalysis(const Model& model, StaticParams params)
    : model_(model), params_(std::move(params)) {
  check(params_);
  require_held(model_);
  load_ = model_.external_forces(params_.law_time_s);
  load_norm_ = gather(load_, model_.free).norm();
  solver_ = make_solver(model_.params.solver, model_.interior.pattern);
}

StaticAnalysis::Point StaticAnalysis::evaluate(Eigen::VectorXd x, double factor) const {
  Point point;
  point.x = std::move(x);
  Eigen::VectorXd f_int;
  point.inverted = model_.formulation->evaluate(point.x, f_int, point.K);
  point.residual = gather(factor * load_ - f_int, model_.free);
  point.norm = point.residual.norm();
  return point;
}

bool StaticAnalysis::converged(const Point& point, double factor) const {
  const double scale = factor != 0.0 ? std::abs(factor) * load_norm_ : load_norm_;
  return point.norm <= params_.tolerance * scale ||
         point.norm <= 2.0 * round_off(model_, point.K, point.x);
}

SolveReport StaticAnalysis::direction(const Point& point, Eigen::VectorXd& delta) {
  const auto solve = [&](const BlockValues& K) {
    BlockValues interior;
    gather_interior(model_, K, interior);
    SolveReport report = solver_->factorize(interior);
    if (report.outcome == Outcome::Failed) return report;
    Eigen::MatrixXd right = point.residual;
    report = solver_->solve(right, Eigen::VectorXd::Constant(1, point.norm));
    delta = right.col(0);
    return report;
  };
  // The direct solver notices a matrix that is not definite in factorising, PCG in solving.
  SolveReport report = solve(point.K);
  if (report.outcome != Outcome::Failed) return report;
  if (!definite_) {
    definite_ = make_formulation(FormulationKind::Corotational, model_.mesh, model_.materials);
  }
  Eigen::VectorXd f_int;
  BlockValues K;
  definite_->evaluate(point.x, f_int, K);
  report = solve(K);
  if (report.outcome == Outcome::Failed) {
    report.message =
        "fem: the stiffness of " + model_.mesh.file.string() +
        " is not positive definite to round-off, although the body is held. Check the material "
        "and the mesh for elements of extreme shape.";
  }
  return report;
}

StaticAnalysis::Point StaticAnalysis::move(const Point& from, const Eigen::VectorXd& delta,
                                           double factor, bool search) const {
  const auto at = [&](double alpha) {
    Eigen::VectorXd x = from.x;
    scatter_add(Eigen::VectorXd(alpha * delta), model_.free, x);
    return evaluate(std::move(x), factor);
  };
  Point trial = at(1.0);
  double g_high = delta.dot(trial.residual);
  if (!search || g_high > 0.0) return trial;  // g > 0: the energy still falls at α = 1
  // Secant steps for g(α) = δᵀ r(x + α δ) = 0, held in a bracket, until |g| has halved.
  const double g_0 = delta.dot(from.residual);
  double low = 0.0;
  double g_low = g_0;
  double high = 1.0;
  double g = g_high;
  for (int k = 0; k < 8 && !(std::abs(g) <= 0.5 * std::abs(g_0)); ++k) {
    double alpha = std::isfinite(g_high) ? low + (high - low) * g_low / (g_low - g_high) : 0.0;
    alpha = std::clamp(alpha, low + 0.1 * (high - low), low + 0.9 * (high - low));
    trial = at(alpha);
    g = delta.dot(trial.residual);
    if (g > 0.0) {
      low = alpha;
      g_low = g;
    } else {
      high = alpha;
      g_high = g;
    }
  }
  return trial;
}

SolveReport StaticAnalysis::iterate(Point& point, double factor, bool search, LoadStep& step) {
  double best = std::numeric_limits<double>::infinity();
  int since_best = 0;
  for (int k = 0; k < params_.max_iterations && since_best < kPatience; ++k) {
    if (converged(point, factor)) return {};
    Eigen::VectorXd delta;
    const SolveReport solved = direction(point, delta);
    ++step.iterations;
    if (solved.outcome != Outcome::Done) return solved;
    point = move(point, delta, factor, search);
    if (!std::isfinite(point.norm)) break;
    since_best = point.norm < best ? 0 : since_best + 1;
    best = std::min(best, point.norm);
  }
  if (std::isfinite(point.norm) && converged(point, factor)) return {};
  return {.outcome = Outcome::NotConverged,
          .message = "fem: no equilibrium at load factor " + number(factor) + ": residual " +
                     number(point.norm) + " N of a load of " + number(factor * load_norm_) +
                     " N after " + std::to_string(step.iterations) +
                     " iterations. Use more load steps, fem.formulation: "
                     "corotational_consistent, or a smaller load: the part may buckle here."};
}

SolveReport StaticAnalysis::increment(Point& point, double from, double to, int depth,
                                      LoadStep& step) {
  const Eigen::VectorXd start = point.x;
  SolveReport report;
  for (const bool search : {false, true}) {
    if (search ? !params_.safeguards : search_) continue;
    point = evaluate(start, to);
    report = iterate(point, to, search, step);
    step.searched = step.searched || search;
    if (report.outcome == Outcome::Done) return report;
    search_ = params_.safeguards;
  }
  if (report.outcome == Outcome::Failed || !params_.safeguards || depth == kMostCuts) return report;
  ++step.cuts;
  point = evaluate(start, from);
  const double middle = 0.5 * (from + to);
  report = increment(point, from, middle, depth + 1, step);
  if (report.outcome != Outcome::Done) return report;
  return increment(point, middle, to, depth + 1, step);
}

StaticResult StaticAnalysis::run(const std::function<void(const LoadStep&)>& observer) {
  StaticResult result;
  Point point = evaluate(model_.reference(), 0.0);
  double last = 0.0;
  for (double factor : params_.load_factors) {
    LoadStep step{.factor = factor};
    result.report = increment(point, last, factor, 0, step);
    if (result.report.outcome != Outcome::Done) return result;
    step.inverted_elements = point.inverted;
    step.residual = load_norm_ > 0.0 ? point.norm / load_norm_ : 0.0;
    step.x = point.x;
    last = factor;
    if (observer) observer(step);
    result.steps.push_back(std::move(step));
  }
  return result;
}

}  // namespace tandem::fem

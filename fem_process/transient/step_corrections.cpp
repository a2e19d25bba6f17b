#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "fem_process/body/round_off.h"
#include "fem_process/matrix/node_vectors.h"
#include "fem_process/transient/transient_step.h"
#include "protocol/contract/cost.h"

/// What follows a step's first solution.
namespace tandem::fem {

/// The simplified tangent leaves out what tension stiffens. Left to the next step's forces, that
/// feeds weakly damped methods, the more the larger its part of K. Forces anew where the step has
/// led to, and one more solution with the matrix that is there, bound it: with K_s in the matrix,
/// K_s + K_g in the forces, the second solution's amplification stays at or below one for any K_g >
/// 0, whatever the step (also with the average acceleration, which damps nothing).
void TransientStep::correct_once(const Input& input, Linearisation& kept, Eigen::VectorXd& v,
                                 Eigen::VectorXd& a, Result& result) const {
  if (!kept.corrected) kept.corrected = std::make_unique<Linearisation>();
  Linearisation& again = *kept.corrected;
  again.kind = Linearisation::Kind::Corrected;
  again.first = &kept;
  again.h_s = kept.h_s;
  again.map = kept.map;
  again.map.x_tilde = kept.map.x_tilde + result.d;
  again.map.d_hat -= result.d;
  again.inverted_elements = model_.formulation->evaluate(again.map.x_tilde, again.f_int, again.K);
  again.f_mean = again.f_int;
  carry_->take_mean(input.carried, again.f_mean);
  again.port_columns = kept.port_columns;
  again.port_response = kept.port_response;
  kept.has_correction = true;
  result.first_damped = damped(input, v);
  if (!loose_.empty()) {
    result.first_y = v;
    result.first_attached = result.state.attached;
  }
  result.d.setZero();

  Eigen::MatrixXd delta =
      -gather(balance(again, input, result.state.attached, v, result.d, a), model_.free);
  const double scale =
      measures_residuals() ? multiply_interior(kept.S, gather(v, model_.free)).norm() : 0.0;
  const double start_s = now_s();
  const SolveReport report =
      kept.solver->solve(delta, Eigen::VectorXd::Constant(1, std::max(scale, delta.norm())));
  result.times.solve_s += now_s() - start_s;
  result.report.iterations += report.iterations;
  result.report.residual = report.residual;
  if (report.outcome != Outcome::Done) {
    result.report.outcome = report.outcome;
    result.report.message = report.message;
  }
  if (report.outcome == Outcome::Failed) return;
  result.correction = delta.col(0);
  scatter_add(delta.col(0), model_.free, v);
  scatter_add(again.map.c_x * delta.col(0), model_.free, result.d);
  scatter_add(again.map.c_a * delta.col(0), model_.free, a);
  if (!loose_.empty()) {
    const Eigen::VectorXd before = gather(v, model_.free);
    const SolveReport closed = attach(input, again, v, a, result);
    if (closed.outcome == Outcome::Failed) result.report = closed;
    result.correction += gather(v, model_.free) - before;
  }
  const ProductPart part{.rows = &model_.prescribed};
  result.react = balance(again, input, result.state.attached, v, result.d, a, part);
  for (int node : model_.free) result.react.segment<3>(3 * node).setZero();
}

/// Newton's iteration on the balance of forces at the end of the step. Every iterate becomes the
/// linearisation point x̃; d̂ makes up for it, so that x̃ + d̂ stays.
void TransientStep::correct(const Input& input, Linearisation& kept, Eigen::VectorXd& v,
                            Eigen::VectorXd& a, Result& result) const {
  const IntegratorParams& params = model_.params.integrator;
  StepMap map = kept.map;
  if (!kept.corrected) kept.corrected = std::make_unique<Linearisation>();
  Linearisation& again = *kept.corrected;
  again.h_s = kept.h_s;
  again.kind = Linearisation::Kind::Iterated;
  again.first = nullptr;
  kept.has_correction = true;
  SolveReport total = result.report;
  double residual = 0.0;
  double limit = 0.0;
  for (int k = 0; k < params.newton_steps; ++k) {
    const Eigen::VectorXd x = map.x_tilde + result.d;
    map.d_hat += map.x_tilde - x;
    map.x_tilde = x;
    again.map = map;
    linearise_at_tilde(input.carried, again);
    result.report = again.factorisation;
    if (again.factorisation.outcome == Outcome::Failed) return;
    result.d.setZero();
    residual =
        gather(balance(again, input, result.state.attached, v, result.d, a), model_.free).norm();
    const double scale = std::max({again.f_int.norm(), input.f_ext.norm(),
                                   multiply_scalar(model_.pattern(), model_.mass, a).norm()});
    limit = std::max(params.newton_tolerance * scale, 2.0 * round_off(model_, again.K, x));
    // One more correction even when converged: it costs a substitution and squares the error.
    solve(input, again, v, a, result);
    total.iterations += result.report.iterations;
    if (result.report.outcome > total.outcome) {
      total.outcome = result.report.outcome;
      total.message = result.report.message;
    }
    result.report = total;
    if (residual <= limit || total.outcome == Outcome::Failed) return;
  }
  result.report = {.outcome = Outcome::NotConverged,
                   .message = "Newton's iteration has a residual of " +
                              fmt::format("{:.3g}", residual) + " N after " +
                              std::to_string(params.newton_steps) + " steps, limit " +
                              fmt::format("{:.3g}", limit) +
                              " N. Halve fem.micro_step_s or raise fem.integrator.newton_steps.",
                   .iterations = total.iterations};
}

}  // namespace tandem::fem

#include "mbs_process/spring_stability.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "mbs_process/loads.h"
#include "mbs_process/ode_world.h"
#include "mbs_process/rigid_world.h"

namespace tandem::mbs {
namespace {

constexpr double kHeavy = 1e9;

/// Without loads and velocities nothing moves but by the efforts that are tried.
Params at_rest(Params params) {
  params.gravity_m_per_s2.setZero();
  for (BodyParams& body : params.bodies) {
    body.v_WB.setZero();
    body.w_WB.setZero();
    // What a junction's springs move is the flexible bodies there, which are not known here.
    if (!body.massless) continue;
    body.mass_kg *= kHeavy;
    for (double& element : body.inertia_kg_m2) element *= kHeavy;
  }
  return params;
}

/// The multibody side at t = 0, for one step under efforts of the springs.
class Response {
 public:
  Response(const Params& params, double h_s)
      : h_s_(h_s),
        loads_(params),
        world_(at_rest(params)),
        begin_(initial_state(at_rest(params))),
        rule_(whole_step(params)) {}

  [[nodiscard]] const Loads& loads() const { return loads_; }

  /// Rates of all springs after one step under the effort of one.
  [[nodiscard]] Eigen::VectorXd rates(std::size_t spring, double effort) {
    std::vector<BodyWrench> applied(begin_.bodies.size());
    loads_.add_effort(spring, effort, begin_, applied);
    world_.load(begin_.bodies, begin_.joint_coordinates);
    world_.step(h_s_, applied, rule_);
    State end = begin_;
    world_.read(end.bodies);
    // Directions are those of the beginning: the poses have moved by h v.
    for (std::size_t i = 0; i < end.bodies.size(); ++i) {
      end.bodies[i].p_WB = begin_.bodies[i].p_WB;
      end.bodies[i].q_WB = begin_.bodies[i].q_WB;
    }
    Eigen::VectorXd rates(loads_.springs().size());
    for (std::size_t i = 0; i < loads_.springs().size(); ++i) {
      rates[static_cast<Eigen::Index>(i)] = loads_.rate(i, end);
    }
    return rates;
  }

 private:
  double h_s_;
  Loads loads_;
  OdeWorld world_;
  State begin_;
  StepRule rule_;
};

/// A: how fast efforts of 1 slow the springs, per second. Tried with efforts that give the body
/// alone 1e-6 m/s or rad/s: gyroscopic torques, which are not linear, then play no part.
Eigen::MatrixXd measure(const Params& params, Response& response, double h_s) {
  const std::vector<SpringData>& springs = response.loads().springs();
  const auto count = static_cast<Eigen::Index>(springs.size());
  Eigen::MatrixXd A(count, count);
  for (std::size_t j = 0; j < springs.size(); ++j) {
    const BodyParams& body = params.bodies[springs[j].body1];
    const double inertia = springs[j].turns ? body.inertia_B().trace() / 3.0 : body.mass_kg;
    const double impulse = 1e-6 * inertia;
    A.col(static_cast<Eigen::Index>(j)) = -response.rates(j, impulse / h_s) / impulse;
  }
  return 0.5 * (A + A.transpose());
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> scaled(const Eigen::MatrixXd& A,
                                                      const std::vector<SpringData>& springs,
                                                      double h_s) {
  Eigen::VectorXd root(A.rows());
  for (Eigen::Index i = 0; i < root.size(); ++i) {
    const SpringData& spring = springs[static_cast<std::size_t>(i)];
    root[i] = std::sqrt(h_s * h_s * spring.stiffness + 2.0 * h_s * spring.damping);
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
      Eigen::MatrixXd(root.asDiagonal() * A * root.asDiagonal()));
}

}  // namespace

SpringStability spring_stability(const Params& params) {
  const double h_s = to_seconds(params.micro_step.value_or(params.macro_step));
  Response response(params, h_s);
  const std::vector<SpringData>& springs = response.loads().springs();
  if (springs.empty()) return {};
  const Eigen::MatrixXd A = measure(params, response, h_s);
  const auto eigen = scaled(A, springs, h_s);
  Eigen::Index largest = 0;
  eigen.eigenvectors().rightCols<1>().cwiseAbs().maxCoeff(&largest);
  SpringStability result{.number = std::max(0.0, eigen.eigenvalues().maxCoeff()),
                         .spring = springs[static_cast<std::size_t>(largest)].name};
  // The number grows with h: bisect for the step at which it is 4.
  double low = 0.0;
  double high = h_s;
  for (int k = 0; k < 30 && !result.stable(); ++k) {
    const double middle = 0.5 * (low + high);
    (scaled(A, springs, middle).eigenvalues().maxCoeff() <= 4.0 ? low : high) = middle;
  }
  result.stable_step_s = low;
  return result;
}

std::optional<std::string> spring_warning(const Params& params) {
  const SpringStability found = spring_stability(params);
  if (found.stable()) return std::nullopt;
  return fmt::format(
      "spring '{}' is too stiff or too damped for micro steps of {:g} s: h² k/m + 2 h c/m = "
      "{:.3g} with the mass m that it moves, and explicit springs are unstable above 4. Set "
      "mbs.micro_step_s below {:.3g}, or lower its stiffness or damping.",
      found.spring, to_seconds(params.micro_step.value_or(params.macro_step)), found.number,
      found.stable_step_s);
}

}  // namespace tandem::mbs

#include "orchestrator/warnings/stability_warnings.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fem_process/reduced/highest_frequency.h"
#include "mbs_process/rigid_world.h"

namespace tandem::orchestrator {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& r) {
  Eigen::Matrix3d m;
  m << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return m;
}

/// Port of every node, −1: none.
std::vector<int> owners(const fem::Model& model) {
  std::vector<int> owner(model.mesh.X.size(), -1);
  for (std::size_t p = 0; p < model.ports.size(); ++p) {
    for (int node : model.ports[p].nodes) {
      owner[static_cast<std::size_t>(node)] = static_cast<int>(p);
    }
  }
  return owner;
}

}  // namespace

std::optional<Finding> unstable_newmark(const scenario::Node& root, const fem::Model& model) {
  const fem::IntegratorParams& integrator = model.params.integrator;
  if (integrator.kind != fem::IntegratorKind::Newmark || model.params.nodal ||
      model.params.formulation == fem::FormulationKind::CraigBampton ||
      integrator.newmark_beta >= 0.5 * integrator.newmark_gamma) {
    return std::nullopt;
  }
  const double w = fem::highest_step_frequency(model);
  const double limit_s =
      fem::newmark_step_limit_s(integrator.newmark_beta, integrator.newmark_gamma, w);
  const double h_s = to_seconds(model.params.micro_step);
  if (h_s <= limit_s) return std::nullopt;
  return finding_at(
      root.section("fem").section("integrator"), "newmark_beta", "unstable_newmark",
      fmt::format("with β = {:.4g} below γ/2 a step is stable up to {:.3g} s (the mesh's highest "
                  "frequency is {:.4g} Hz), and it has {:g} s. Set newmark_beta: {:g}, or steps "
                  "below that.",
                  integrator.newmark_beta, limit_s, w / (2.0 * EIGEN_PI), h_s,
                  0.5 * integrator.newmark_gamma));
}

double verlet_limit_rad(double beta) {
  const double lacking = 1.0 - 4.0 * beta;
  return lacking > 0.0 ? 2.0 / std::sqrt(lacking) : std::numeric_limits<double>::infinity();
}

Eigen::MatrixXd port_stiffness(const fem::Model& model, const MotionSet& origins) {
  Eigen::VectorXd f_int;
  fem::BlockValues K;
  model.formulation->evaluate(model.reference(), f_int, K);
  const auto ports = static_cast<Eigen::Index>(model.ports.size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(6 * ports, 6 * ports);
  // Of a rigid set: node i moves by v + w × r_i.
  const auto arm = [&](std::size_t port, int node) {
    Eigen::Matrix<double, 3, 6> T;
    const Eigen::Vector3d r = model.mesh.X[static_cast<std::size_t>(node)] - origins[port].p_WP;
    T << Eigen::Matrix3d::Identity(), -skew(r);
    return T;
  };
  const std::vector<int> owner = owners(model);
  const fem::BlockPattern& pattern = model.pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    const int a = owner[static_cast<std::size_t>(i)];
    if (a < 0) continue;
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      const int j = pattern.column[static_cast<std::size_t>(b)];
      const int c = owner[static_cast<std::size_t>(j)];
      if (c < 0) continue;
      stiffness.block<6, 6>(6 * a, 6 * c) += arm(static_cast<std::size_t>(a), i).transpose() *
                                             fem::block(std::as_const(K), b) *
                                             arm(static_cast<std::size_t>(c), j);
    }
  }
  return stiffness;
}

PortOscillation fastest_port(const Model& model, const mbs::Params& params,
                             const fem::Model& body) {
  // What velocities a wrench makes is what one step of Euler's rule says; Verlet's answers by half.
  mbs::Params euler = params;
  euler.integrator = mbs::IntegratorKind::Euler;
  euler.micro_step = std::nullopt;
  mbs::RigidWorld rigid(std::move(euler));
  const WrenchSet none(params.ports.size());
  const MotionSet origins = rigid.initialize(none);
  const auto moved =
      rigid.advance({.step = model.run.macro_step, .input = {none, none}, .linearize = true});
  if (!moved.jacobian) return {};
  const auto ports = static_cast<Eigen::Index>(origins.size());
  const double H_s = to_seconds(model.run.macro_step);
  Eigen::MatrixXd mobility(6 * ports, 6 * ports);
  for (Eigen::Index i = 0; i < ports; ++i) {
    mobility.middleRows(6 * i, 6) = moved.jacobian->middleRows(12 * i + 6, 6) / H_s;
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> found(mobility * port_stiffness(body, origins));
  Eigen::Index mode = 0;
  const double w_squared = found.eigenvalues().real().maxCoeff(&mode);
  Eigen::Index row = 0;
  found.eigenvectors().col(mode).cwiseAbs().maxCoeff(&row);
  return {.port = params.ports[static_cast<std::size_t>(row / 6)].name,
          .angle_rad = H_s * std::sqrt(std::max(0.0, w_squared))};
}

namespace {

bool same_ports(const fem::Model& body, const mbs::Params& params) {
  return std::equal(body.ports.begin(), body.ports.end(), params.ports.begin(), params.ports.end(),
                    [](const auto& a, const auto& b) { return a.name == b.name; });
}

}  // namespace

std::optional<Finding> unstable_verlet(const Model& model, const mbs::Params& params,
                                       const fem::Model& body) {
  const auto loose = [](const fem::Model::Port& port) { return port.attachment.loose(); };
  if (params.integrator != mbs::IntegratorKind::Verlet || params.newmark_beta >= 0.25 ||
      body.params.nodal || body.params.formulation == fem::FormulationKind::CraigBampton ||
      !same_ports(body, params) ||  // one of several bodies or worlds
      std::any_of(body.ports.begin(), body.ports.end(), loose)) {
    return std::nullopt;
  }
  const PortOscillation found = fastest_port(model, params, body);
  const double limit = verlet_limit_rad(params.newmark_beta);
  if (found.angle_rad <= limit) return std::nullopt;
  const double H_s = to_seconds(model.run.macro_step);
  const scenario::Node mbs = model.scenario.root.section("mbs");
  return finding_at(
      mbs, "newmark_beta", "unstable_verlet",
      fmt::format("with β = {:.4g} the coupled step is certain to be stable only while ω H stays "
                  "below {:.3g} for the rigid bodies on the stiffness of the elements at their "
                  "ports; at port '{}' it is {:.3g}. Set {}: 0.25, or "
                  "run.macro_step_s to {:.2g} or less.",
                  params.newmark_beta, limit, found.port, found.angle_rad,
                  mbs.path_name("newmark_beta"), H_s * limit / found.angle_rad));
}

}  // namespace tandem::orchestrator

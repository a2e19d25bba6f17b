#include "orchestrator/advise/interface_ratios.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

double largest_eigenvalue(const Eigen::Matrix3d& m) {
  const Eigen::Matrix3d symmetric = 0.5 * (m + m.transpose());
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(symmetric, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

template <class T>
const InterfaceJacobian& jacobian_of(const StepResult<T>& result, const std::string& side) {
  if (result.outcome == Outcome::Failed) {
    throw Error(ErrorKind::NotSolved, side + ": " + result.message);
  }
  require(result.jacobian.has_value(),
          "the side '" + side +
              "' has no interface derivative, so the coupling ratio cannot be measured. Choose a "
              "model that can linearise, or try schemes with `tandem compare --schemes`.");
  return *result.jacobian;
}

PortRatio port_ratio(const std::string& name, const InterfaceJacobian& B,
                     const InterfaceJacobian& L, Eigen::Index port, double h_s) {
  const Eigen::Matrix3d mobility = B.block<3, 3>(12 * port + 6, 6 * port);
  const Eigen::Matrix3d by_position = L.block<3, 3>(6 * port, 12 * port);
  const Eigen::Matrix3d by_velocity = L.block<3, 3>(6 * port, 12 * port + 6);
  const double freest = largest_eigenvalue(mobility);
  return {.name = name,
          .rigid_kg = freest > 0.0 ? h_s / freest : HUGE_VAL,
          .flexible_kg = h_s * largest_eigenvalue(-(by_velocity + h_s * by_position)),
          .stiffness_N_per_m = largest_eigenvalue(-by_position)};
}

/// Roots of z^n = c[0] + c[1] z + … by the companion matrix.
double largest_root(const Eigen::VectorXcd& c) {
  const Eigen::Index n = c.size();
  Eigen::MatrixXcd companion = Eigen::MatrixXcd::Zero(n, n);
  for (Eigen::Index i = 1; i < n; ++i) companion(i, i - 1) = 1.0;
  companion.col(n - 1) = c;
  return Eigen::ComplexEigenSolver<Eigen::MatrixXcd>(companion, false)
      .eigenvalues()
      .cwiseAbs()
      .maxCoeff();
}

}  // namespace

double InterfaceRatios::coupling_ratio() const {
  double largest = 0.0;
  for (const std::complex<double>& g : gains) largest = std::max(largest, std::abs(g));
  return largest;
}

InterfaceRatios measure_ratios(MbsSide& mbs, FemSide& fem, SimTime H) {
  const WrenchSet no_wrench(mbs.info().ports.size());
  const MotionSet start = mbs.initialize(no_wrench);
  const WrenchSet wrench = fem.initialize(start);
  mbs.checkpoint();
  fem.checkpoint();
  const auto moved = mbs.advance({.step = H, .input = {wrench, wrench}, .linearize = true});
  const InterfaceJacobian B = jacobian_of(moved, "mbs");
  const auto answered = fem.advance({.step = H, .input = {start, moved.output}, .linearize = true});
  const InterfaceJacobian L = jacobian_of(answered, "fem");
  mbs.rollback();
  fem.rollback();

  InterfaceRatios ratios{.step_s = to_seconds(H)};
  const Eigen::VectorXcd gains =
      Eigen::EigenSolver<Eigen::MatrixXd>(L * B, /* computeEigenvectors = */ false).eigenvalues();
  ratios.gains.assign(gains.begin(), gains.end());
  for (std::size_t port = 0; port < mbs.info().ports.size(); ++port) {
    ratios.ports.push_back(port_ratio(mbs.info().ports[port].name, B, L,
                                      static_cast<Eigen::Index>(port), ratios.step_s));
  }
  return ratios;
}

double explicit_amplification(const InterfaceRatios& ratios, Prediction prediction) {
  double largest = 0.0;
  for (const std::complex<double>& g : ratios.gains) {
    Eigen::VectorXcd c(1);
    c << g;
    if (prediction == Prediction::Linear) c = Eigen::Vector2cd(-g, 2.0 * g);
    largest = std::max(largest, largest_root(c));
  }
  return largest;
}

}  // namespace tandem::orchestrator

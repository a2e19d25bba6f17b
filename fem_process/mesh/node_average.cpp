#include "fem_process/mesh/node_average.h"

#include <Eigen/Dense>
#include <cmath>
#include <utility>

namespace tandem::fem {

Matrix12 four_times(const Eigen::Matrix3d& A) {
  Matrix12 blocks = Matrix12::Zero();
  for (int j = 0; j < 4; ++j) blocks.block<3, 3>(3 * j, 3 * j) = A;
  return blocks;
}

NodeAverage::NodeAverage(const std::vector<int>& nodes, std::vector<double> weights,
                         const std::vector<Eigen::Vector3d>& arms)
    : nodes_(nodes), arms_(arms), shares_(4, static_cast<Eigen::Index>(nodes.size())) {
  double sum = 0.0;
  for (double w : weights) sum += w;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    weights[k] /= sum;
    centroid_ += weights[k] * arms_[k];
  }
  double square = 0.0;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    arms_[k] -= centroid_;
    square += weights[k] * arms_[k].squaredNorm();
  }
  const double length = std::sqrt(square);
  for (std::size_t k = 0; k < nodes_.size() && length > 0.0; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    shares_(0, column) = weights[k];
    shares_.block<3, 1>(1, column) = weights[k] / length * arms_[k];
    inertia_ += weights[k] / length * arms_[k] * arms_[k].transpose();
  }
  const Eigen::Matrix3d turning = inertia_.trace() * Eigen::Matrix3d::Identity() - inertia_;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(turning);
  collinear_ = !(axes.eigenvalues()(0) > 1e-10 * length) || !(length > 0.0);
  if (!collinear_) inverse_turning_ = turning.inverse();
}

Vector12 NodeAverage::coordinates(const Eigen::VectorXd& x) const {
  Vector12 q = Vector12::Zero();
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    for (int j = 0; j < 4; ++j) q.segment<3>(3 * j) += share(k, j) * x.segment<3>(3 * nodes_[k]);
  }
  return q;
}

void NodeAverage::add_forces(const Vector12& phi, double scale, Eigen::VectorXd& f) const {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Eigen::Vector3d force = share(k, 0) * phi.head<3>();
    for (int j = 1; j < 4; ++j) force += share(k, j) * phi.segment<3>(3 * j);
    f.segment<3>(3 * nodes_[k]) += scale * force;
  }
}

/// Largest eigenvector of Horn's matrix: the unit quaternion that maximises Σ_k q_k · R e_k.
Eigen::Matrix3d NodeAverage::rotation(const Vector12& q) {
  const Eigen::Matrix3d A = Eigen::Map<const Eigen::Matrix3d>(q.data() + 3);  // columns q_k
  Eigen::Matrix4d N;
  const Eigen::Vector3d axial(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1));
  N(0, 0) = A.trace();
  N.block<3, 1>(1, 0) = axial;
  N.block<1, 3>(0, 1) = axial.transpose();
  N.block<3, 3>(1, 1) = A + A.transpose() - A.trace() * Eigen::Matrix3d::Identity();
  const Eigen::Vector4d best =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(N).eigenvectors().col(3);
  return Eigen::Quaterniond(best(0), best(1), best(2), best(3)).normalized().toRotationMatrix();
}

void NodeAverage::add_rigid_field(const Eigen::Matrix3d& R, const Eigen::Vector3d& mean,
                                  const Eigen::Vector3d& omega, Eigen::VectorXd& field) const {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    field.segment<3>(3 * nodes_[k]) += mean + omega.cross(R * arms_[k]);
  }
}

Eigen::Vector3d NodeAverage::turn_of(const Eigen::Matrix3d& R, const Vector12& eta) const {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d eta_P = R.transpose() * eta.segment<3>(3 * (k + 1));
    moment += Eigen::Vector3d::Unit(k).cross(eta_P);
  }
  return R * turn(moment);
}

void NodeAverage::add_rigid_part(const Eigen::Matrix3d& R, const Vector12& eta, double scale,
                                 Eigen::VectorXd& field) const {
  add_rigid_field(R, scale * eta.head<3>(), scale * turn_of(R, eta), field);
}

Vector12 NodeAverage::rigid_part(const Eigen::Matrix3d& R, const Vector12& eta) const {
  const Eigen::Vector3d omega = turn_of(R, eta);
  Vector12 part = eta;
  for (int k = 0; k < 3; ++k) {
    part.segment<3>(3 * (k + 1)) = omega.cross(Eigen::Vector3d(R * inertia_.col(k)));
  }
  return part;
}

}  // namespace tandem::fem

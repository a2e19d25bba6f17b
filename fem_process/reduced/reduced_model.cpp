#include "fem_process/reduced/reduced_model.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

bool has_ground(const Model& model) { return !model.fixed.empty(); }

Eigen::Vector3d centroid(const Model& model, const std::vector<int>& nodes) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int node : nodes) sum += model.mesh.X[static_cast<std::size_t>(node)];
  return sum / static_cast<double>(nodes.size());
}

Motion ground_of(const Model& model) {
  Motion ground;
  if (has_ground(model)) ground.p_WP = centroid(model, model.fixed);
  return ground;
}

FloatingFrame make_frame(const Model& model, MotionSet motions) {
  if (has_ground(model)) motions.push_back(ground_of(model));
  std::vector<int> all(static_cast<std::size_t>(model.mesh.nodes()));
  std::iota(all.begin(), all.end(), 0);
  return {std::move(motions), frame_weights(model), centroid(model, all)};
}

std::vector<RigidPart> rigid_parts(const Model& model, const MotionSet& motions) {
  std::vector<RigidPart> parts;
  for (std::size_t p = 0; p < model.ports.size(); ++p) {
    parts.push_back({model.ports[p].nodes, motions[p].p_WP});
  }
  if (has_ground(model)) parts.push_back({model.fixed, ground_of(model).p_WP});
  return parts;
}

/// (m ⊗ 1) N, columns of scalar fields.
Eigen::MatrixXd mass_times(const Model& model, const Eigen::MatrixXd& N) {
  const BlockPattern& pattern = model.pattern();
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(N.rows(), N.cols());
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int b = pattern.row_start[static_cast<std::size_t>(i)];
         b < pattern.row_start[static_cast<std::size_t>(i) + 1]; ++b) {
      product.row(i) += model.mass[static_cast<std::size_t>(b)] *
                        N.row(pattern.column[static_cast<std::size_t>(b)]);
    }
  }
  return product;
}

/// A field of vectors, 3 rows per node, as 3 columns of its components.
Eigen::MatrixXd components(const Eigen::VectorXd& nodal) {
  return Eigen::Map<const Eigen::Matrix3Xd>(nodal.data(), 3, nodal.size() / 3).transpose();
}

}  // namespace

std::vector<double> frame_weights(const Model& model) {
  const SetName& frame = model.params.craig_bampton.frame;
  const std::size_t parts = model.ports.size() + (has_ground(model) ? 1 : 0);
  std::vector<double> weights(parts, 0.0);
  if (frame.name == "mean") {
    std::fill(weights.begin(), weights.end(), 1.0 / static_cast<double>(parts));
  } else if (frame.name != "world") {
    std::size_t carrier = 0;
    while (carrier < model.ports.size() && model.ports[carrier].name != frame.name) ++carrier;
    require(carrier < model.ports.size(), (frame.place.file.empty() ? "fem" : frame.place.text()) +
                                              ": fem.craig_bampton.frame: no port is called '" +
                                              frame.name + "'. Name a port, or say mean or world.");
    weights[carrier] = 1.0;
  }
  return weights;
}

ReducedModel::ReducedModel(const Model& model, const BoundaryModes& modes, const MotionSet& motions)
    : model_(model),
      frame_(make_frame(model, motions)),
      ground_(ground_of(model)),
      grounded_(has_ground(model)),
      omega2_(modes.angular_frequencies.cwiseAbs2()) {
  const Eigen::MatrixXd psi = constraint_modes(model, rigid_parts(model, motions));
  const Eigen::Index m = modes.shapes.cols();
  N_.resize(model.mesh.nodes(), 4 + 3 * (psi.cols() + m));
  N_.col(0).setOnes();
  for (int i = 0; i < model.mesh.nodes(); ++i) {
    N_.block<1, 3>(i, 1) =
        (model.mesh.X[static_cast<std::size_t>(i)] - frame_.reference()).transpose();
  }
  for (Eigen::Index c = 0; c < psi.cols(); ++c) {
    N_.middleCols<3>(4 + 3 * c) = components(psi.col(c));
  }
  const Eigen::Index first = 4 + 3 * psi.cols();
  for (Eigen::Index c = 0; c < m; ++c) {
    N_.middleCols<3>(first + 3 * c) = components(modes.shapes.col(c));
  }
  turn_.emplace(model.mesh, N_.rightCols(N_.cols() - 4));
  T_ = N_.transpose() * mass_times(model, N_);
  T_ = (0.5 * (T_ + T_.transpose())).eval();

  Eigen::VectorXd f_int;
  BlockValues K;
  model.formulation->evaluate(model.reference(), f_int, K);
  Eigen::MatrixXd K_psi(psi.rows(), psi.cols());
  for (Eigen::Index c = 0; c < psi.cols(); ++c) {
    K_psi.col(c) = multiply(model.pattern(), K, psi.col(c));
  }
  K_boundary_ = psi.transpose() * K_psi;
  K_boundary_ = (0.5 * (K_boundary_ + K_boundary_.transpose())).eval();

  for (int axis = 0; axis < 3; ++axis) {
    const int k = (axis + 2) % 3;
    const int l = (axis + 1) % 3;
    Eigen::MatrixXd& C = coriolis_[static_cast<std::size_t>(axis)];
    C.resize(m, m);
    for (Eigen::Index c = 0; c < m; ++c) {
      for (Eigen::Index d = 0; d < m; ++d) {
        C(c, d) =
            T_(first + 3 * c + k, first + 3 * d + l) - T_(first + 3 * c + l, first + 3 * d + k);
      }
    }
  }
  gravity_ =
      (N_.transpose() * components(model.external_forces(0.0) - model.loads(0.0))).transpose();
  for (const Load& load : model.params.loads) {
    Load unit = load;
    unit.law = Law{ConstantLaw{1.0}};
    Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * model.mesh.nodes());
    LoadCase(model.mesh, {unit}).add(0.0, f);
    loads_.push_back({(N_.transpose() * components(f)).transpose(), load.law});
  }
}

MotionSet ReducedModel::with_ground(const MotionSet& ports) const {
  MotionSet motions = ports;
  if (grounded_) motions.push_back(ground_);
  return motions;
}

FieldMotion ReducedModel::fields_of(const Eigen::Vector3d& p, const Eigen::Matrix3d& R, double one,
                                    const Eigen::VectorXd& z) {
  FieldMotion Y(3, 4 + 3 * z.size());
  Y.col(0) = p;
  Y.middleCols<3>(1) = one * R;
  for (Eigen::Index c = 0; c < z.size(); ++c) Y.middleCols<3>(4 + 3 * c) = z(c) * R;
  return Y;
}

FieldMotion ReducedModel::loads(double t_s) const {
  FieldMotion sum = FieldMotion::Zero(3, fields());
  for (const LoadField& load : loads_) sum += load.law(t_s) * load.unit;
  return sum;
}

FieldMotion ReducedModel::external_forces(double t_s) const { return loads(t_s) + gravity_; }

Eigen::VectorXd ReducedModel::equilibrium(double factor, double t_s) const {
  const FieldMotion forces = factor * external_forces(t_s);
  require(boundary() > 0,
          "fem: nothing holds the body, so it has no equilibrium. Name a set in fem.fixed.");
  Eigen::VectorXd z = Eigen::VectorXd::Zero(boundary() + modes());
  for (Eigen::Index c = 0; c < modes(); ++c) {
    z(boundary() + c) = forces.middleCols<3>(first_modal_field(*this) + 3 * c).trace() / omega2_(c);
  }
  return expand(fields_of(frame_.reference(), Eigen::Matrix3d::Identity(), 1.0, z));
}

Eigen::VectorXd ReducedModel::expand(const FieldMotion& motion) const {
  Eigen::VectorXd nodal(3 * N_.rows());
  Eigen::Map<Eigen::Matrix3Xd>(nodal.data(), 3, N_.rows()) = motion * N_.transpose();
  return nodal;
}

Eigen::VectorXd ReducedModel::project(const Eigen::VectorXd& nodal) const {
  const Eigen::VectorXd p = multiply_scalar(model_.pattern(), model_.mass, nodal);
  const Eigen::MatrixXd P = components(p);
  const Eigen::Index first = first_modal_field(*this);
  Eigen::VectorXd part(modes());
  for (Eigen::Index c = 0; c < modes(); ++c) {
    part(c) = N_.middleCols<3>(first + 3 * c).cwiseProduct(P).sum();
  }
  return part;
}

}  // namespace tandem::fem

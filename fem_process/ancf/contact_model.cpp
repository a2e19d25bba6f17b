#include "fem_process/ancf/contact_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "fem_process/kernels/cross_matrix.h"

namespace tandem::fem::ancf {
namespace {

using Block24 = Eigen::Matrix<double, kCoordinates, kCoordinates, Eigen::RowMajor>;

/// K += s sᵀ ⊗ W.
void add_block(const Eigen::Matrix<double, kVectors, 1>& s, const Eigen::Matrix3d& W, double* K) {
  for (int a = 0; a < kVectors; ++a) {
    const Eigen::Matrix3d row = s(a) * W;
    for (int i = 0; i < 3; ++i) {
      double* out = K + (3 * a + i) * kCoordinates;
      const double w0 = row(i, 0);
      const double w1 = row(i, 1);
      const double w2 = row(i, 2);
      for (int b = 0; b < kVectors; ++b) {
        out[3 * b] += s(b) * w0;
        out[3 * b + 1] += s(b) * w1;
        out[3 * b + 2] += s(b) * w2;
      }
    }
  }
}

}  // namespace

/// Vectors of an element and their rates.
struct ContactModel::Element {
  BeamVectors e, rate;
};

ContactModel::ContactModel(const BeamMesh& mesh, const BeamSection& section,
                           std::vector<Wheel> wheels, std::vector<Ground> grounds,
                           const ContactGrid& grid)
    : mesh_(&mesh), section_(section), wheels_(std::move(wheels)), grounds_(std::move(grounds)) {
  const GaussRule along = gauss_rule(grid.along);
  const GaussRule across = gauss_rule(grid.across);
  points_ = along.point.size() * across.point.size();
  for (const BeamElement& element : mesh.elements) {
    const double length = element.length_m;
    for (const double z : {-0.5 * section.height_m, 0.5 * section.height_m}) {
      for (std::size_t i = 0; i < along.point.size(); ++i) {
        for (std::size_t j = 0; j < across.point.size(); ++j) {
          const double y = section.width_m * (across.point[j] - 0.5);
          patches_.push_back({shape_values(length, along.point[i], y, z),
                              along.weight[i] * across.weight[j] * (length * section.width_m)});
        }
      }
    }
  }
}

ContactModel::Element ContactModel::gather(int element, const Eigen::VectorXd& q,
                                           const Eigen::VectorXd& v) const {
  return {mesh_->gather(element, q), mesh_->gather(element, v)};
}

bool ContactModel::near(const Wheel& wheel, const MotionSet& motions, int element,
                        const Element& vectors) const {
  const Motion& motion = motions[static_cast<std::size_t>(wheel.port)];
  const Eigen::Vector3d axis = motion.q_WP * Eigen::Vector3d::UnitY();
  const Eigen::Vector3d d = 0.5 * (vectors.e.col(0) + vectors.e.col(4)) - motion.p_WP;
  const double distance = (d - d.dot(axis) * axis).norm();
  // Twice the stress-free half-length and half-thickness: no strain of use goes that far.
  return distance < wheel.radius_m + mesh_->elements[static_cast<std::size_t>(element)].length_m +
                        section_.height_m;
}

bool ContactModel::near(const Ground& ground, int element, const Element& vectors) const {
  const double length = mesh_->elements[static_cast<std::size_t>(element)].length_m;
  const double height =
      ground.normal.dot(0.5 * (vectors.e.col(0) + vectors.e.col(4)) - ground.point_m);
  // A band that lies on edge reaches down by half its width.
  return height < length + section_.height_m + section_.width_m;
}

/// Calls visit(wheel or −1, ground or −1, patch, r, traction) for all points in contact.
template <class Visit>
void ContactModel::for_each_touch(int element, const Element& vectors, const MotionSet& motions,
                                  bool derivatives, bool friction, const Visit& visit) const {
  Traction touch;
  ContactPoint point;
  const auto sweep = [&](Face face, const ContactParams& given, const auto& point_of, int wheel,
                         int ground) {
    ContactParams params = given;
    if (!friction) params.friction = 0.0;
    const std::size_t first =
        (2 * static_cast<std::size_t>(element) + (face == Face::Inner ? 0 : 1)) * points_;
    for (std::size_t i = first; i < first + points_; ++i) {
      const Patch& patch = patches_[i];
      const Eigen::Vector3d r = vectors.e * patch.shape;
      const Eigen::Vector3d v = vectors.rate * patch.shape;
      if (!point_of(r, v) || !traction(params, point, derivatives, touch)) continue;
      visit(wheel, ground, patch, r, touch);
    }
  };
  for (std::size_t w = 0; w < wheels_.size(); ++w) {
    const Wheel& wheel = wheels_[w];
    if (!near(wheel, motions, element, vectors)) continue;
    const Motion& motion = motions[static_cast<std::size_t>(wheel.port)];
    const Eigen::Vector3d axis = motion.q_WP * Eigen::Vector3d::UnitY();
    sweep(
        wheel.face, wheel.contact,
        [&](const Eigen::Vector3d& r, const Eigen::Vector3d& v) {
          return on_cylinder(wheel.radius_m, axis, motion, r, v, derivatives, point);
        },
        static_cast<int>(w), -1);
  }
  for (std::size_t g = 0; g < grounds_.size(); ++g) {
    const Ground& ground = grounds_[g];
    if (!near(ground, element, vectors)) continue;
    sweep(
        ground.face, ground.contact,
        [&](const Eigen::Vector3d& r, const Eigen::Vector3d& v) {
          return on_plane(ground.point_m, ground.normal, r, v, point);
        },
        -1, static_cast<int>(g));
  }
}

void ContactModel::add_teeth(int element, const Element& vectors, const MotionSet& motions,
                             std::optional<double> theta, ElementArrays& elements,
                             ContactSums& sums) const {
  ToothForce push;
  for (const Wheel& wheel : wheels_) {
    if (!wheel.teeth || !near(wheel, motions, element, vectors)) continue;
    const Motion& motion = motions[static_cast<std::size_t>(wheel.port)];
    // The pin at the beginning of the element: r¹ is a vector of its own.
    const Eigen::Vector3d r = vectors.e.col(0);
    if (!tooth_force(*wheel.teeth, wheel.radius_m, motion, r, vectors.rate.col(0), push)) continue;
    ++sums.seated_pins;
    sums.stored_J += push.stored_J;
    sums.loss_W += push.loss_W;
    Wrench& wrench = sums.wheels[static_cast<std::size_t>(wheel.port)];
    wrench.f_P_W -= push.force;
    wrench.t_P_W -= (r - motion.p_WP).cross(push.force);
    double* force = elements.force_of(element);
    for (int i = 0; i < 3; ++i) force[i] -= push.force(i);
    if (!theta) continue;
    Eigen::Map<Block24> K(elements.tangent_of(element));
    K.topLeftCorner<3, 3>() -= push.by_position + *theta * push.by_velocity;
  }
}

void ContactModel::add(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const MotionSet& motions,
                       bool friction, std::optional<double> theta, ElementArrays& elements,
                       ContactSums& sums) const {
  sums = ContactSums{};
  sums.wheels.assign(motions.size(), Wrench{});
  if (empty()) return;
  const int n = static_cast<int>(mesh_->elements.size());
  for (int e = 0; e < n; ++e) {
    const Element vectors = gather(e, q, v);
    Eigen::Map<BeamVectors> force(elements.force_of(e));
    for_each_touch(
        e, vectors, motions, theta.has_value(), friction,
        [&](int wheel, int, const Patch& patch, const Eigen::Vector3d& r, const Traction& touch) {
          const Eigen::Vector3d f = patch.area_m2 * touch.force;
          force.noalias() -= f * patch.shape.transpose();
          sums.stored_J += patch.area_m2 * touch.stored;
          sums.loss_W += patch.area_m2 * touch.loss;
          if (wheel >= 0) {
            const auto port =
                static_cast<std::size_t>(wheels_[static_cast<std::size_t>(wheel)].port);
            sums.wheels[port].f_P_W -= f;
            sums.wheels[port].t_P_W -= (r - motions[port].p_WP).cross(f);
            sums.depth_m = std::max(sums.depth_m, touch.depth);
          } else {
            sums.ground -= f;
            sums.ground_depth_m = std::max(sums.ground_depth_m, touch.depth);
          }
          if (!theta) return;
          const Eigen::Matrix3d W =
              -patch.area_m2 * (touch.by_position + *theta * touch.by_velocity);
          add_block(patch.shape, W, elements.tangent_of(e));
        });
    add_teeth(e, vectors, motions, theta, elements, sums);
  }
}

std::vector<Touch> ContactModel::touches(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                         const MotionSet& motions, bool friction) const {
  std::vector<Touch> all;
  if (wheels_.empty()) return all;
  for (int e = 0; e < static_cast<int>(mesh_->elements.size()); ++e) {
    const Element vectors = gather(e, q, v);
    for_each_touch(
        e, vectors, motions, true, friction,
        [&](int w, int, const Patch& patch, const Eigen::Vector3d& r, const Traction& touch) {
          if (w < 0) return;
          const int port = wheels_[static_cast<std::size_t>(w)].port;
          const Eigen::Matrix3d spin = cross_matrix(motions[static_cast<std::size_t>(port)].w_WP);
          all.push_back({.element = e,
                         .port = port,
                         .shape = patch.shape,
                         .r = r,
                         .v = vectors.rate * patch.shape,
                         .force = patch.area_m2 * touch.force,
                         .by_place = patch.area_m2 * (touch.by_position + touch.by_slip * spin),
                         .by_approach = patch.area_m2 * (touch.by_velocity - touch.by_slip),
                         .by_slip = patch.area_m2 * touch.by_slip});
        });
    ToothForce push;
    for (const Wheel& wheel : wheels_) {
      const Motion& motion = motions[static_cast<std::size_t>(wheel.port)];
      const Eigen::Vector3d r = vectors.e.col(0);
      if (!wheel.teeth || !near(wheel, motions, e, vectors) ||
          !tooth_force(*wheel.teeth, wheel.radius_m, motion, r, vectors.rate.col(0), push)) {
        continue;
      }
      all.push_back({.element = e,
                     .port = wheel.port,
                     .shape = Eigen::Matrix<double, kVectors, 1>::Unit(0),
                     .r = r,
                     .v = vectors.rate.col(0),
                     .force = push.force,
                     .by_place = push.by_position,
                     .by_approach = Eigen::Matrix3d::Zero(),
                     .by_slip = push.by_velocity});
    }
  }
  return all;
}

std::vector<double> ContactModel::pressures(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                            const MotionSet& motions) const {
  std::vector<double> means;
  if (mesh_ == nullptr) return means;
  for (int e = 0; e < static_cast<int>(mesh_->elements.size()); ++e) {
    const double area = mesh_->elements[static_cast<std::size_t>(e)].length_m * section_.width_m;
    double force = 0.0;
    for_each_touch(e, gather(e, q, v), motions, false, false,
                   [&](int, int, const Patch& patch, const Eigen::Vector3d&,
                       const Traction& touch) { force += patch.area_m2 * touch.pressure; });
    means.push_back(force / area);
  }
  return means;
}

}  // namespace tandem::fem::ancf

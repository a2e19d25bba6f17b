#include "orchestrator/warnings/body_warnings.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "protocol/scenario/common_keys.h"

namespace tandem::orchestrator {
namespace {

constexpr double kLongest_m = 30.0;
constexpr double kHeaviest_kg = 1e6;
constexpr double kSmallest_m = 1e-6;
constexpr double kFarPort = 3.0;
constexpr double kSlender = 5.0;
constexpr double kMostExcess = 0.1;

double diagonal_of(const fem::TetMesh& mesh, const std::vector<int>& nodes) {
  Eigen::AlignedBox3d box;
  for (int node : nodes) box.extend(mesh.X[static_cast<std::size_t>(node)]);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

double mass_of(const fem::Model& model) {
  return std::accumulate(model.nodal_mass.begin(), model.nodal_mass.end(), 0.0);
}

double extent(const fem::TetMesh& mesh, const Eigen::Vector3d& axis) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const Eigen::Vector3d& X : mesh.X) {
    lowest = std::min(lowest, axis.dot(X));
    highest = std::max(highest, axis.dot(X));
  }
  return highest - lowest;
}

/// Principal axes of the nodes as columns, the longest last.
Eigen::Matrix3d principal_axes(const fem::TetMesh& mesh) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& X : mesh.X) mean += X;
  mean /= static_cast<double>(mesh.X.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& X : mesh.X) spread += (X - mean) * (X - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
}

/// The direction across the long axis in which the mesh is thinnest; the two short principal axes
/// of a square section stand anyhow.
Eigen::Vector3d thinnest_direction(const fem::TetMesh& mesh, const Eigen::Matrix3d& axes) {
  constexpr int kAngles = 36;
  Eigen::Vector3d thinnest = axes.col(0);
  double least = extent(mesh, thinnest);
  for (int i = 1; i < kAngles; ++i) {
    const double angle = std::numbers::pi * i / kAngles;
    const Eigen::Vector3d axis = std::cos(angle) * axes.col(0) + std::sin(angle) * axes.col(1);
    const double size = extent(mesh, axis);
    if (size < least) {
      least = size;
      thinnest = axis;
    }
  }
  return thinnest;
}

/// Median extent of the elements along a direction.
double median_extent(const fem::TetMesh& mesh, const Eigen::Vector3d& axis) {
  std::vector<double> extents;
  extents.reserve(mesh.tets.size());
  for (const fem::Tet& tet : mesh.tets) {
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (int node : tet) {
      const double s = axis.dot(mesh.X[static_cast<std::size_t>(node)]);
      lowest = std::min(lowest, s);
      highest = std::max(highest, s);
    }
    extents.push_back(highest - lowest);
  }
  const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
  std::nth_element(extents.begin(), middle, extents.end());
  return *middle;
}

}  // namespace

std::optional<Finding> implausible_size(const scenario::Node& root, const fem::Model& model) {
  const double size_m = fem::diagonal_of(model.mesh);
  const double mass_kg = mass_of(model);
  const scenario::Node mesh = root.section("fem").section("mesh");
  const double scale = model.params.mesh.length_scale_m;
  const auto finding = [&](const std::string& text) {
    return finding_at(
        mesh, "length_scale_m", "implausible_size",
        fmt::format("the flexible body is {:.4g} m long and has {:.4g} kg. ", size_m, mass_kg) +
            text);
  };
  if (size_m > kLongest_m || mass_kg > kHeaviest_kg) {
    return finding(
        fmt::format("A mesh drawn in millimetres has length_scale_m: {:g}; that would be "
                    "{:.3g} m and {:.3g} kg.",
                    1e-3 * scale, 1e-3 * size_m, 1e-9 * mass_kg));
  }
  if (size_m < kSmallest_m) {
    return finding(
        fmt::format("A mesh that is in metres already has length_scale_m: 1; that would "
                    "be {:.3g} m.",
                    size_m / scale));
  }
  return std::nullopt;
}

std::vector<Finding> far_ports(const scenario::Node& root, const fem::Model& model,
                               const MotionSet& origins) {
  std::vector<Finding> findings;
  if (model.params.nodal || origins.size() != model.ports.size()) return findings;
  const std::vector<scenario::Node> nodes = root.list("ports");
  for (std::size_t i = 0; i < model.ports.size(); ++i) {
    const std::vector<int>& set = model.ports[i].nodes;
    const Eigen::Vector3d& p = origins[i].p_WP;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (int node : set) {
      nearest_m = std::min(nearest_m, (model.mesh.X[static_cast<std::size_t>(node)] - p).norm());
    }
    const double own_m = diagonal_of(model.mesh, set);
    // A single node has no extent.
    const double extent_m = own_m > 0.0 ? own_m : fem::diagonal_of(model.mesh);
    if (nearest_m <= kFarPort * extent_m) continue;
    findings.push_back(finding_at(
        nodes.at(i), "", "far_port",
        fmt::format("the origin of port '{}' at ({:.4g}, {:.4g}, {:.4g}) m is {:.3g} m from the "
                    "nearest of its nodes, {:.3g} times their extent of {:.3g} m. Check "
                    "fem.mesh.length_scale_m and position_m of mesh, body and port.",
                    model.ports[i].name, p.x(), p.y(), p.z(), nearest_m, nearest_m / extent_m,
                    extent_m)));
  }
  return findings;
}

double Slenderness::excess() const {
  const double height_m = thickness_m / elements_across;
  const double a = element_length_m / height_m;
  return (1.4 + 1.2 * a * a) / (elements_across * elements_across);
}

Slenderness slenderness_of(const fem::TetMesh& mesh) {
  const Eigen::Matrix3d axes = principal_axes(mesh);
  const Eigen::Vector3d across = thinnest_direction(mesh, axes);
  const double thickness_m = extent(mesh, across);
  return {.length_m = extent(mesh, axes.col(2)),
          .thickness_m = thickness_m,
          .elements_across = thickness_m / median_extent(mesh, across),
          .element_length_m = median_extent(mesh, axes.col(2))};
}

std::optional<Finding> coarse_in_bending(const scenario::Node& root, const fem::Model& model) {
  if (model.mesh.second_order()) return std::nullopt;
  const Slenderness s = slenderness_of(model.mesh);
  if (s.length_m < kSlender * s.thickness_m || s.excess() <= kMostExcess) return std::nullopt;
  const double times = 1.0 + s.excess();
  return finding_at(
      root.section("fem").section("mesh"), "order", "coarse_in_bending",
      fmt::format("{:.2g} first-order tetrahedra across the thinnest extent of {:.3g} m (length "
                  "{:.3g} m): where the body bends it is about {:.{}f} times too stiff. Set "
                  "fem.mesh.order: 2, or refine the mesh.",
                  s.elements_across, s.thickness_m, s.length_m, times, times < 10.0 ? 1 : 0));
}

}  // namespace tandem::orchestrator

#include "fem_process/ancf/beam_params.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {
namespace {

/// Chains run with a few percent of difference, before and after settling; a tooth is 10 % of ten.
constexpr double kPitchTolerance = 0.05;

/// Depth of the deepest of the points of a face that the contact looks at.
struct Overlap {
  double depth_m = 0.0;
  int element = 0;
};

template <class Depth>
Overlap deepest(const BeamParams& params, Face face, const Depth& depth) {
  const BeamMesh& mesh = params.model.mesh;
  const BeamSection& section = params.model.section;
  const double z = (face == Face::Inner ? -0.5 : 0.5) * section.height_m;
  Overlap worst;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamVectors vectors = mesh.gather(e, mesh.q0);
    const double length = mesh.elements[static_cast<std::size_t>(e)].length_m;
    for (double xi : gauss_rule(params.grid.along).point) {
      const double at = depth(Eigen::Vector3d(vectors * shape_values(length, xi, 0.0, z)));
      if (at > worst.depth_m) worst = {at, e};
    }
  }
  return worst;
}

void require_shallow(const Overlap& overlap, double height_m, const std::string& who,
                     const std::string& remedy) {
  require(overlap.depth_m <= 0.5 * height_m,
          fmt::format("fem: {} reaches {:.3g} m into the band at element {} before the first step, "
                      "at most half the band's height, {:.3g} m, is allowed. {}",
                      who, overlap.depth_m, overlap.element, 0.5 * height_m, remedy));
}

/// Whether the section at the end of an element is also that of the next one's beginning.
bool shares_section(const BeamElement& element, const BeamElement& next) {
  const auto vector_of = [](const BeamElement& e, int slot) {
    const auto term = std::find_if(e.terms.begin(), e.terms.end(),
                                   [slot](const Term& t) { return t.slot == slot; });
    return term->vector;
  };
  constexpr int kFirstNormal = 3, kLastNormal = 7;
  return vector_of(element, kLastNormal) == vector_of(next, kFirstNormal);
}

}  // namespace

std::optional<std::string> bending_warning(const BeamModel& model) {
  constexpr double kMost = 0.05;
  if (model.strain == Strain::Assumed) return std::nullopt;
  const BeamMesh& mesh = model.mesh;
  double worst = 0.0, worst_angle = 0.0;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const BeamElement& next = mesh.elements[(e + 1) % mesh.elements.size()];
    if (mesh.elements.size() > 1 && !shares_section(mesh.elements[e], next) &&
        e + 1 < mesh.elements.size()) {
      return std::nullopt;
    }
    const BeamVectors vectors = mesh.gather(static_cast<int>(e), mesh.q0);
    const Eigen::Vector3d first = vectors.col(3), last = vectors.col(7);
    const double angle = std::atan2(first.cross(last).norm(), first.dot(last));
    const double slenderness = mesh.elements[e].length_m / model.section.height_m;
    const double part = std::pow(angle * slenderness, 2) / 10.0;
    if (part > worst) {
      worst = part;
      worst_angle = angle;
    }
  }
  if (worst <= kMost) return std::nullopt;
  const auto n = static_cast<double>(mesh.elements.size());
  return fmt::format(
      "fem.ancf.chain.elements: {} elements bend by up to {:.3g} rad each as the chain lies, and "
      "locking in thickness makes them {:.2g} times as stiff in bending as the band is. Set "
      "fem.ancf.integration.strain: assumed; {} elements or more keep it below {:g} %, too.",
      mesh.elements.size(), worst_angle, 1.0 + worst,
      static_cast<long>(std::ceil(n * std::pow(worst / kMost, 0.25))), 100.0 * kMost);
}

void check_teeth(const BeamParams& params) {
  const BeamMesh& mesh = params.model.mesh;
  const double chord =
      (mesh.q0.segment<3>(3 * mesh.end_position[1]) - mesh.q0.segment<3>(3 * mesh.end_position[0]))
          .norm();
  for (const Wheel& wheel : params.wheels) {
    if (!wheel.teeth) continue;
    const double radius = wheel.radius_m + 0.5 * params.model.section.height_m;
    const double link = chord / radius;
    const double seat = 2.0 * std::numbers::pi / wheel.teeth->count;
    const double fitting = 2.0 * std::numbers::pi / link;
    require(std::abs(link / seat - 1.0) <= kPitchTolerance,
            fmt::format(
                "fem: the {} teeth at port '{}' do not match the links: a seat takes {:.4f} rad "
                "and a link of {:.5f} m on the radius {:.4f} m takes {:.4f} rad, more than {:g} "
                "% apart. Use {} teeth, or links of {:.5f} m (fem.ancf.chain.elements, "
                "fem.ancf.path).",
                wheel.teeth->count, params.ports[static_cast<std::size_t>(wheel.port)], seat, chord,
                radius, link, 100.0 * kPitchTolerance, std::lround(fitting), seat * radius));
  }
}

void check_overlap(const BeamParams& params, const MotionSet& motions) {
  const double height = params.model.section.height_m;
  for (const Wheel& wheel : params.wheels) {
    const Motion& motion = motions[static_cast<std::size_t>(wheel.port)];
    const Eigen::Vector3d axis = motion.q_WP * Eigen::Vector3d::UnitY();
    const Overlap overlap = deepest(params, wheel.face, [&](const Eigen::Vector3d& r) {
      const Eigen::Vector3d d = r - motion.p_WP;
      return wheel.radius_m - (d - d.dot(axis) * axis).norm();
    });
    require_shallow(
        overlap, height,
        fmt::format("the wheel at port '{}' (radius {:.4g} m)",
                    params.ports[static_cast<std::size_t>(wheel.port)], wheel.radius_m),
        "Move its body or the chain's path, or change its radius_m; the radii of a loop are those "
        "of the centre line.");
  }
  for (const Ground& ground : params.grounds) {
    const Overlap overlap = deepest(params, ground.face, [&](const Eigen::Vector3d& r) {
      return ground.normal.dot(ground.point_m - r);
    });
    require_shallow(overlap, height, "the ground",
                    "Raise the chain's path or lower fem.ancf.grounds.point_m.");
  }
}

}  // namespace tandem::fem::ancf

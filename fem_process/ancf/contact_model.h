#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fem_process/ancf/beam_kernel.h"
#include "fem_process/ancf/beam_mesh.h"
#include "fem_process/ancf/contact_law.h"
#include "protocol/contract/port.h"

namespace tandem::fem::ancf {

/// Which long face of the band a surface touches: z = −h/2 or z = +h/2.
enum class Face { Inner, Outer };

/// A rigid cylinder about the y axis of a port's frame.
struct Wheel {
  int port = 0;
  double radius_m = 0.0;
  Face face = Face::Inner;
  ContactParams contact;
  std::optional<Teeth> teeth;
};

/// A half-space at rest.
struct Ground {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  Face face = Face::Outer;
  ContactParams contact;
};

/// Gauss points along and across each face of an element.
struct ContactGrid {
  int along = 8, across = 2;
};

/// What the surfaces feel.
struct ContactSums {
  WrenchSet wheels;                                  ///< on the wheels, about the ports' origins
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();  ///< on the grounds (N)
  double stored_J = 0.0;                             ///< ½ k d² of all points in contact
  double loss_W = 0.0;                               ///< taken by damping and friction
  double depth_m = 0.0;                              ///< largest, of the wheels
  double ground_depth_m = 0.0;
  int seated_pins = 0;  ///< pins that press on a tooth
};

/// A point of the band in contact with a wheel: the force on it and its derivatives.
struct Touch {
  int element = 0;
  int port = 0;
  Eigen::Matrix<double, kVectors, 1> shape;  ///< shape values of the point
  Eigen::Vector3d r, v;                      ///< its position and velocity
  Eigen::Vector3d force;                     ///< N
  Eigen::Matrix3d by_place;                  ///< ∂/∂d at fixed u and w (N/m), d = r − p_WP
  Eigen::Matrix3d by_approach;               ///< ∂/∂u (N s/m), u = v − v_WP
  Eigen::Matrix3d by_slip;                   ///< ∂/∂w (N s/m), w = u − w_WP × d
};

/// Contact of a band with wheels and grounds: tractions at a grid of points of both faces, teeth at
/// the ends of the elements. Every point asks every surface of its face, so one may touch several.
class ContactModel {
 public:
  ContactModel() = default;
  ContactModel(const BeamMesh& mesh, const BeamSection& section, std::vector<Wheel> wheels,
               std::vector<Ground> grounds, const ContactGrid& grid);

  /// Subtracts the contact forces from `elements.force` and, with θ, ∂f/∂r + θ ∂f/∂v from
  /// `elements.tangent`. `friction` false: pressures and teeth alone. Sums in a fixed order.
  void add(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const MotionSet& motions,
           bool friction, std::optional<double> theta, ElementArrays& elements,
           ContactSums& sums) const;

  /// All points in contact with wheels, in the order of the sums.
  [[nodiscard]] std::vector<Touch> touches(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                           const MotionSet& motions, bool friction) const;

  /// Mean pressure of each element's faces by wheels and grounds (Pa).
  [[nodiscard]] std::vector<double> pressures(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                              const MotionSet& motions) const;

  [[nodiscard]] const std::vector<Wheel>& wheels() const { return wheels_; }
  [[nodiscard]] const std::vector<Ground>& grounds() const { return grounds_; }
  [[nodiscard]] bool empty() const { return wheels_.empty() && grounds_.empty(); }

 private:
  struct Element;
  /// Where a traction acts: shape values and stress-free area.
  struct Patch {
    Eigen::Matrix<double, kVectors, 1> shape;
    double area_m2 = 0.0;
  };
  template <class Visit>
  void for_each_touch(int element, const Element& vectors, const MotionSet& motions,
                      bool derivatives, bool friction, const Visit& visit) const;
  void add_teeth(int element, const Element& vectors, const MotionSet& motions,
                 std::optional<double> theta, ElementArrays& elements, ContactSums& sums) const;
  [[nodiscard]] Element gather(int element, const Eigen::VectorXd& q,
                               const Eigen::VectorXd& v) const;
  [[nodiscard]] bool near(const Wheel& wheel, const MotionSet& motions, int element,
                          const Element& vectors) const;
  [[nodiscard]] bool near(const Ground& ground, int element, const Element& vectors) const;

  const BeamMesh* mesh_ = nullptr;
  BeamSection section_;
  std::vector<Wheel> wheels_;
  std::vector<Ground> grounds_;
  std::size_t points_ = 0;      ///< of a face of an element
  std::vector<Patch> patches_;  ///< inner face, then outer face, of each element
};

}  // namespace tandem::fem::ancf

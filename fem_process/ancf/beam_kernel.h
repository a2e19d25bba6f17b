#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fem_process/ancf/beam_mesh.h"
#include "fem_process/ancf/lanes.h"
#include "fem_process/ancf/point_law.h"

namespace tandem::fem::ancf {

/// Gauss points along x, y and z; along x those of Strain::Compatible.
struct GaussOrder {
  int x = 4, y = 2, z = 2;
};

/// Forces and tangents per element: 24 numbers and 24 × 24 row by row, of all elements in turn.
struct ElementArrays {
  std::vector<double> force;
  std::vector<double> tangent;
  [[nodiscard]] double* force_of(int element) {
    return force.data() + static_cast<std::ptrdiff_t>(element) * kCoordinates;
  }
  [[nodiscard]] double* tangent_of(int element) {
    return tangent.data() + static_cast<std::ptrdiff_t>(element) * kCoordinates * kCoordinates;
  }
};

/// Alignment of lanes in memory that AVX2 code reads: the build's own target may ask for less.
inline constexpr std::size_t kLaneAlignment = kLanes * sizeof(double);

/// Which strains of the elements the energy is made of.
enum class Strain {
  /// C at the nodes and halfway along the element, where Lobatto's rule integrates it, with C_yy,
  /// C_zz and C_yz linear between the nodes: assumed natural strains [Betsch & Stein 1995]. An
  /// element that bends by θ has none of the strains there that FᵀF holds and bending does not:
  /// across −θ²/8 in its middle, shear of order θ³ and stretch of order θ⁴ between the three
  /// points.
  Assumed,
  Compatible  ///< C = FᵀF at Gauss points, as written
};

/// The coordinates of four elements.
struct LaneCoordinates {
  alignas(kLaneAlignment) Lanes at[kCoordinates];
};

/// Elastic and viscous forces of all beam elements, four elements side by side.
///   f_a = ∫ P ∇s_a dV,   K_ab,ik = ∫ ∂_J s_a (∂P_iJ/∂F_kL + θ ∂P_iJ/∂F'_kL) ∂_L s_b dV
/// F = J_e J₀⁻¹ with J_e = Σ e_a ⊗ ∇s_a, the columns of F in the axes of the stress-free section
/// (StressFree). Because s_a is linear in y and z, F at a station x depends
/// on five vectors only, r_x, r_y, r_z of the axis and the derivatives of the last two along x: the
/// points of a section are summed up to resultants that belong to these, then spread to the nodes.
/// With assumed strains f = ∂/∂e ∫ W(C) dV, C as in section_measures.h, viscous stresses by its
/// rate.
class BeamKernel {
 public:
  BeamKernel(const BeamMesh& mesh, const BeamSection& section, const RuleLaws& laws,
             const GaussOrder& order, Strain strain = Strain::Assumed);

  /// Writes the forces which the elements need (N, N m), all of them (restoring: +∂U/∂e).
  /// Returns the number of elements with a point that is turned inside out.
  int forces(const Eigen::VectorXd& q, const Eigen::VectorXd& v, ElementArrays& out) const;
  /// Also the tangents ∂f/∂e + θ ∂f/∂e' (θ in 1/s).
  int tangents(const Eigen::VectorXd& q, const Eigen::VectorXd& v, double theta,
               ElementArrays& out) const;
  /// Elastic energy (J).
  [[nodiscard]] double energy(const Eigen::VectorXd& q) const;

  /// A point of a section.
  struct Point {
    double y = 0.0, z = 0.0;
    double weight = 0.0;  ///< area (m²)
  };
  struct Station {
    double xi = 0.0;
    double weight = 0.0;  ///< part of the length
  };
  struct Rule {
    PointLaw law;
    std::vector<Station> stations;
    std::vector<Point> points;
  };
  /// StressFree of a point, per lane.
  struct Reference {
    alignas(kLaneAlignment) LaneMatrix inverse;
    alignas(kLaneAlignment) Lanes determinant;
  };
  struct Batch {
    int first = 0;  ///< element of lane 0
    int count = 0;
    alignas(kLaneAlignment) Lanes length;
    std::vector<Reference>
        reference;  ///< per point of all rules, in the order of use; empty: J₀ = I
  };

 private:
  void gather(const Eigen::VectorXd& q, std::vector<LaneCoordinates>& lanes) const;
  [[nodiscard]] std::vector<Reference> references(const BeamMesh& mesh, const Batch& batch) const;

  struct SlotTerm {
    int target = 0;  ///< index of the double in the lanes array
    int vector = 0;
    double factor = 1.0;
  };
  Strain strain_;
  std::vector<SlotTerm> terms_;
  std::vector<Rule> rules_;
  std::vector<Batch> batches_;
};

}  // namespace tandem::fem::ancf

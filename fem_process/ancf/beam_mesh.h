#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fem_process/ancf/beam_shape.h"

namespace tandem::fem::ancf {

/// One term of a linear connection: e_slot = Σ factor q_vector. Vectors of three unknowns each.
struct Term {
  int slot = 0;
  int vector = 0;
  double factor = 1.0;
};

struct BeamElement {
  double length_m = 0.0;  ///< parameter length l: x in [0, l]
  std::vector<Term> terms;
};

/// How the end of an element is joined to the beginning of the next.
enum class Joint {
  Rigid,  ///< all twelve coordinates shared (C1)
  Pin,    ///< r and the gradient along the pin's axis shared (eqs. (7), (8) of JC11): five
          ///< deformation modes and the turning about the axis stay free
  Ball,   ///< r shared
};

/// Place of an end of an element in W: r (m) and [r_x r_y r_z].
struct EndFrame {
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradients = Eigen::Matrix3d::Identity();
};

/// Beams and their connections, imposed once by a constant projection e = B q (eqs. (7)–(9) of
/// JC11): no multiplier and no constraint equation is left in the equations of motion.
struct BeamMesh {
  std::vector<BeamElement> elements;
  /// Stress-free vectors of each element (m); empty: straight, of its parameter length, J₀ = I.
  std::vector<BeamVectors> reference;
  int vectors = 0;                ///< unknowns are 3 per vector
  Eigen::VectorXd q0;             ///< unknowns at t = 0
  std::vector<int> end_position;  ///< vector of r at the ends: element e has 2e and 2e + 1
  std::vector<bool> fixed;        ///< per vector: stays at q0

  [[nodiscard]] int unknowns() const { return 3 * vectors; }
  /// The vectors e_a of an element at the unknowns q.
  [[nodiscard]] BeamVectors gather(int element, const Eigen::VectorXd& q) const;
};

/// What a chain of elements is made of: `ends` has two frames per element.
struct Chain {
  std::vector<double> lengths_m;
  std::vector<EndFrame> ends;
  bool closed = false;
  Joint joint = Joint::Rigid;
  /// Axis of the pins in the parameters (x, y, z) of both elements, of unit length. Unless it is
  /// (0, 1, 0) the gradients are taken along other lines, [r_u r_v r_w] = [r_x r_y r_z] A with
  /// A = [a₁ axis a₃] orthonormal, and r_v is shared (eq. (9) of JC11).
  Eigen::Vector3d pin_axis = Eigen::Vector3d::UnitY();
  bool curved_reference = false;  ///< the given frames are stress-free
};
[[nodiscard]] BeamMesh join(const Chain& chain);

enum class Support {
  Free,
  Hinged,  ///< r is held
  Clamped  ///< all twelve coordinates are held
};
/// Holds one end of an open chain.
void support(BeamMesh& mesh, bool at_end, Support kind);

}  // namespace tandem::fem::ancf

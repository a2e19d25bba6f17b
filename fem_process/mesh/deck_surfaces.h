#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "fem_process/mesh/deck_elements.h"
#include "fem_process/mesh/raw_mesh.h"

namespace tandem::fem {

/// An element that is no tetrahedron, by its number in the whole mesh.
struct OtherElement {
  DeckShape shape = DeckShape::Other;
  std::vector<std::int64_t> nodes;
};
using OtherElements = std::unordered_map<std::int64_t, OtherElement>;

/// Faces and nodes of elements for the sets of a mesh.
class DeckSurfaces {
 public:
  DeckSurfaces(RawMesh& raw, const OtherElements& others) : raw_(raw), others_(others) {}

  /// The faces S1 … S4 of tetrahedra, triangles that are elements (SPOS, SNEG), or, with no face
  /// named, triangles and what faces of the tetrahedra belong to no second one of the mesh.
  void add(const std::vector<std::int64_t>& elements, const std::string& face, int line,
           RawMesh::Set& set);
  /// A triangle or line that is an element.
  void add_other(std::int64_t tag, RawMesh::Set& set);
  /// All nodes of an element.
  void add_nodes(std::int64_t tag, int line, std::vector<std::int64_t>& nodes) const;
  /// Says in the mesh's notes what faces were left out.
  void note();

 private:
  using Corners = std::array<std::int64_t, 3>;  // ascending

  [[nodiscard]] const RawMesh::Tetrahedron* tet(std::int64_t tag, int line) const;
  void add_face(const RawMesh::Tetrahedron& tet, std::size_t face, RawMesh::Set& set) const;
  void count_faces();

  RawMesh& raw_;
  const OtherElements& others_;
  std::map<Corners, int> faces_;  ///< how many tetrahedra have one; filled when needed
  std::size_t no_faces_ = 0;      ///< faces of elements that are not read
  std::size_t other_order_ = 0;   ///< triangles of another order than the tetrahedra
};

}  // namespace tandem::fem

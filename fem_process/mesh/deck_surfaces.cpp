#include "fem_process/mesh/deck_surfaces.h"

#include <algorithm>

#include "fem_process/mesh/tet10.h"

namespace tandem::fem {
namespace {

/// Corners of faces S1 … S4 of C3D4 and C3D10, each seen from outside.
constexpr std::size_t kFaces[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};

void insert(const RawMesh::Triangle& triangle, RawMesh::Set& set) {
  set.triangles.push_back(triangle);
  set.nodes.insert(triangle.nodes.begin(), triangle.nodes.end());
  if (triangle.second_order) set.nodes.insert(triangle.mids.begin(), triangle.mids.end());
}

std::array<std::int64_t, 3> corners_of(const RawMesh::Tetrahedron& tet, std::size_t face) {
  std::array<std::int64_t, 3> corners{};
  for (std::size_t k = 0; k < 3; ++k) corners[k] = tet.nodes[kFaces[face][k]];
  std::sort(corners.begin(), corners.end());
  return corners;
}

}  // namespace

const RawMesh::Tetrahedron* DeckSurfaces::tet(std::int64_t tag, int line) const {
  const auto found = raw_.tet_index.find(tag);
  if (found != raw_.tet_index.end()) return &raw_.tets[static_cast<std::size_t>(found->second)];
  if (others_.count(tag) == 0) {
    raw_.fail(line, "element " + std::to_string(tag) + " is not defined. Correct the set.");
  }
  return nullptr;
}

void DeckSurfaces::add_face(const RawMesh::Tetrahedron& tet, std::size_t face,
                            RawMesh::Set& set) const {
  RawMesh::Triangle triangle{.second_order = tet.second_order};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t corner = kFaces[face][k];
    triangle.nodes[k] = tet.nodes[corner];
    triangle.mids[k] = tet.mids[edge_between(corner, kFaces[face][(k + 1) % 3])];
  }
  insert(triangle, set);
}

void DeckSurfaces::count_faces() {
  if (!faces_.empty()) return;
  for (const RawMesh::Tetrahedron& tet : raw_.tets) {
    for (std::size_t face = 0; face < 4; ++face) ++faces_[corners_of(tet, face)];
  }
}

void DeckSurfaces::add(const std::vector<std::int64_t>& elements, const std::string& face, int line,
                       RawMesh::Set& set) {
  const bool of_shell = face == "SPOS" || face == "SNEG";
  if (!face.empty() && !of_shell &&
      (face.size() != 2 || face[0] != 'S' || face[1] < '1' || face[1] > '6')) {
    raw_.fail(line, "face '" + face + "' is not one of S1, S2, S3, S4.");
  }
  if (face.empty()) count_faces();
  for (std::int64_t tag : elements) {
    const RawMesh::Tetrahedron* const solid = tet(tag, line);
    if (solid == nullptr) {
      if (face.empty() || of_shell) {
        add_other(tag, set);
      } else {
        ++no_faces_;
      }
      continue;
    }
    if (face.empty()) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (faces_.at(corners_of(*solid, k)) == 1) add_face(*solid, k, set);
      }
      continue;
    }
    if (of_shell || face[1] > '4') {
      raw_.fail(line, "face '" + face + "' of the tetrahedron " + std::to_string(tag) +
                          " is not one of S1, S2, S3, S4.");
    }
    add_face(*solid, static_cast<std::size_t>(face[1] - '1'), set);
  }
}

void DeckSurfaces::add_other(std::int64_t tag, RawMesh::Set& set) {
  const OtherElement& other = others_.at(tag);
  const auto& n = other.nodes;
  if (other.shape == DeckShape::Line && n.size() == 2) set.lines.push_back({n[0], n[1]});
  if (other.shape != DeckShape::Triangle) {
    set.nodes.insert(n.begin(), n.end());
    return;
  }
  RawMesh::Triangle triangle{.nodes = {n[0], n[1], n[2]}, .second_order = n.size() == 6};
  if (triangle.second_order) triangle.mids = {n[3], n[4], n[5]};
  if (triangle.second_order == raw_.second_order()) {
    insert(triangle, set);
    return;
  }
  ++other_order_;
  set.nodes.insert(n.begin(), n.end());
}

void DeckSurfaces::add_nodes(std::int64_t tag, int line, std::vector<std::int64_t>& nodes) const {
  const RawMesh::Tetrahedron* const solid = tet(tag, line);
  if (solid == nullptr) {
    const auto& other = others_.at(tag).nodes;
    nodes.insert(nodes.end(), other.begin(), other.end());
    return;
  }
  nodes.insert(nodes.end(), solid->nodes.begin(), solid->nodes.end());
  if (solid->second_order) nodes.insert(nodes.end(), solid->mids.begin(), solid->mids.end());
}

void DeckSurfaces::note() {
  if (no_faces_ > 0) {
    raw_.notes.push_back(std::to_string(no_faces_) +
                         " faces in *SURFACE of elements that are not read were left out");
  }
  if (other_order_ > 0) {
    raw_.notes.push_back(std::to_string(other_order_) +
                         " triangles in sets are of another order than the tetrahedra: these sets "
                         "have their nodes, but are no surfaces");
  }
}

}  // namespace tandem::fem

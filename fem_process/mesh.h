#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "protocol/scenario/node.h"

namespace tandem::fem {

/// Indices of a triangle's or tet's corners in TetMesh::X.
using Triangle = std::array<int, 3>;
using Tet = std::array<int, 4>;

/// A named part of a mesh: a Gmsh physical group or an Abaqus *NSET, *ELSET or *SURFACE.
struct NodeSet {
  std::vector<int> nodes;           ///< ascending node indices, each once
  std::vector<Triangle> triangles;  ///< when the set is a surface
  int line = 0;                     ///< where the mesh file defines it
};

/// Linear tetrahedra with named node sets, in metres and world axes W. Every node belongs to a tet;
/// every tet has positive volume.
struct TetMesh {
  std::filesystem::path file;
  std::vector<Eigen::Vector3d> X;       ///< reference positions (m)
  std::vector<std::int64_t> node_tags;  ///< numbers of the nodes in the file
  std::vector<Tet> tets;
  std::vector<std::int64_t> element_tags;  ///< numbers of the tets in the file
  std::map<std::string, NodeSet> sets;
  std::vector<std::string> notes;  ///< what the reader passed over

  [[nodiscard]] int nodes() const { return static_cast<int>(X.size()); }
};

/// Which file, and where it stands in the world: X_W = position + R(orientation) scale X_file.
struct MeshParams {
  std::filesystem::path file;
  double length_scale_m = 1.0;  ///< metres per unit of the file
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// A node set's name and where the scenario mentions it.
struct SetName {
  std::string name;
  scenario::Place place{};
};

/// Reads a Gmsh .msh (4.1 ASCII) or an Abaqus .inp, by extension, and places it. Throws a Usage
/// error "file:line: what. Remedy.".
[[nodiscard]] TetMesh read_mesh(const MeshParams& params);

/// The named set. Throws a Usage error at the scenario's place when the mesh has no such set, with
/// the sets it has, or when no tet touches the set.
[[nodiscard]] const NodeSet& find_set(const TetMesh& mesh, const SetName& name);

/// Signed volume (m³): positive when corners 1, 2, 3 are counter-clockwise seen from corner 4's
/// opposite side, the convention of Gmsh and Abaqus.
[[nodiscard]] double signed_volume(const TetMesh& mesh, const Tet& tet);

/// Diagonal (m) of the bounding box.
[[nodiscard]] double diagonal_of(const TetMesh& mesh);

/// Area (m²) of a triangle of the mesh.
[[nodiscard]] double area(const TetMesh& mesh, const Triangle& triangle);

}  // namespace tandem::fem

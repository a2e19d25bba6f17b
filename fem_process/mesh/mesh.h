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

/// Indices of the nodes on a tet's edges, in the order of kTetEdges.
using TetMids = std::array<int, 6>;

/// Corners at the ends of a tet's edges, in the order of Abaqus' and VTK's second-order tets.
/// (Gmsh has the last two the other way round.)
inline constexpr std::size_t kTetEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// A named part of a mesh: a Gmsh physical group or an Abaqus *NSET, *ELSET or *SURFACE.
struct NodeSet {
  std::vector<int> nodes;               ///< ascending node indices, each once
  std::vector<Triangle> triangles;      ///< when the set is a surface: corners
  std::vector<Triangle> triangle_mids;  ///< second order: nodes on their edges 01, 12, 20
  std::vector<int> tets;                ///< when the set is a volume: ascending, each once
  std::string where;                    ///< "file:line" that defines it
};

/// Tetrahedra of first or second order with named node sets, in metres and world axes W. Every node
/// belongs to a tet; every tet has a positive Jacobian.
struct TetMesh {
  std::filesystem::path file;
  std::vector<Eigen::Vector3d> X;          ///< reference positions (m)
  std::vector<std::int64_t> node_tags;     ///< numbers of the nodes in the file
  std::vector<Tet> tets;                   ///< corners
  std::vector<TetMids> mids;               ///< second order: one per tet, else empty
  std::vector<std::int64_t> element_tags;  ///< numbers of the tets in the file
  std::map<std::string, NodeSet> sets;
  std::vector<std::string> notes;  ///< what the reader passed over

  [[nodiscard]] int nodes() const { return static_cast<int>(X.size()); }
  [[nodiscard]] bool second_order() const { return !mids.empty(); }
  /// All nodes of an element: 4 corners and, of second order, 6 mid nodes.
  [[nodiscard]] std::vector<int> element(std::size_t e) const;
};

/// Which file, and where it stands in the world: X_W = position + R(orientation) scale X_file.
struct MeshParams {
  std::filesystem::path file;
  double length_scale_m = 1.0;  ///< metres per unit of the file
  int order = 0;                ///< of the elements: 1, 2, or 0 = as the file has them
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  std::string checksum;  ///< see mesh_checksum; empty = not compared
};

/// A node set's name and where the scenario mentions it.
struct SetName {
  std::string name;
  scenario::Place place{};

  /// "file:line:column: ", the beginning of a message about it.
  [[nodiscard]] std::string where() const {
    return (place.file.empty() ? "fem" : place.text()) + ": ";
  }
};
[[nodiscard]] std::vector<std::string> names_of(const std::vector<SetName>& sets);

/// Fingerprint of the bytes of a mesh file and of those that it includes (FNV-1a, 16 hexadecimal
/// digits); empty when one cannot be read, which reading the mesh tells better.
[[nodiscard]] std::string mesh_checksum(const std::filesystem::path& file);

/// Reads a Gmsh .msh (2 to 4.1) or an Abaqus .inp, by extension, and places it; order 2 raises
/// first-order tets by raise_to_second_order(). Throws a Usage error "file:line: what. Remedy.".
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

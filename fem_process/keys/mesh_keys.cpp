#include "fem_process/keys/mesh_keys.h"

#include <utility>

namespace tandem::fem {

using scenario::Key;
using scenario::Node;
using scenario::Section;

Key mesh_key() {
  Section mesh;
  mesh.title = "Mesh";
  mesh.doc = "Which mesh, and where it stands: X_W = position + R(orientation) scale X_file.";
  mesh.keys = {
      scenario::path("file").must().doc_is(
          "Mesh of tetrahedra of first or second order: Gmsh .msh (2 to 4.1, text or binary; "
          "physical groups are the sets) or Abaqus .inp (also CalculiX, PrePoMax, FreeCAD, CGX; "
          "flat or in parts and instances; *NSET, *ELSET and *SURFACE are the sets)."),
      scenario::integer("order").between(1, 2).doc_is(
          "Order of the tetrahedra. 2 puts a node in the middle of every edge of a "
          "first-order mesh, which takes away its false stiffness in bending; 1 demands a "
          "first-order mesh. Left out: as the file has them."),
      scenario::real("length_scale_m", "m")
          .above(0)
          .by_default("1")
          .doc_is("Metres per unit of the mesh file: 0.001 for a mesh in millimetres."),
      scenario::reals("position_m", "m")
          .count(3)
          .by_default("[0, 0, 0]")
          .doc_is("Where the mesh file's origin stands in world axes at t = 0."),
      scenario::reals("orientation_wxyz", "")
          .count(4)
          .of_unit_length()
          .by_default("[1, 0, 0, 0]")
          .doc_is("Rotation from the mesh file's axes to world axes at t = 0 as a quaternion."),
      scenario::text("checksum")
          .doc_is("Fingerprint of the mesh file and of those that it includes (16 hexadecimal "
                  "digits). A run writes it into its resolved scenario, so that a replay with "
                  "another mesh is refused; no need to write it by hand."),
  };
  return scenario::section("mesh", std::move(mesh)).must().doc_is("The mesh and its placement.");
}

MeshParams read_mesh_params(const Node& node) {
  return {.file = node.path("file"),
          .length_scale_m = node.real("length_scale_m"),
          .order = node.has("order") ? static_cast<int>(node.integer("order")) : 0,
          .position_m = node.vector3("position_m"),
          .orientation = node.quaternion_wxyz("orientation_wxyz"),
          .checksum = node.has("checksum") ? node.text("checksum") : ""};
}

}  // namespace tandem::fem

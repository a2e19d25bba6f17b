#include "fem_process/keys/material_keys.h"

#include <string>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

using scenario::Key;
using scenario::Node;
using scenario::Section;

constexpr const char* kIsotropic = "isotropic";
constexpr const char* kOrthotropic = "orthotropic";

void check_material(const Node& node) {
  if (node.text("kind") == kOrthotropic &&
      !material_axes(node.vector3("axis_1"), node.vector3("axis_2"))) {
    node.fail("axis_2",
              "is zero or parallel to axis_1. Give a vector in the plane of the material "
              "axes 1 and 2.");
  }
  const std::string defect = defect_of(read_material(node, Eigen::Matrix3d::Identity()));
  if (!defect.empty()) node.fail("", defect);
}

Section material_section() {
  Section material;
  material.title = "Material";
  material.doc =
      "Linear elastic material: stress and strain are those of the formulation. An orthotropic one "
      "has three axes at right angles, which turn with the mesh and with the elements.";
  const auto orthotropic = [](const char* name, const char* unit, const char* doc) {
    return scenario::reals(name, unit)
        .must()
        .count(3)
        .only_when("kind", {kOrthotropic})
        .doc_is(doc);
  };
  const auto axis = [](const char* name, const char* value, const char* doc) {
    return scenario::reals(name, "")
        .count(3)
        .only_when("kind", {kOrthotropic})
        .by_default(value)
        .doc_is(doc);
  };
  material.keys = {
      scenario::choice("kind", {kIsotropic, kOrthotropic})
          .by_default(kIsotropic)
          .doc_is("Equal in all directions, or different along three axes (composites, wood)."),
      scenario::real("young_Pa", "Pa")
          .must()
          .above(0)
          .only_when("kind", {kIsotropic})
          .doc_is("Young's modulus."),
      scenario::real("poisson", "")
          .must()
          .above(-1)
          .below(0.5)
          .only_when("kind", {kIsotropic})
          .doc_is("Poisson's ratio."),
      orthotropic("young_123_Pa", "Pa", "Young's moduli E_1, E_2, E_3 along the material axes."),
      orthotropic("poisson_12_13_23", "",
                  "Poisson's ratios ν_12, ν_13, ν_23: ν_ij = −ε_j/ε_i in tension along i; "
                  "ν_ji = ν_ij E_j/E_i."),
      orthotropic("shear_12_13_23_Pa", "Pa", "Shear moduli G_12, G_13, G_23."),
      axis("axis_1", "[1, 0, 0]", "Material axis 1 in the axes of the mesh file, of any length."),
      axis("axis_2", "[0, 1, 0]",
           "A vector in the plane of the material axes 1 and 2, not parallel to axis_1; axis 2 is "
           "its part at right angles to axis 1."),
      scenario::real("density_kg_per_m3", "kg/m³").must().above(0).doc_is("Density."),
  };
  material.check = check_material;
  return material;
}

}  // namespace

Key material_key() {
  return scenario::section("material", material_section())
      .doc_is("The material of all elements, unless `materials` gives it by element set.");
}

Key materials_key() {
  Section material = material_section();
  material.title = "Material of an element set";
  material.keys.insert(
      material.keys.begin(),
      scenario::text("set").must().doc_is(
          "Elements of this material: a Gmsh physical volume or an Abaqus *ELSET."));
  return scenario::sections("materials", std::move(material))
      .at_least_count(1)
      .doc_is("Materials by element set, in place of `material`; every element in exactly one.");
}

void check_materials(const Node& fem) {
  if (fem.has("material") == fem.has("materials")) {
    fem.fail("", std::string(fem.has("material") ? "has both material and materials"
                                                 : "has neither material nor materials") +
                     ". Give `material` for all elements, or `materials` by element set.");
  }
}

Material read_material(const Node& node, const Eigen::Matrix3d& R_WM) {
  Material material;
  material.density_kg_per_m3 = node.real("density_kg_per_m3");
  if (node.text("kind") == kIsotropic) {
    material.young_Pa = node.real("young_Pa");
    material.poisson = node.real("poisson");
    return material;
  }
  const auto axes = material_axes(node.vector3("axis_1"), node.vector3("axis_2"));
  material.orthotropic = {.young_Pa = node.vector3("young_123_Pa"),
                          .poisson = node.vector3("poisson_12_13_23"),
                          .shear_Pa = node.vector3("shear_12_13_23_Pa"),
                          .axes = R_WM * axes.value()};
  return material;
}

std::vector<MaterialSection> read_materials(const Node& fem, const Eigen::Matrix3d& R_WM) {
  std::vector<MaterialSection> sections;
  if (!fem.has("materials")) return sections;
  for (const Node& node : fem.list("materials")) {
    sections.push_back({{node.text("set"), node.place("set")}, read_material(node, R_WM)});
  }
  return sections;
}

}  // namespace tandem::fem

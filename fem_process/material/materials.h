#pragma once

#include <cstddef>
#include <vector>

#include "fem_process/material/material.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// A material and the elements made of it: a Gmsh physical volume or an Abaqus *ELSET.
struct MaterialSection {
  SetName set;
  Material material;
};

/// Which material each element is made of.
struct Materials {
  /// All elements of one material.
  Materials(const Material& material = {}) : list{material} {}  // NOLINT: one is some of them

  std::vector<Material> list;
  std::vector<int> of_element;  ///< indices into `list`; empty: all of the first

  [[nodiscard]] std::size_t index(std::size_t element) const {
    return of_element.empty() ? 0 : static_cast<std::size_t>(of_element[element]);
  }
  [[nodiscard]] const Material& of(std::size_t element) const { return list[index(element)]; }
  /// One isotropic material everywhere.
  [[nodiscard]] bool uniform_isotropic() const {
    return list.size() == 1 && !list.front().orthotropic;
  }
};

/// Gives every element the material of its section. Throws a Usage error with the elements' numbers
/// when some are in no section or in several, or when a section's set holds no elements.
[[nodiscard]] Materials assign_materials(const TetMesh& mesh,
                                         const std::vector<MaterialSection>& sections);

}  // namespace tandem::fem

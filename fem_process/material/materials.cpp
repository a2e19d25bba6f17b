#include "fem_process/material/materials.h"

#include <string>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

/// Numbers named in an error before it says "and n more".
constexpr std::size_t kNamed = 10;

std::string list_of(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (std::size_t k = 0; k < numbers.size() && k < kNamed; ++k) {
    text += (k > 0 ? ", " : "") + std::to_string(numbers[k]);
  }
  if (numbers.size() > kNamed) text += " and " + std::to_string(numbers.size() - kNamed) + " more";
  return text;
}

void assign(const TetMesh& mesh, const std::vector<MaterialSection>& sections, std::size_t s,
            std::vector<int>& of_element) {
  const SetName& name = sections[s].set;
  const NodeSet& set = find_set(mesh, name);
  require(!set.tets.empty(), name.where() + "set '" + name.name +
                                 "' has no tetrahedra to give a material. Name a group of volumes "
                                 "(dimension 3) or an *ELSET.");
  std::vector<std::int64_t> taken;
  int other = 0;
  for (int tet : set.tets) {
    int& material = of_element[static_cast<std::size_t>(tet)];
    if (material >= 0) {
      other = material;
      taken.push_back(mesh.element_tags[static_cast<std::size_t>(tet)]);
    }
    material = static_cast<int>(s);
  }
  require(taken.empty(), name.where() + std::to_string(taken.size()) + " element(s) of '" +
                             name.name + "' have a material of '" +
                             sections[static_cast<std::size_t>(other)].set.name +
                             "' already: " + list_of(taken) +
                             ". Give every element one: choose sets without common elements.");
}

}  // namespace

Materials assign_materials(const TetMesh& mesh, const std::vector<MaterialSection>& sections) {
  Materials materials;
  materials.list.clear();
  materials.of_element.assign(mesh.tets.size(), -1);
  for (std::size_t s = 0; s < sections.size(); ++s) {
    assign(mesh, sections, s, materials.of_element);
    materials.list.push_back(sections[s].material);
  }
  std::vector<std::int64_t> bare;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    if (materials.of_element[e] < 0) bare.push_back(mesh.element_tags[e]);
  }
  require(bare.empty(), "fem: " + std::to_string(bare.size()) + " of " +
                            std::to_string(mesh.tets.size()) + " elements of " +
                            mesh.file.string() + " have no material: " + list_of(bare) +
                            ". Name their sets in fem.materials.");
  return materials;
}

}  // namespace tandem::fem

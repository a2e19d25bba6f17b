// Gmsh MSH 4.1 and 4.0 [Gmsh reference manual, "MSH file format"].
#include "fem_process/mesh/msh_content.h"

namespace tandem::fem {

void MshVersion4::entities() {
  std::size_t n[4];
  for (std::size_t& count : n) count = in_.count("the number of entities", 8, 36);
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::size_t i = 0; i < n[dimension]; ++i) entity(dimension);
  }
}

void MshVersion4::entity(int dimension) {
  const std::int64_t tag = in_.integer("an entity tag");
  const bool is_point = dimension == 0 && in_.version() == 41;
  for (int k = 0; k < (is_point ? 3 : 6); ++k) in_.real("an entity's bounding box");
  const std::size_t groups = in_.count("the number of physical tags", 2, 4);
  for (std::size_t k = 0; k < groups; ++k) {
    const std::int64_t group = in_.integer("a physical tag");
    groups_[{dimension, tag}].push_back(content_.set_name(dimension, group));
  }
  if (dimension == 0) return;
  const std::size_t boundary = in_.count("the number of bounding entities", 2, 4);
  for (std::size_t k = 0; k < boundary; ++k) in_.integer("a bounding entity");
}

MshVersion4::Entity MshVersion4::entity_of_block() {
  Entity entity;
  if (in_.version() == 40) entity.tag = in_.integer("an entity tag");
  entity.dimension = content_.dimension();
  if (in_.version() == 41) entity.tag = in_.integer("an entity tag");
  return entity;
}

void MshVersion4::nodes() {
  const std::size_t blocks = in_.count("the number of node blocks", 8, 20);
  const std::size_t total = in_.count("the number of nodes", 8, 24);
  if (in_.version() == 41) {
    in_.size("the smallest node tag");
    in_.size("the largest node tag");
  }
  for (std::size_t block = 0; block < blocks; ++block) node_block();
  content_.refuse_total(total);
}

/// Version 4.1 has the numbers of a block before its coordinates, 4.0 each before its own.
void MshVersion4::node_block() {
  const int dimension = entity_of_block().dimension;
  const bool parametric = in_.integer("the parametric flag") != 0;
  const std::size_t n = in_.count("the number of nodes in a block", 8, 24);
  const bool before = in_.version() == 41;
  std::vector<std::int64_t> tags(before ? n : 0);
  for (std::int64_t& tag : tags) tag = in_.size("a node tag");
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t tag = before ? tags[i] : in_.integer("a node tag");
    const double x = in_.real("a coordinate");
    const double y = in_.real("a coordinate");
    const double z = in_.real("a coordinate");
    raw_.add_node(tag, {x, y, z}, in_.line());
    for (int k = 0; parametric && k < dimension; ++k) in_.real("a parameter");
  }
}

void MshVersion4::elements() {
  const std::size_t blocks = in_.count("the number of element blocks", 8, 20);
  in_.count("the number of elements", 4, 8);
  if (in_.version() == 41) {
    in_.size("the smallest element tag");
    in_.size("the largest element tag");
  }
  for (std::size_t block = 0; block < blocks; ++block) element_block();
}

void MshVersion4::element_block() {
  const Entity entity = entity_of_block();
  const std::int64_t type = in_.integer("an element type");
  std::vector<std::int64_t> nodes(content_.nodes_of(type));
  const bool wide = in_.version() == 41;
  const std::size_t n = in_.count("the number of elements in a block", 2 * (nodes.size() + 1),
                                  (wide ? 8 : 4) * (nodes.size() + 1));
  const auto groups = groups_.find({entity.dimension, entity.tag});
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t tag = wide ? in_.size("an element tag") : in_.integer("an element tag");
    for (std::int64_t& node : nodes) {
      node = wide ? in_.size("a node tag of an element") : in_.integer("a node tag of an element");
    }
    if (MshContent::is_tet(type)) content_.add_tet(tag, type, nodes);
    if (groups == groups_.end()) continue;
    for (const std::string& name : groups->second) content_.add_to_set(name, tag, type, nodes);
  }
}

}  // namespace tandem::fem

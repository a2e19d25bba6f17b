// Gmsh MSH 2 to 2.2 [Gmsh reference manual, "MSH file format version 2 (Legacy)"].
#include "fem_process/mesh/msh_content.h"

namespace tandem::fem {

void MshVersion2::nodes() {
  const std::size_t n = in_.text_count("the number of nodes", 8, 28);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t tag = in_.integer("a node tag");
    const double x = in_.real("a coordinate");
    const double y = in_.real("a coordinate");
    const double z = in_.real("a coordinate");
    raw_.add_node(tag, {x, y, z}, in_.line());
  }
}

/// Binary files have blocks of elements of one type, each with as many tags.
void MshVersion2::elements() {
  const std::size_t n = in_.text_count("the number of elements", 6, 8);
  for (std::size_t done = 0; done < n;) {
    std::int64_t tag = in_.binary() ? 0 : in_.integer("an element tag");
    const std::int64_t type = in_.integer("an element type");
    nodes_.resize(content_.nodes_of(type));
    const std::size_t block =
        in_.binary()
            ? in_.checked("the number of elements in a block",
                          in_.integer("the number of elements in a block"), 4 * (nodes_.size() + 1))
            : 1;
    if (block > n - done)
      in_.fail("a block has more elements than are left. Write the mesh again.");
    const std::size_t tags =
        in_.checked("the number of tags", in_.integer("the number of tags"), in_.binary() ? 4 : 2);
    for (std::size_t i = 0; i < block; ++i) {
      if (in_.binary()) tag = in_.integer("an element tag");
      std::int64_t group = 0;
      for (std::size_t k = 0; k < tags; ++k) {
        const std::int64_t found = in_.integer("a tag of an element");
        if (k == 0) group = found;
      }
      for (std::int64_t& node : nodes_) node = in_.integer("a node tag of an element");
      element(tag, type, group);
    }
    // A block of none makes no progress: each takes at least its twelve bytes of the file.
    done += block;
  }
}

void MshVersion2::element(std::int64_t tag, std::int64_t type, std::int64_t group) {
  if (MshContent::is_tet(type)) {
    const auto [first, is_new] = tets_.emplace(nodes_, std::pair(tag, group));
    if (is_new || first->second.second == group) {
      content_.add_tet(tag, type, nodes_);
    } else {
      tag = first->second.first;
    }
  }
  if (group == 0) return;
  content_.add_to_set(content_.set_name(MshContent::dimension_of(type), group), tag, type, nodes_);
}

}  // namespace tandem::fem

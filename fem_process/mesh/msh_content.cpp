#include "fem_process/mesh/msh_content.h"

#include <cstdlib>
#include <limits>

namespace tandem::fem {
namespace {

// Gmsh's numbers of element types.
constexpr std::int64_t kPoint = 15, kLine2 = 1, kTriangle3 = 2, kTet4 = 4, kLine3 = 8,
                       kTriangle6 = 9, kTet10 = 11;

}  // namespace

std::size_t MshContent::nodes_of(std::int64_t type) const {
  switch (type) {
    case kPoint:
      return 1;
    case kLine2:
      return 2;
    case kTriangle3:
    case kLine3:
      return 3;
    case kTet4:
      return 4;
    case kTriangle6:
      return 6;
    case kTet10:
      return 10;
    default:
      in_.fail("Gmsh element type " + std::to_string(type) +
               " is not read: only tetrahedra of first or second order with their points, " +
               "lines and triangles are. Mesh with Mesh.ElementOrder = 1 or 2 and without " +
               "recombination or hexahedra.");
  }
}

int MshContent::dimension_of(std::int64_t type) {
  if (type == kPoint) return 0;
  if (type == kLine2 || type == kLine3) return 1;
  return is_tet(type) ? 3 : 2;
}

bool MshContent::is_tet(std::int64_t type) { return type == kTet4 || type == kTet10; }

int MshContent::dimension() {
  const std::int64_t found = in_.integer("a dimension");
  if (found < 0 || found > 3) {
    in_.fail("the dimension " + std::to_string(found) +
             " is not one of 0, 1, 2, 3. Write the mesh again.");
  }
  return static_cast<int>(found);
}

void MshContent::read_names() {
  TextScanner& text = in_.text();
  const std::size_t n = text.count("the number of physical names", 6);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t dimension = text.integer("a dimension");
    if (dimension < 0 || dimension > 3) {
      in_.fail("the dimension " + std::to_string(dimension) +
               " is not one of 0, 1, 2, 3. Write the mesh again.");
    }
    const std::int64_t tag = text.integer("a physical tag");
    const std::string name = text.quoted("a physical name");
    names_[{static_cast<int>(dimension), tag}] = name;
    RawMesh::Set& set = raw_.sets[name];
    if (set.line == 0) set.line = in_.line();
  }
}

std::string MshContent::set_name(int dimension, std::int64_t group) {
  if (group == std::numeric_limits<std::int64_t>::min()) {
    in_.fail("the physical tag " + std::to_string(group) +
             " is out of range. Write the mesh again.");
  }
  const std::int64_t tag = std::abs(group);
  const auto found = names_.find({dimension, tag});
  std::string name = found == names_.end() ? std::to_string(tag) : found->second;
  RawMesh::Set& set = raw_.sets[name];
  if (set.line == 0) set.line = in_.line();
  return name;
}

void MshContent::add_tet(std::int64_t tag, std::int64_t type,
                         const std::vector<std::int64_t>& nodes) {
  RawMesh::Tetrahedron tet{.tag = tag,
                           .nodes = {nodes[0], nodes[1], nodes[2], nodes[3]},
                           .second_order = type == kTet10,
                           .line = in_.line()};
  // Gmsh has the mid nodes of the edges 23 and 13 last, in this order.
  if (tet.second_order) tet.mids = {nodes[4], nodes[5], nodes[6], nodes[7], nodes[9], nodes[8]};
  raw_.add_tet(tet);
}

void MshContent::add_to_set(const std::string& name, std::int64_t tag, std::int64_t type,
                            const std::vector<std::int64_t>& nodes) {
  RawMesh::Set& set = raw_.sets[name];
  set.nodes.insert(nodes.begin(), nodes.end());
  if (is_tet(type)) set.tets.push_back(tag);
  if (type == kLine2) set.lines.push_back({nodes[0], nodes[1]});
  if (type != kTriangle3 && type != kTriangle6) return;
  RawMesh::Triangle triangle{.nodes = {nodes[0], nodes[1], nodes[2]},
                             .second_order = type == kTriangle6};
  if (triangle.second_order) triangle.mids = {nodes[3], nodes[4], nodes[5]};
  set.triangles.push_back(triangle);
}

void MshContent::refuse_total(std::size_t total) const {
  if (raw_.node_tags.size() == total) return;
  in_.fail("the section has " + std::to_string(raw_.node_tags.size()) + " nodes and announces " +
           std::to_string(total) + ". Write the mesh again.");
}

}  // namespace tandem::fem

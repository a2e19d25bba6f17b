// Gmsh MSH 4.1 ASCII [Gmsh reference manual, "MSH file format"].
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "fem_process/mesh/raw_mesh.h"
#include "fem_process/mesh/text_scanner.h"

namespace tandem::fem {
namespace {

constexpr const char* kConvert =
    " Convert it: gmsh MESH -save -format msh41 -bin 0 -o NEW.msh (Mesh.Binary = 0).";

using EntityKey = std::pair<int, std::int64_t>;  // dimension, tag

class MshReader {
 public:
  explicit MshReader(const std::filesystem::path& file) : in_(file) { raw_.file = file; }

  RawMesh read() {
    format();
    while (!in_.at_end()) section();
    if (!have_nodes_ || !have_elements_) {
      in_.fail(std::string("the file ends without a complete ") +
               (have_nodes_ ? "$Elements" : "$Nodes") +
               " section. It is truncated: write it again.");
    }
    return std::move(raw_);
  }

 private:
  void format() {
    if (in_.word("$MeshFormat") != "$MeshFormat") {
      in_.fail("this is not a Gmsh mesh: it does not begin with $MeshFormat.");
    }
    const std::string version(in_.word("the format version"));
    const bool binary = in_.integer("the file type") != 0;
    if (version != "4.1") in_.fail("MSH version " + version + " is not read, 4.1 is." + kConvert);
    if (binary) in_.fail(std::string("binary MSH is not read, ASCII is.") + kConvert);
    in_.integer("the data size");
    end_of("MeshFormat");
  }

  void section() {
    const std::string header(in_.word("a section"));
    if (header.size() < 2 || header[0] != '$') {
      in_.fail("'" + header + "' where a $Section should begin. Write the mesh again.");
    }
    const std::string name = header.substr(1);
    if (name == "PhysicalNames") {
      physical_names();
    } else if (name == "Entities") {
      entities();
    } else if (name == "Nodes") {
      nodes();
    } else if (name == "Elements") {
      elements();
    } else {
      skip(name);
      return;
    }
    end_of(name);
  }

  void end_of(const std::string& name) {
    const std::string found(in_.word("$End" + name));
    if (found != "$End" + name) {
      in_.fail("'" + found + "' where $End" + name +
               " should be: the section's counts do not match its content. Write the mesh again.");
    }
  }

  void skip(const std::string& name) {
    raw_.notes.push_back("$" + name + " was passed over");
    while (in_.word("$End" + name) != "$End" + name) {
    }
  }

  int dimension() {
    const std::int64_t found = in_.integer("a dimension");
    if (found < 0 || found > 3) {
      in_.fail("the dimension " + std::to_string(found) +
               " is not one of 0, 1, 2, 3. Write the mesh again.");
    }
    return static_cast<int>(found);
  }

  void physical_names() {
    const std::size_t n = in_.count("the number of physical names", 6);
    for (std::size_t i = 0; i < n; ++i) {
      const int dimension = this->dimension();
      const std::int64_t tag = in_.integer("a physical tag");
      const std::string name = in_.quoted("a physical name");
      names_[{dimension, tag}] = name;
      RawMesh::Set& set = raw_.sets[name];
      if (set.line == 0) set.line = in_.line();
    }
  }

  void entities() {
    std::size_t n[4];
    for (std::size_t& count : n) count = in_.count("the number of entities", 8);
    for (int dimension = 0; dimension < 4; ++dimension) {
      for (std::size_t i = 0; i < n[dimension]; ++i) entity(dimension);
    }
  }

  void entity(int dimension) {
    const std::int64_t tag = in_.integer("an entity tag");
    for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) in_.real("an entity's bounding box");
    const std::size_t groups = in_.count("the number of physical tags", 2);
    for (std::size_t k = 0; k < groups; ++k) {
      // A negative tag means reversed orientation: the same group.
      const std::int64_t group = in_.integer("a physical tag");
      if (group == std::numeric_limits<std::int64_t>::min()) {
        in_.fail("the physical tag " + std::to_string(group) +
                 " is out of range. Write the mesh again.");
      }
      groups_[{dimension, tag}].push_back(set_name(dimension, std::abs(group)));
    }
    if (dimension == 0) return;
    const std::size_t boundary = in_.count("the number of bounding entities", 2);
    for (std::size_t k = 0; k < boundary; ++k) in_.integer("a bounding entity");
  }

  /// Name of a physical group; a group without one is called by its number. Groups of one name and
  /// several dimensions are one set.
  std::string set_name(int dimension, std::int64_t group) {
    const auto found = names_.find({dimension, group});
    std::string name = found == names_.end() ? std::to_string(group) : found->second;
    RawMesh::Set& set = raw_.sets[name];
    if (set.line == 0) set.line = in_.line();
    return name;
  }

  void nodes() {
    const std::size_t blocks = in_.count("the number of node blocks", 8);
    const std::size_t total = in_.count("the number of nodes", 8);
    in_.integer("the smallest node tag");
    in_.integer("the largest node tag");
    std::vector<std::int64_t> tags;
    for (std::size_t block = 0; block < blocks; ++block) {
      const int dimension = this->dimension();
      in_.integer("an entity tag");
      const bool parametric = in_.integer("the parametric flag") != 0;
      const std::size_t n = in_.count("the number of nodes in a block", 8);
      tags.resize(n);
      for (std::int64_t& tag : tags) tag = in_.integer("a node tag");
      for (std::int64_t tag : tags) {
        const double x = in_.real("a coordinate");
        const double y = in_.real("a coordinate");
        const double z = in_.real("a coordinate");
        raw_.add_node(tag, {x, y, z}, in_.line());
        for (int k = 0; parametric && k < dimension; ++k) in_.real("a parameter");
      }
    }
    if (raw_.node_tags.size() != total) {
      in_.fail("the section has " + std::to_string(raw_.node_tags.size()) +
               " nodes and announces " + std::to_string(total) + ". Write the mesh again.");
    }
    have_nodes_ = true;
  }

  void elements() {
    const std::size_t blocks = in_.count("the number of element blocks", 8);
    in_.count("the number of elements", 4);
    in_.integer("the smallest element tag");
    in_.integer("the largest element tag");
    for (std::size_t block = 0; block < blocks; ++block) {
      const int dimension = this->dimension();
      const std::int64_t entity = in_.integer("an entity tag");
      const std::int64_t type = in_.integer("an element type");
      const std::size_t nodes = nodes_of(type);
      const std::size_t n = in_.count("the number of elements in a block", 2 * (nodes + 1));
      for (std::size_t i = 0; i < n; ++i) element(dimension, entity, type, nodes);
    }
    have_elements_ = true;
  }

  // Gmsh's numbers of element types.
  static constexpr std::int64_t kPoint = 15, kLine2 = 1, kTriangle3 = 2, kTet4 = 4, kLine3 = 8,
                                kTriangle6 = 9, kTet10 = 11;

  std::size_t nodes_of(std::int64_t type) const {
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

  void element(int dimension, std::int64_t entity, std::int64_t type, std::size_t nodes) {
    const std::int64_t tag = in_.integer("an element tag");
    std::array<std::int64_t, 10> n{};
    for (std::size_t k = 0; k < nodes; ++k) n[k] = in_.integer("a node tag of an element");
    const bool tet = type == kTet4 || type == kTet10;
    if (tet) {
      // Gmsh has the mid nodes of the edges 23 and 13 last, in this order.
      raw_.add_tet({.tag = tag,
                    .nodes = {n[0], n[1], n[2], n[3]},
                    .mids = {n[4], n[5], n[6], n[7], n[9], n[8]},
                    .second_order = type == kTet10,
                    .line = in_.line()});
    }
    const auto found = groups_.find({dimension, entity});
    if (found == groups_.end()) return;
    for (const std::string& name : found->second) {
      RawMesh::Set& set = raw_.sets[name];
      set.nodes.insert(n.begin(), n.begin() + static_cast<std::ptrdiff_t>(nodes));
      if (tet) set.tets.push_back(tag);
      if (type == kLine2) set.lines.push_back({n[0], n[1]});
      if (type == kTriangle3 || type == kTriangle6) {
        set.triangles.push_back({.nodes = {n[0], n[1], n[2]},
                                 .mids = {n[3], n[4], n[5]},
                                 .second_order = type == kTriangle6});
      }
    }
  }

  TextScanner in_;
  RawMesh raw_;
  std::map<EntityKey, std::string> names_;
  std::map<EntityKey, std::vector<std::string>> groups_;
  bool have_nodes_ = false;
  bool have_elements_ = false;
};

}  // namespace

RawMesh read_msh(const std::filesystem::path& file) { return MshReader(file).read(); }

}  // namespace tandem::fem

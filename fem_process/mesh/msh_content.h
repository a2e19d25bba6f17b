#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "fem_process/mesh/msh_stream.h"
#include "fem_process/mesh/raw_mesh.h"

namespace tandem::fem {

/// What the versions of Gmsh's format have in common: element types, physical groups, and the mesh
/// that is made of them.
class MshContent {
 public:
  using Group = std::pair<int, std::int64_t>;  ///< dimension, tag

  MshContent(MshStream& in, RawMesh& raw) : in_(in), raw_(raw) {}

  /// Nodes of a Gmsh element type. Refuses what is neither a tetrahedron of first or second order
  /// nor a point, line or triangle of these.
  [[nodiscard]] std::size_t nodes_of(std::int64_t type) const;
  /// 0 … 3, of a type that nodes_of() takes.
  [[nodiscard]] static int dimension_of(std::int64_t type);
  [[nodiscard]] static bool is_tet(std::int64_t type);

  /// Content of $PhysicalNames.
  void read_names();
  /// Name of a physical group; a group without one is called by its number. A negative tag means
  /// reversed orientation: the same group. Groups of one name and several dimensions are one set.
  std::string set_name(int dimension, std::int64_t group);

  /// A tetrahedron becomes one of the mesh.
  void add_tet(std::int64_t tag, std::int64_t type, const std::vector<std::int64_t>& nodes);
  /// An element, its nodes and edges become part of a set.
  void add_to_set(const std::string& name, std::int64_t tag, std::int64_t type,
                  const std::vector<std::int64_t>& nodes);

  /// A dimension in 0 … 3.
  int dimension();
  void refuse_total(std::size_t total) const;

 private:
  MshStream& in_;
  RawMesh& raw_;
  std::map<Group, std::string> names_;
};

/// $Nodes and $Elements of versions 2 to 2.2.
class MshVersion2 {
 public:
  MshVersion2(MshStream& in, MshContent& content, RawMesh& raw)
      : in_(in), content_(content), raw_(raw) {}
  void nodes();
  void elements();

 private:
  void element(std::int64_t tag, std::int64_t type, std::int64_t group);

  MshStream& in_;
  MshContent& content_;
  RawMesh& raw_;
  std::vector<std::int64_t> nodes_;
  /// An element in two physical groups is written twice, with two numbers: by its nodes, the first
  /// number and group.
  std::map<std::vector<std::int64_t>, std::pair<std::int64_t, std::int64_t>> tets_;
};

/// $Entities, $Nodes and $Elements of versions 4 and 4.1.
class MshVersion4 {
 public:
  MshVersion4(MshStream& in, MshContent& content, RawMesh& raw)
      : in_(in), content_(content), raw_(raw) {}
  void entities();
  void nodes();
  void elements();

 private:
  struct Entity {
    int dimension = 0;
    std::int64_t tag = 0;
  };
  /// Version 4.1 has the dimension first, 4.0 the tag.
  Entity entity_of_block();
  void entity(int dimension);
  void node_block();
  void element_block();

  MshStream& in_;
  MshContent& content_;
  RawMesh& raw_;
  std::map<MshContent::Group, std::vector<std::string>> groups_;  ///< by entity
};

}  // namespace tandem::fem

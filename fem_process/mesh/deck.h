#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "fem_process/mesh/deck_elements.h"
#include "fem_process/mesh/raw_mesh.h"
#include "fem_process/mesh/tag_set.h"

namespace tandem::fem {

/// Nodes, elements and sets under numbers and names of their own: a flat deck, the assembly's own
/// content, a part, or an instance. Sets are kept by deck_key() of their names.
struct DeckScope {
  /// An element that is no tetrahedron; its nodes stand in `other_nodes`.
  struct Other {
    std::int64_t tag = 0;
    DeckShape shape = DeckShape::Other;
    std::size_t first = 0, count = 0;
  };
  struct Members {
    TagSet tags;
    std::set<std::string> element_sets;  ///< of a node set: whose elements' nodes it has
  };
  struct Set {
    std::string name;  ///< as first written
    int line = 0;
    std::map<std::string, Members> of;  ///< by instance; "" for this scope's own numbers
    std::set<std::pair<std::string, std::string>> sets;  ///< instance and name of whole sets
  };
  struct SurfaceRow {
    std::string item, face;  ///< element or element set, S1 … S4, SPOS, SNEG or none; or a node
    int line = 0;
  };
  struct Surface {
    std::string name;
    int line = 0;
    bool of_nodes = false;
    std::vector<SurfaceRow> rows;
  };

  std::string name;  ///< of the part or instance; empty for the deck and the assembly
  Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
  std::vector<std::int64_t> node_tags;
  std::vector<Eigen::Vector3d> node_positions;
  std::vector<int> node_lines;
  std::vector<RawMesh::Tetrahedron> tets;
  std::vector<Other> others;
  std::vector<std::int64_t> other_nodes;
  std::map<std::string, Set> node_sets, element_sets;
  std::map<std::string, Surface> surfaces;

  [[nodiscard]] std::size_t elements() const { return tets.size() + others.size(); }
  [[nodiscard]] std::size_t size() const { return node_tags.size() + elements(); }
};

/// A deck as it is read: parts are in their instances.
struct Deck {
  DeckScope root;
  std::deque<DeckScope> instances;
};

/// Puts the placed instances and the deck's own content together. Where numbers of several
/// instances collide, those of the second and later ones are raised by multiples of a power of
/// ten, which a note says. A set of an instance is called `instance.set`, and `set` where that is
/// no other's. `raw` has the file, its lines and notes.
void assemble(const Deck& deck, RawMesh& raw);

/// The instance before a dot of `name`, by its key, and the rest. Instances' names may have dots.
[[nodiscard]] std::pair<std::string, std::string> split_at_instance(const Deck& deck,
                                                                    const std::string& name);

}  // namespace tandem::fem

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "fem_process/mesh/mesh.h"
#include "fem_process/mesh/source_lines.h"

namespace tandem::fem {

/// A mesh as the file has it: by tags, not scaled, with nodes that no tet uses. Lines are numbers
/// of `lines`.
struct RawMesh {
  struct Tetrahedron {
    std::int64_t tag = 0;
    std::array<std::int64_t, 4> nodes{};
    std::array<std::int64_t, 6> mids{};  ///< of second order: in the order of kTetEdges
    bool second_order = false;
    int line = 0;
  };
  struct Triangle {
    std::array<std::int64_t, 3> nodes{};
    std::array<std::int64_t, 3> mids{};  ///< of second order: on edges 01, 12, 20
    bool second_order = false;
  };
  struct Set {
    std::set<std::int64_t> nodes;
    std::vector<std::array<std::int64_t, 2>> lines;
    std::vector<Triangle> triangles;
    std::vector<std::int64_t> tets;
    bool node_list = false;   ///< a list of nodes (*NSET), not of points, lines, triangles or tets
    bool tets_apart = false;  ///< an *ELSET beside a *NSET or *SURFACE whose nodes the set has
    int line = 0;
  };
  std::filesystem::path file;
  SourceLines lines;
  std::vector<std::int64_t> node_tags;
  std::vector<Eigen::Vector3d> node_positions;
  std::unordered_map<std::int64_t, int> node_index;  ///< looked up only, never iterated
  std::vector<Tetrahedron> tets;
  std::unordered_map<std::int64_t, int> tet_index;  ///< looked up only, never iterated
  std::map<std::string, Set> sets;
  std::vector<std::string> notes;

  [[noreturn]] void fail(int line, const std::string& text) const;
  /// Both refuse a tag that was there before; the second also tets of mixed order.
  void add_node(std::int64_t tag, const Eigen::Vector3d& position, int line);
  void add_tet(const Tetrahedron& tet);
  [[nodiscard]] bool second_order() const { return !tets.empty() && tets.front().second_order; }
};

[[nodiscard]] RawMesh read_msh(const std::filesystem::path& file);
[[nodiscard]] RawMesh read_inp(const std::filesystem::path& file);

/// The files that an Abaqus deck includes before its first step, in their order. Throws as
/// read_inp() does where one is missing.
[[nodiscard]] std::vector<std::filesystem::path> included_files(const std::filesystem::path& file);

/// Puts a node in the middle of every edge: first-order tets and triangles become straight ones of
/// second order. The new nodes are numbered on from the largest tag, in the order of the tets and
/// of kTetEdges. A set made of lines, triangles or tets takes the mid nodes of their edges; a mere
/// list of nodes (*NSET) takes that of every edge both ends of which it has.
void raise_to_second_order(RawMesh& raw);

}  // namespace tandem::fem

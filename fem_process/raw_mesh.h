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

#include "fem_process/mesh.h"

namespace tandem::fem {

/// A mesh as the file has it: by tags, not scaled, with nodes that no tet uses.
struct RawMesh {
  struct Tetrahedron {
    std::int64_t tag = 0;
    std::array<std::int64_t, 4> nodes{};
    int line = 0;
  };
  struct Set {
    std::set<std::int64_t> nodes;
    std::vector<std::array<std::int64_t, 3>> triangles;
    int line = 0;
  };
  std::filesystem::path file;
  std::vector<std::int64_t> node_tags;
  std::vector<Eigen::Vector3d> node_positions;
  std::unordered_map<std::int64_t, int> node_index;  ///< looked up only, never iterated
  std::vector<Tetrahedron> tets;
  std::unordered_map<std::int64_t, int> tet_index;  ///< looked up only, never iterated
  std::map<std::string, Set> sets;
  std::vector<std::string> notes;

  [[noreturn]] void fail(int line, const std::string& text) const;
  /// Both refuse a tag that was there before.
  void add_node(std::int64_t tag, const Eigen::Vector3d& position, int line);
  void add_tet(const Tetrahedron& tet);
};

[[nodiscard]] RawMesh read_msh(const std::filesystem::path& file);
[[nodiscard]] RawMesh read_inp(const std::filesystem::path& file);

}  // namespace tandem::fem

#include "fem_process/mesh/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <system_error>
#include <utility>

#include "fem_process/mesh/raw_mesh.h"
#include "fem_process/mesh/tet10.h"
#include "protocol/contract/error.h"
#include "protocol/contract/hash.h"

namespace tandem::fem {
namespace {

/// Tets thinner than this fraction of their longest edge cubed have no usable stiffness.
constexpr double kFlat = 1e-12;
/// Elements with mid nodes at a quarter of their edges, for crack tips, have the Jacobian 0 at a
/// corner, up to the rounding of the file's coordinates.
constexpr double kQuarterPoint = 1e-6;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

double longest_edge(const TetMesh& mesh, const Tet& tet) {
  double longest = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      longest = std::max(longest, (mesh.X[static_cast<std::size_t>(tet[j])] -
                                   mesh.X[static_cast<std::size_t>(tet[i])])
                                      .norm());
    }
  }
  return longest;
}

/// Index of each raw node among those that tets use; −1 for the others.
std::vector<int> number_used_nodes(const RawMesh& raw) {
  std::vector<int> number(raw.node_tags.size(), -1);
  for (const RawMesh::Tetrahedron& tet : raw.tets) {
    const auto use = [&](std::int64_t tag) {
      const auto found = raw.node_index.find(tag);
      if (found == raw.node_index.end()) {
        raw.fail(tet.line, "element " + std::to_string(tet.tag) + " uses node " +
                               std::to_string(tag) +
                               ", which the file does not define. Write the mesh again.");
      }
      number[static_cast<std::size_t>(found->second)] = 0;
    };
    for (std::int64_t tag : tet.nodes) use(tag);
    if (!tet.second_order) continue;
    for (std::int64_t tag : tet.mids) use(tag);
  }
  int next = 0;
  for (int& n : number) {
    if (n == 0) n = next++;
  }
  return number;
}

void check_volume(const RawMesh& raw, const TetMesh& mesh, const RawMesh::Tetrahedron& tet,
                  const Tet& corners) {
  const double volume = signed_volume(mesh, corners);
  const double edge = longest_edge(mesh, corners);
  if (volume > kFlat * edge * edge * edge) return;
  throw Error(ErrorKind::Usage,
              raw.lines.where(tet.line) + ": element " + std::to_string(tet.tag) + " has " +
                  (volume < 0.0 ? "negative" : "no") + " volume (" + fmt::format("{:.3g}", volume) +
                  " m³). Its corners are numbered inside out or lie in a plane: mesh again.");
}

/// Refuses an element that is folded where it is integrated, or whose mid nodes are those of
/// another program's order. A fold at a node alone, as coarse curved edges have it, is noted.
void check_mid_nodes(const RawMesh& raw, TetMesh& mesh, const RawMesh::Tetrahedron& tet) {
  Eigen::Matrix<double, 10, 3> X = tet10_positions(mesh, mesh.tets.size() - 1);
  const SmallestJacobian jacobian = smallest_jacobian(X);
  const std::string element = "element " + std::to_string(tet.tag);
  const std::string where = raw.lines.where(tet.line) + ": " + element;
  if (jacobian.at_points > 0.0 && jacobian.at_nodes > -kQuarterPoint) return;
  X.row(8).swap(X.row(9));
  require(smallest_jacobian(X).at_nodes <= 0.0,
          where +
              " has the mid nodes of its edges 2-4 and 3-4 exchanged: Abaqus numbers that of "
              "2-4 first, Gmsh that of 3-4. Write the mesh again.");
  require(jacobian.at_points > 0.0,
          where + " is folded: its Jacobian falls to " + fmt::format("{:.3g}", jacobian.at_points) +
              " of that of its corners. Its mid nodes are in another order or too far off their "
              "edges: mesh again, or use straight edges (fem.mesh.order: 2 on a first-order "
              "mesh).");
  mesh.notes.push_back(raw.lines.named(tet.line) + ": " + element +
                       " is folded at a node, not at its integration points: its curved edges are "
                       "coarse");
}

NodeSet place_set(const RawMesh& raw, const RawMesh::Set& set, const std::vector<int>& number) {
  const auto index = [&](std::int64_t tag) {
    const auto found = raw.node_index.find(tag);
    if (found == raw.node_index.end()) {
      raw.fail(set.line, "a set uses node " + std::to_string(tag) +
                             ", which the file does not define. Write the mesh again.");
    }
    return number[static_cast<std::size_t>(found->second)];
  };
  NodeSet placed;
  placed.where = raw.lines.where(set.line);
  for (std::int64_t tag : set.nodes) {
    if (const int node = index(tag); node >= 0) placed.nodes.push_back(node);
  }
  std::sort(placed.nodes.begin(), placed.nodes.end());
  const auto indices = [&](const std::array<std::int64_t, 3>& tags) {
    return Triangle{index(tags[0]), index(tags[1]), index(tags[2])};
  };
  for (const RawMesh::Triangle& triangle : set.triangles) {
    const Triangle corners = indices(triangle.nodes);
    if (*std::min_element(corners.begin(), corners.end()) < 0) continue;
    if (triangle.second_order != raw.second_order()) {
      raw.fail(set.line,
               "a set has a triangle that is no face of the tetrahedra or of another "
               "order than they. Write the whole mesh anew, with one order.");
    }
    placed.triangles.push_back(corners);
    if (triangle.second_order) placed.triangle_mids.push_back(indices(triangle.mids));
  }
  for (std::int64_t tag : set.tets) placed.tets.push_back(raw.tet_index.at(tag));
  std::sort(placed.tets.begin(), placed.tets.end());
  placed.tets.erase(std::unique(placed.tets.begin(), placed.tets.end()), placed.tets.end());
  return placed;
}

/// Two elements on the same corners would have their stiffness and mass twice.
void refuse_doubled_tets(const RawMesh& raw) {
  std::vector<std::pair<std::array<std::int64_t, 4>, std::size_t>> corners;
  corners.reserve(raw.tets.size());
  for (std::size_t k = 0; k < raw.tets.size(); ++k) {
    corners.emplace_back(raw.tets[k].nodes, k);
    std::sort(corners.back().first.begin(), corners.back().first.end());
  }
  std::sort(corners.begin(), corners.end());
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  const auto found = std::adjacent_find(corners.begin(), corners.end(), same);
  if (found == corners.end()) return;
  const RawMesh::Tetrahedron& first = raw.tets[found->second];
  const RawMesh::Tetrahedron& second = raw.tets[std::next(found)->second];
  raw.fail(second.line, fmt::format("element {} has the same corners as element {} ({}): "
                                    "stiffness and mass would count twice. Delete one of them.",
                                    second.tag, first.tag, raw.lines.named(first.line)));
}

bool is_abaqus(const std::filesystem::path& file) {
  return lower(file.extension().string()) == ".inp";
}

std::string how_to_name_sets(const std::filesystem::path& file) {
  return is_abaqus(file)
             ? "Name nodes with *NSET, NSET=NAME and elements with *ELSET, ELSET=NAME."
             : "In Gmsh write Physical Surface(\"NAME\") = {…}; for every set and Physical "
               "Volume(\"body\") = {…}; for the part, and save with Mesh.SaveAll = 0.";
}

bool add_file(const std::filesystem::path& file, StateHash& hash) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return false;
  std::array<char, 1 << 16> buffer;
  while (stream.read(buffer.data(), buffer.size()), stream.gcount() > 0) {
    const auto bytes = static_cast<std::size_t>(stream.gcount());
    for (std::size_t at = 0; at < bytes; at += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, buffer.data() + at, std::min(sizeof word, bytes - at));
      hash.add(word);
    }
    hash.add(static_cast<std::uint64_t>(bytes));
  }
  return true;
}

TetMesh place(const RawMesh& raw, const MeshParams& params) {
  if (raw.tets.empty()) {
    raw.fail(1, std::string("the mesh has no tetrahedra. ") +
                    (is_abaqus(raw.file)
                         ? "Mesh the volume and write it as *ELEMENT, TYPE=C3D4 or C3D10."
                         : "Mesh the volume (gmsh -3). Where the model has physical groups, Gmsh "
                           "saves only what they hold: add Physical Volume(\"body\") = {…};."));
  }
  refuse_doubled_tets(raw);
  const std::vector<int> number = number_used_nodes(raw);
  TetMesh mesh;
  mesh.file = raw.file;
  mesh.notes = raw.notes;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    mesh.X.push_back(params.position_m +
                     params.orientation * (params.length_scale_m * raw.node_positions[i]));
    mesh.node_tags.push_back(raw.node_tags[i]);
  }
  for (const RawMesh::Tetrahedron& tet : raw.tets) {
    const auto index = [&](std::int64_t tag) {
      return number[static_cast<std::size_t>(raw.node_index.at(tag))];
    };
    Tet corners{};
    for (std::size_t k = 0; k < 4; ++k) corners[k] = index(tet.nodes[k]);
    check_volume(raw, mesh, tet, corners);
    mesh.tets.push_back(corners);
    mesh.element_tags.push_back(tet.tag);
    if (!tet.second_order) continue;
    TetMids& mids = mesh.mids.emplace_back();
    for (std::size_t k = 0; k < 6; ++k) mids[k] = index(tet.mids[k]);
    check_mid_nodes(raw, mesh, tet);
  }
  for (const auto& [name, set] : raw.sets) mesh.sets.emplace(name, place_set(raw, set, number));
  return mesh;
}

}  // namespace

std::vector<std::string> names_of(const std::vector<SetName>& sets) {
  std::vector<std::string> names;
  for (const SetName& set : sets) names.push_back(set.name);
  return names;
}

void RawMesh::fail(int line, const std::string& text) const {
  throw Error(ErrorKind::Usage, lines.where(line) + ": " + text);
}

void RawMesh::add_node(std::int64_t tag, const Eigen::Vector3d& position, int line) {
  if (!node_index.emplace(tag, static_cast<int>(node_tags.size())).second) {
    fail(line,
         "node " + std::to_string(tag) + " is defined twice. Give every node its own number.");
  }
  node_tags.push_back(tag);
  node_positions.push_back(position);
}

void RawMesh::add_tet(const Tetrahedron& tet) {
  if (!tet_index.emplace(tet.tag, static_cast<int>(tets.size())).second) {
    fail(tet.line, "element " + std::to_string(tet.tag) +
                       " is defined twice. Give every element its own number.");
  }
  tets.push_back(tet);
  if (tet.second_order == second_order()) return;
  fail(tet.line, "element " + std::to_string(tet.tag) +
                     " is of another order than the elements before it. Write the whole mesh "
                     "with one order.");
}

std::vector<int> TetMesh::element(std::size_t e) const {
  std::vector<int> nodes(tets[e].begin(), tets[e].end());
  if (second_order()) nodes.insert(nodes.end(), mids[e].begin(), mids[e].end());
  return nodes;
}

std::string mesh_checksum(const std::filesystem::path& file) {
  StateHash hash;
  if (!add_file(file, hash)) return {};
  try {
    if (is_abaqus(file)) {
      for (const std::filesystem::path& included : included_files(file)) {
        if (!add_file(included, hash)) return {};
      }
    }
  } catch (const Error&) {
    return {};
  }
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash.value();
  return text.str();
}

TetMesh read_mesh(const MeshParams& params) {
  require(params.length_scale_m > 0.0 && std::isfinite(params.length_scale_m),
          "fem: mesh length scale " + fmt::format("{:.6g}", params.length_scale_m) +
              " m must be positive. Give metres per unit of the mesh file.");
  const std::string extension = lower(params.file.extension().string());
  require(extension == ".msh" || extension == ".inp",
          params.file.string() + ": unknown kind of mesh file '" + extension +
              "'. Give a Gmsh .msh or an Abaqus .inp.");
  // A file that cannot be read has no checksum; its reader says why.
  const std::string checksum = mesh_checksum(params.file);
  require(params.checksum.empty() || checksum.empty() || params.checksum == checksum,
          params.file.string() +
              ": the mesh is not the one this scenario was run with: its checksum "
              "is " +
              checksum + ", fem.mesh.checksum says " + params.checksum +
              ". Bring that mesh back, or remove the key to run with this one.");
  RawMesh raw = extension == ".msh" ? read_msh(params.file) : read_inp(params.file);
  require(params.order != 1 || !raw.second_order(),
          params.file.string() +
              ": the mesh has second-order tetrahedra, fem.mesh.order asks for the first. Leave "
              "the key out, or mesh with first-order tetrahedra.");
  if (params.order == 2 && !raw.second_order()) raise_to_second_order(raw);
  return place(raw, params);
}

const NodeSet& find_set(const TetMesh& mesh, const SetName& name) {
  const std::string where = name.place.file.empty() ? "fem: " : name.place.text() + ": ";
  const auto found = mesh.sets.find(name.name);
  if (found == mesh.sets.end()) {
    std::vector<std::string> known;
    std::string list;
    for (const auto& [set, content] : mesh.sets) {
      known.push_back(set);
      list += (list.empty() ? "" : ", ") + set;
    }
    const std::string missing = where + "the mesh " + mesh.file.string();
    require(!known.empty(), missing + " has no named sets" +
                                (is_abaqus(mesh.file) ? "" : " (physical groups)") + ", so none '" +
                                name.name + "'. " + how_to_name_sets(mesh.file));
    throw Error(ErrorKind::Usage, missing + " has no node set '" + name.name + "'." +
                                      scenario::did_you_mean(name.name, known) +
                                      " It has: " + list + ".");
  }
  require(!found->second.nodes.empty(),
          where + "node set '" + name.name + "' (" + found->second.where +
              ") has no node on a tetrahedron. Assign geometry of the meshed volume to it.");
  return found->second;
}

double signed_volume(const TetMesh& mesh, const Tet& tet) {
  const auto X = [&](std::size_t k) { return mesh.X[static_cast<std::size_t>(tet[k])]; };
  return (X(1) - X(0)).cross(X(2) - X(0)).dot(X(3) - X(0)) / 6.0;
}

double diagonal_of(const TetMesh& mesh) {
  Eigen::Vector3d low = mesh.X.front();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3d& X : mesh.X) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  return (high - low).norm();
}

double area(const TetMesh& mesh, const Triangle& triangle) {
  const auto X = [&](std::size_t k) { return mesh.X[static_cast<std::size_t>(triangle[k])]; };
  return 0.5 * (X(1) - X(0)).cross(X(2) - X(0)).norm();
}

}  // namespace tandem::fem

// The subset of Abaqus/CalculiX input that describes a mesh of tetrahedra.
#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "fem_process/mesh/raw_mesh.h"
#include "fem_process/mesh/tet10.h"
#include "fem_process/mesh/text_scanner.h"

namespace tandem::fem {
namespace {

/// Keywords that say nothing about the mesh: passed over, with a note. Everything else that is not
/// read could change the mesh (*PART, *NGEN, *INCLUDE, *SYSTEM …) and is refused.
constexpr std::string_view kPassedOver[] = {
    "HEADING",  "PREPRINT",          "RESTART",        "MATERIAL",  "ELASTIC",  "DENSITY",
    "DAMPING",  "EXPANSION",         "SOLID SECTION",  "STEP",      "END STEP", "STATIC",
    "DYNAMIC",  "FREQUENCY",         "BOUNDARY",       "CLOAD",     "DLOAD",    "AMPLITUDE",
    "OUTPUT",   "NODE OUTPUT",       "ELEMENT OUTPUT", "NODE FILE", "EL FILE",  "NODE PRINT",
    "EL PRINT", "INITIAL CONDITIONS"};

/// Corners of faces S1 … S4 of C3D4 and C3D10, each seen from outside.
constexpr std::size_t kFaces[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};

std::string trimmed_upper(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) {
    text.remove_prefix(1);
  }
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) {
    text.remove_suffix(1);
  }
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return result;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view field = line.substr(0, comma);
    while (!field.empty() && std::isspace(static_cast<unsigned char>(field.front()))) {
      field.remove_prefix(1);
    }
    while (!field.empty() && std::isspace(static_cast<unsigned char>(field.back()))) {
      field.remove_suffix(1);
    }
    fields.push_back(field);
    if (comma == std::string_view::npos) break;
    line.remove_prefix(comma + 1);
  }
  while (!fields.empty() && fields.back().empty()) fields.pop_back();
  return fields;
}

class InpReader {
 public:
  explicit InpReader(const std::filesystem::path& file) : in_(file) { raw_.file = file; }

  RawMesh read() {
    while (!in_.at_end()) {
      line_ = in_.line();
      const std::string_view line = in_.rest_of_line();
      if (line.substr(0, 2) == "**") continue;
      if (line.front() == '*') {
        keyword(line);
      } else {
        data(split(line));
      }
    }
    finish_element();
    resolve_surfaces();
    publish_sets();
    return std::move(raw_);
  }

 private:
  enum class Mode { None, PassOver, Node, Element, Nset, Elset, Surface };
  struct ElementSet {
    std::vector<std::int64_t> elements;
    int line = 0;
    std::string name;
  };
  struct SurfaceRow {
    std::string name, elements, face;
    int line = 0;
  };

  [[noreturn]] void fail(const std::string& text) const { raw_.fail(line_, text); }

  void keyword(std::string_view line) {
    finish_element();
    parameters_.clear();
    std::vector<std::string_view> fields = split(line.substr(1));
    const std::string name = fields.empty() ? "" : trimmed_upper(fields[0]);
    for (std::size_t k = 1; k < fields.size(); ++k) {
      const std::size_t equals = fields[k].find('=');
      const std::string key = trimmed_upper(fields[k].substr(0, equals));
      const std::vector<std::string_view> value =
          split(equals == std::string_view::npos ? "" : fields[k].substr(equals + 1));
      parameters_[key] = value.empty() ? "" : value.front();
    }
    generate_ = parameters_.count("GENERATE") > 0;
    if (name == "NODE") {
      mode_ = Mode::Node;
      target_ = parameters_.count("NSET") > 0 ? needed("NSET") : "";
      if (!target_.empty()) node_set(target_);
    } else if (name == "ELEMENT") {
      element_keyword();
    } else if (name == "NSET") {
      mode_ = Mode::Nset;
      target_ = needed("NSET");
      node_set(target_);
    } else if (name == "ELSET") {
      mode_ = Mode::Elset;
      target_ = needed("ELSET");
      element_set(target_);
    } else if (name == "SURFACE") {
      mode_ = Mode::Surface;
      target_ = needed("NAME");
      if (parameters_.count("TYPE") > 0 && trimmed_upper(parameters_["TYPE"]) != "ELEMENT") {
        fail("*SURFACE, TYPE=" + parameters_["TYPE"] + " is not read. Write TYPE=ELEMENT.");
      }
    } else {
      pass_over(name);
    }
  }

  void pass_over(const std::string& name) {
    if (std::find(std::begin(kPassedOver), std::end(kPassedOver), name) == std::end(kPassedOver)) {
      fail("keyword *" + name + " is not read. Write a flat mesh with *NODE, *ELEMENT, *NSET, " +
           "*ELSET and *SURFACE.");
    }
    mode_ = Mode::PassOver;
    raw_.notes.push_back("line " + std::to_string(line_) + ": *" + name + " was passed over");
  }

  void element_keyword() {
    const std::string type = trimmed_upper(needed("TYPE"));
    if (type != "C3D4" && type != "C3D10") {
      fail("element type " + type +
           " is not read: only the tetrahedra C3D4 and C3D10 are. Mesh with one of them.");
    }
    nodes_ = type == "C3D4" ? 4 : 10;
    mode_ = Mode::Element;
    target_ = parameters_.count("ELSET") > 0 ? needed("ELSET") : "";
    if (!target_.empty()) element_set(target_);
  }

  std::string needed(const std::string& key) {
    const auto found = parameters_.find(key);
    if (found == parameters_.end()) fail("the parameter " + key + "= is missing. Add it.");
    if (found->second.empty()) {
      fail("the parameter " + key + "= is empty. Write a name behind it.");
    }
    return found->second;
  }

  void data(const std::vector<std::string_view>& fields) {
    switch (mode_) {
      case Mode::None:
        fail("data before the first keyword. Begin with *NODE.");
      case Mode::PassOver:
        return;
      case Mode::Node:
        return node(fields);
      case Mode::Element:
        return element(fields);
      case Mode::Nset:
      case Mode::Elset:
        return members(fields);
      case Mode::Surface:
        if (fields.size() != 2) fail("a surface row is: element or element set, face S1 to S4.");
        surfaces_.push_back({target_, std::string(fields[0]), trimmed_upper(fields[1]), line_});
    }
  }

  std::int64_t whole(std::string_view field, const char* what) const {
    std::int64_t value = 0;
    if (!parse(field, value)) {
      fail(in_quotes(field) + " where " + what + " should be. Write a whole number.");
    }
    return value;
  }

  void node(const std::vector<std::string_view>& fields) {
    if (fields.size() != 4) fail("a node row is: number, x, y, z. The file may be truncated.");
    const std::int64_t tag = whole(fields[0], "a node number");
    Eigen::Vector3d position;
    for (int k = 0; k < 3; ++k) {
      if (!parse(fields[static_cast<std::size_t>(k) + 1], position(k))) {
        fail(in_quotes(fields[static_cast<std::size_t>(k) + 1]) +
             " where a coordinate should be. Write a finite number.");
      }
    }
    raw_.add_node(tag, position, line_);
    if (!target_.empty()) node_set(target_).nodes.insert(tag);
  }

  /// An element's numbers may go on over several lines.
  void element(const std::vector<std::string_view>& fields) {
    if (pending_.empty()) pending_line_ = line_;
    for (std::string_view field : fields) pending_.push_back(whole(field, "a node number"));
    if (pending_.size() > nodes_ + 1) fail(row_is() + "; here are more.");
    if (pending_.size() < nodes_ + 1) return;
    RawMesh::Tetrahedron tet{
        .tag = pending_[0], .second_order = nodes_ == 10, .line = pending_line_};
    std::copy_n(pending_.begin() + 1, 4, tet.nodes.begin());
    if (tet.second_order) std::copy_n(pending_.begin() + 5, 6, tet.mids.begin());
    raw_.add_tet(tet);
    if (!target_.empty()) element_set(target_).elements.push_back(pending_[0]);
    pending_.clear();
  }

  std::string row_is() const {
    return "a C3D" + std::to_string(nodes_) + " row is: number and " + std::to_string(nodes_) +
           " nodes";
  }

  void finish_element() const {
    if (!pending_.empty()) {
      raw_.fail(pending_line_, row_is() + "; here are " + std::to_string(pending_.size()) +
                                   " numbers. The file may be truncated.");
    }
  }

  void members(const std::vector<std::string_view>& fields) {
    if (generate_) {
      if (fields.size() != 2 && fields.size() != 3) fail("GENERATE rows are: first, last, step.");
      const std::int64_t first = whole(fields[0], "the first number");
      const std::int64_t last = whole(fields[1], "the last number");
      const std::int64_t step = fields.size() == 3 ? whole(fields[2], "the step") : 1;
      const auto most = static_cast<std::int64_t>(raw_.node_tags.size() + raw_.tets.size());
      // From either end of the range of numbers to the other the difference itself is none.
      std::int64_t span = 0;
      if (step <= 0 || last < first || __builtin_sub_overflow(last, first, &span) ||
          span / step > most) {
        fail("GENERATE from " + std::to_string(first) + " to " + std::to_string(last) + " by " +
             std::to_string(step) + " makes no sense for this mesh. Correct the row.");
      }
      for (std::int64_t k = 0; k <= span / step; ++k) add_member(first + k * step);
      return;
    }
    for (std::string_view field : fields) {
      std::int64_t tag = 0;
      if (parse(field, tag)) {
        add_member(tag);
      } else {
        add_set(std::string(field));
      }
    }
  }

  void add_member(std::int64_t tag) {
    if (mode_ == Mode::Nset) {
      node_set(target_).nodes.insert(tag);
    } else {
      element_set(target_).elements.push_back(tag);
    }
  }

  void add_set(const std::string& name) {
    if (mode_ == Mode::Nset) {
      const auto found = node_sets_.find(trimmed_upper(name));
      if (found == node_sets_.end()) fail("node set '" + name + "' is not defined before here.");
      const std::set<std::int64_t> nodes = found->second.second.nodes;
      node_set(target_).nodes.insert(nodes.begin(), nodes.end());
      return;
    }
    const auto found = element_sets_.find(trimmed_upper(name));
    if (found == element_sets_.end())
      fail("element set '" + name + "' is not defined before here.");
    const std::vector<std::int64_t> elements = found->second.elements;
    auto& target = element_set(target_).elements;
    target.insert(target.end(), elements.begin(), elements.end());
  }

  // Abaqus compares names without case; they keep the spelling of their first mention.
  RawMesh::Set& node_set(const std::string& name) {
    auto& [spelling, set] = node_sets_[trimmed_upper(name)];
    if (set.line == 0) {
      spelling = name;
      set.line = line_;
      set.node_list = true;
    }
    return set;
  }
  ElementSet& element_set(const std::string& name) {
    ElementSet& set = element_sets_[trimmed_upper(name)];
    if (set.line == 0) {
      set.name = name;
      set.line = line_;
    }
    return set;
  }

  const RawMesh::Tetrahedron& tet(std::int64_t tag, int line) const {
    const auto found = raw_.tet_index.find(tag);
    if (found == raw_.tet_index.end()) {
      raw_.fail(line, "element " + std::to_string(tag) + " is not defined. Correct the set.");
    }
    return raw_.tets[static_cast<std::size_t>(found->second)];
  }

  void resolve_surfaces() {
    for (const SurfaceRow& row : surfaces_) {
      if (row.face.size() != 2 || row.face[0] != 'S' || row.face[1] < '1' || row.face[1] > '4') {
        raw_.fail(row.line, "face '" + row.face + "' is not one of S1, S2, S3, S4.");
      }
      std::vector<std::int64_t> elements;
      std::int64_t single = 0;
      if (parse(row.elements, single)) {
        elements.push_back(single);
      } else {
        const auto found = element_sets_.find(trimmed_upper(row.elements));
        if (found == element_sets_.end()) {
          raw_.fail(row.line, "element set '" + row.elements + "' is not defined.");
        }
        elements = found->second.elements;
      }
      RawMesh::Set& surface = raw_.sets[row.name];
      if (surface.line == 0) surface.line = row.line;
      for (std::int64_t tag : elements) {
        const RawMesh::Triangle triangle = face(tet(tag, row.line), row.face[1] - '1');
        surface.triangles.push_back(triangle);
        surface.nodes.insert(triangle.nodes.begin(), triangle.nodes.end());
        if (!triangle.second_order) continue;
        surface.nodes.insert(triangle.mids.begin(), triangle.mids.end());
      }
    }
  }

  static RawMesh::Triangle face(const RawMesh::Tetrahedron& tet, int number) {
    const auto& corner = kFaces[number];
    RawMesh::Triangle triangle{.second_order = tet.second_order};
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.nodes[k] = tet.nodes[corner[k]];
      triangle.mids[k] = tet.mids[edge_between(corner[k], corner[(k + 1) % 3])];
    }
    return triangle;
  }

  /// One name may be a node set, a surface and an element set at once: its nodes are those of the
  /// node set, else of the surface.
  void publish_sets() {
    for (const auto& [key, named] : node_sets_) {
      RawMesh::Set& set = raw_.sets[named.first];
      set.nodes = named.second.nodes;
      set.node_list = true;
      set.line = named.second.line;
    }
    for (const auto& [key, elements] : element_sets_) {
      const bool named_before = raw_.sets.count(elements.name) > 0;
      RawMesh::Set& set = raw_.sets[elements.name];
      if (!named_before) set.line = elements.line;
      set.tets_apart = named_before;
      for (std::int64_t tag : elements.elements) {
        const RawMesh::Tetrahedron& element = tet(tag, elements.line);
        set.tets.push_back(tag);
        if (named_before) continue;
        set.nodes.insert(element.nodes.begin(), element.nodes.end());
        if (element.second_order) set.nodes.insert(element.mids.begin(), element.mids.end());
      }
    }
  }

  TextScanner in_;
  RawMesh raw_;
  int line_ = 0;
  Mode mode_ = Mode::None;
  bool generate_ = false;
  std::string target_;
  std::map<std::string, std::string> parameters_;
  std::vector<std::int64_t> pending_;
  int pending_line_ = 0;
  std::size_t nodes_ = 4;  ///< of an element of the present block
  std::map<std::string, std::pair<std::string, RawMesh::Set>> node_sets_;
  std::map<std::string, ElementSet> element_sets_;
  std::vector<SurfaceRow> surfaces_;
};

}  // namespace

RawMesh read_inp(const std::filesystem::path& file) { return InpReader(file).read(); }

}  // namespace tandem::fem

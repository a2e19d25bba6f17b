#include "fem_process/mesh/deck_rows.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem_process/mesh/text_scanner.h"

namespace tandem::fem {
namespace {

/// The set of that name, a new one if there is none. Abaqus compares names without case; they keep
/// the spelling of their first mention.
DeckScope::Set& set_of(std::map<std::string, DeckScope::Set>& sets, const std::string& name,
                       int line) {
  DeckScope::Set& set = sets[deck_key(name)];
  if (set.line == 0) {
    set.name = name;
    set.line = line;
  }
  return set;
}

}  // namespace

const std::string* parameter(const DeckLine& line, std::string_view key) {
  for (const DeckLine::Parameter& parameter : line.parameters) {
    if (parameter.key == key) return &parameter.value;
  }
  return nullptr;
}

std::string needed(const DeckLexer& in, const DeckLine& line, std::string_view key) {
  const std::string* const value = parameter(line, key);
  const std::string name = "the parameter " + std::string(key) + "=";
  if (value == nullptr) in.fail(line.line, name + " is missing. Add it.");
  if (value->empty()) in.fail(line.line, name + " is empty. Write a name behind it.");
  return *value;
}

void allow(const DeckLexer& in, const DeckLine& line,
           std::initializer_list<std::string_view> keys) {
  for (const DeckLine::Parameter& parameter : line.parameters) {
    if (std::find(keys.begin(), keys.end(), parameter.key) != keys.end()) continue;
    std::string list;
    for (std::string_view key : keys) list += (list.empty() ? "" : ", ") + std::string(key);
    in.fail(line.line, "*" + line.keyword + " with the parameter '" + parameter.key +
                           "' is not read: it could change what the rows mean. Write the deck "
                           "without it; read are " +
                           list + ".");
  }
}

std::vector<double> reals(const DeckLexer& in, const DeckLine& line, std::size_t most) {
  std::vector<double> values(most, 0.0);
  if (line.fields.size() > most) {
    in.fail(line.line, "a row of more than " + std::to_string(most) + " numbers. Correct it.");
  }
  for (std::size_t k = 0; k < line.fields.size(); ++k) {
    if (line.fields[k].empty() || deck_real(line.fields[k], values[k])) continue;
    in.fail(line.line,
            in_quotes(line.fields[k]) + " where a number should be. Write a finite number.");
  }
  return values;
}

void include_input(DeckLexer& in, const DeckLine& line) {
  const DeckKeyword kind = kind_of_keyword(line.keyword);
  if (kind != DeckKeyword::Node && kind != DeckKeyword::Element) return;
  if (parameter(line, "INPUT") != nullptr) in.include(needed(in, line, "INPUT"), line.line);
}

void DeckRows::begin(DeckKeyword kind, const DeckLine& line, DeckScope& scope) {
  kind_ = kind;
  scope_ = &scope;
  set_ = nullptr;
  surface_ = nullptr;
  instance_.clear();
  generate_ = false;
  switch (kind) {
    case DeckKeyword::Node:
      return begin_node(line);
    case DeckKeyword::Element:
      return begin_element(line);
    case DeckKeyword::Nset:
    case DeckKeyword::Elset:
      return begin_set(line, kind == DeckKeyword::Nset);
    case DeckKeyword::Surface:
      return begin_surface(line);
    default:
      allow(in_, line, {});
      reset_system();
      system_rows_ = 0;
  }
}

void DeckRows::begin_node(const DeckLine& line) {
  allow(in_, line, {"NSET", "SYSTEM", "INPUT", "INTERNAL"});
  const std::string* const system = parameter(line, "SYSTEM");
  const std::string kind = system == nullptr ? "R" : deck_key(*system);
  if (kind != "R" && kind != "C") {
    in_.fail(line.line, "*NODE, SYSTEM=" + kind +
                            " is not read, R (Cartesian) and C (cylindrical) are. Write Cartesian "
                            "coordinates.");
  }
  cylindrical_ = kind == "C";
  if (parameter(line, "NSET") != nullptr) {
    set_ = &set_of(scope_->node_sets, needed(in_, line, "NSET"), line.line);
  }
  include_input(in_, line);
}

void DeckRows::begin_element(const DeckLine& line) {
  allow(in_, line, {"TYPE", "ELSET", "INPUT", "INTERNAL"});
  type_ = deck_key(needed(in_, line, "TYPE"));
  element_type_ = deck_element_type(type_);
  if (element_type_.shape == DeckShape::Solid) {
    in_.fail(line.line, "element type " + type_ +
                            " is not read: of solids only the tetrahedra C3D4 and C3D10 are, and "
                            "without these elements the body would miss their volume. Mesh with "
                            "tetrahedra (Abaqus/CAE: Mesh Controls, Tet; Gmsh: no recombination), "
                            "or delete the block.");
  }
  const bool tets = element_type_.shape == DeckShape::Tetrahedron;
  const std::string plain = "C3D" + std::to_string(element_type_.nodes);
  if (tets && type_ != plain) notes_.once(type_ + " was taken for " + plain, line.line);
  if (parameter(line, "ELSET") != nullptr) {
    set_ = &set_of(scope_->element_sets, needed(in_, line, "ELSET"), line.line);
  }
  include_input(in_, line);
}

void DeckRows::begin_set(const DeckLine& line, bool of_nodes) {
  if (of_nodes) {
    allow(in_, line, {"NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"});
  } else {
    allow(in_, line, {"ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"});
  }
  set_ = &set_of(of_nodes ? scope_->node_sets : scope_->element_sets,
                 needed(in_, line, of_nodes ? "NSET" : "ELSET"), line.line);
  generate_ = parameter(line, "GENERATE") != nullptr;
  if (parameter(line, "INSTANCE") != nullptr) {
    const std::string name = needed(in_, line, "INSTANCE");
    instance_ = deck_key(name);
    const bool known =
        scope_ == &deck_.root && split_at_instance(deck_, name + ".").first == instance_;
    if (!known) {
      in_.fail(line.line, "there is no instance '" + name + "' before here. Correct INSTANCE=.");
    }
  }
  if (!of_nodes || parameter(line, "ELSET") == nullptr) return;
  const std::string elements = needed(in_, line, "ELSET");
  if (instance_.empty() && scope_->element_sets.count(deck_key(elements)) == 0) {
    in_.fail(line.line, "element set '" + elements + "' is not defined before here.");
  }
  set_->of[instance_].element_sets.insert(deck_key(elements));
}

void DeckRows::begin_surface(const DeckLine& line) {
  const std::string name = needed(in_, line, "NAME");
  const std::string* const given = parameter(line, "TYPE");
  const std::string type = given == nullptr ? "ELEMENT" : deck_key(*given);
  if ((type != "ELEMENT" && type != "NODE") || parameter(line, "COMBINE") != nullptr ||
      parameter(line, "CROP") != nullptr) {
    notes_.once("*SURFACE '" + name +
                    "' was passed over: only lists of element faces or nodes are "
                    "read (TYPE=ELEMENT, TYPE=NODE)",
                line.line);
    return;
  }
  allow(in_, line,
        {"NAME", "TYPE", "INTERNAL", "TRIM", "NOOFFSET", "NOTHICK", "SCALETHICK", "MAXRATIO",
         "FILLETRADIUS", "PROPERTY"});
  DeckScope::Surface& surface = scope_->surfaces[deck_key(name)];
  if (surface.line == 0) {
    surface.name = name;
    surface.line = line.line;
    surface.of_nodes = type == "NODE";
  }
  surface_ = &surface;
}

void DeckRows::row(const DeckLine& line) {
  switch (kind_) {
    case DeckKeyword::Node:
      return node(line);
    case DeckKeyword::Element:
      return element(line);
    case DeckKeyword::Nset:
    case DeckKeyword::Elset:
      return members(line);
    case DeckKeyword::Surface:
      return surface(line);
    default:
      return system(line);
  }
}

std::int64_t DeckRows::whole(const DeckLine& line, std::string_view field, const char* what) const {
  std::int64_t value = 0;
  if (!parse(field, value)) {
    in_.fail(line.line, in_quotes(field) + " where " + what + " should be. Write a whole number.");
  }
  return value;
}

/// Coordinates left out are zero. Behind them Abaqus may have the normal of beams and shells.
void DeckRows::node(const DeckLine& line) {
  if (line.fields.empty() || line.fields.size() > 7) {
    in_.fail(line.line, "a node row is: number, x, y, z. Correct it.");
  }
  const std::int64_t tag = whole(line, line.fields[0], "a node number");
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k < line.fields.size(); ++k) {
    double value = 0.0;
    if (!line.fields[k].empty() && !deck_real(line.fields[k], value)) {
      in_.fail(line.line,
               in_quotes(line.fields[k]) + " where a coordinate should be. Write a finite number.");
    }
    if (k <= 3) position(static_cast<Eigen::Index>(k) - 1) = value;
  }
  if (cylindrical_) {
    const double angle = position.y() * std::numbers::pi / 180.0;
    const double radius = position.x();
    position.x() = radius * std::cos(angle);
    position.y() = radius * std::sin(angle);
  }
  scope_->node_tags.push_back(tag);
  scope_->node_positions.push_back(system_ * position);
  scope_->node_lines.push_back(line.line);
  if (set_ != nullptr) set_->of[""].tags.add(tag);
}

/// An element's numbers may go on over several lines: up to the number of its nodes, or where that
/// is not known, while they end with a comma.
void DeckRows::element(const DeckLine& line) {
  if (pending_.empty()) pending_line_ = line.line;
  for (std::string_view field : line.fields) {
    pending_.push_back(whole(line, field, "a node number"));
  }
  const std::size_t nodes = element_type_.nodes;
  if (pending_.empty()) return;
  if (nodes == 0 ? line.goes_on : pending_.size() < nodes + 1) return;
  if (nodes > 0 && pending_.size() > nodes + 1) {
    in_.fail(line.line, row_is() + "; here are more.");
  }
  add_element();
}

void DeckRows::add_element() {
  const std::int64_t tag = pending_[0];
  if (element_type_.shape == DeckShape::Tetrahedron) {
    RawMesh::Tetrahedron tet{
        .tag = tag, .second_order = element_type_.nodes == 10, .line = pending_line_};
    std::copy_n(pending_.begin() + 1, 4, tet.nodes.begin());
    if (tet.second_order) std::copy_n(pending_.begin() + 5, 6, tet.mids.begin());
    scope_->tets.push_back(tet);
  } else {
    scope_->others.push_back(
        {tag, element_type_.shape, scope_->other_nodes.size(), pending_.size() - 1});
    scope_->other_nodes.insert(scope_->other_nodes.end(), pending_.begin() + 1, pending_.end());
    notes_.element(type_, pending_line_, element_type_.shape == DeckShape::Triangle);
  }
  if (set_ != nullptr) set_->of[""].tags.add(tag);
  pending_.clear();
}

std::string DeckRows::row_is() const {
  const bool tets = element_type_.shape == DeckShape::Tetrahedron;
  return "a " + (tets ? "C3D" + std::to_string(element_type_.nodes) : type_) +
         " row is: number and " + std::to_string(element_type_.nodes) + " nodes";
}

void DeckRows::finish() {
  if (pending_.empty()) return;
  if (element_type_.nodes == 0) return add_element();
  in_.fail(pending_line_, row_is() + "; here are " + std::to_string(pending_.size()) +
                              " numbers. The file may be truncated.");
}

void DeckRows::members(const DeckLine& line) {
  if (generate_) return generate(line);
  for (std::string_view field : line.fields) {
    std::int64_t tag = 0;
    if (parse(field, tag)) {
      set_->of[instance_].tags.add(tag);
    } else {
      name_in_set(line, std::string(field));
    }
  }
}

void DeckRows::generate(const DeckLine& line) {
  if (line.fields.size() != 2 && line.fields.size() != 3) {
    in_.fail(line.line, "GENERATE rows are: first, last, step.");
  }
  TagSet::Range range{.first = whole(line, line.fields[0], "the first number"),
                      .last = whole(line, line.fields[1], "the last number"),
                      .step = 1,
                      .line = line.line};
  if (line.fields.size() == 3) range.step = whole(line, line.fields[2], "the step");
  if (range.step == 0 && range.first == range.last) range.step = 1;
  if (range.step <= 0 || range.last < range.first) {
    in_.fail(line.line, "GENERATE from " + std::to_string(range.first) + " to " +
                            std::to_string(range.last) + " by " + std::to_string(range.step) +
                            " makes no sense for this mesh. Correct the row.");
  }
  set_->of[instance_].tags.add(range);
}

/// A set of the same kind: of this scope, which is put in as it is now, or of an instance; in the
/// assembly also `instance.number`.
void DeckRows::name_in_set(const DeckLine& line, const std::string& name) {
  const bool of_nodes = kind_ == DeckKeyword::Nset;
  auto& own = of_nodes ? scope_->node_sets : scope_->element_sets;
  if (!instance_.empty()) {
    set_->sets.emplace(instance_, deck_key(name));
    return;
  }
  const auto found = own.find(deck_key(name));
  if (found != own.end()) {
    const DeckScope::Set whole_set = found->second;  // may be the set itself
    for (const auto& [instance, members] : whole_set.of) {
      DeckScope::Members& target = set_->of[instance];
      target.tags.add(members.tags);
      target.element_sets.insert(members.element_sets.begin(), members.element_sets.end());
    }
    set_->sets.insert(whole_set.sets.begin(), whole_set.sets.end());
    return;
  }
  const auto [instance, rest] =
      scope_ == &deck_.root ? split_at_instance(deck_, name) : std::pair("", name);
  std::int64_t tag = 0;
  if (instance.empty()) {
    in_.fail(line.line, std::string(of_nodes ? "node" : "element") + " set '" + name +
                            "' is not defined before here.");
  }
  if (parse(rest, tag)) {
    set_->of[instance].tags.add(tag);
  } else {
    set_->sets.emplace(instance, deck_key(rest));
  }
}

void DeckRows::surface(const DeckLine& line) {
  if (surface_ == nullptr || line.fields.empty()) return;
  if (!surface_->of_nodes && line.fields.size() > 2) {
    in_.fail(line.line, "a surface row is: element or element set, face S1 to S4.");
  }
  surface_->rows.push_back(
      {std::string(line.fields[0]),
       line.fields.size() < 2 || surface_->of_nodes ? "" : deck_key(line.fields[1]), line.line});
}

/// First row: the origin a and a point b of the local x axis; second row: a point c of the local
/// xy plane. Axes left out are the global ones; with b alone, z is the global one.
void DeckRows::system(const DeckLine& line) {
  const std::vector<double> v = reals(in_, line, system_rows_ == 0 ? 6 : 3);
  if (system_rows_ == 0) {
    system_origin_ = {v[0], v[1], v[2]};
    system_.translation() = system_origin_;
    system_x_ = Eigen::Vector3d(v[3], v[4], v[5]) - system_origin_;
    if (line.fields.size() <= 3) system_x_ = Eigen::Vector3d::UnitX();
  }
  const Eigen::Vector3d in_plane = Eigen::Vector3d(v[0], v[1], v[2]) - system_origin_;
  const Eigen::Vector3d z =
      system_rows_ == 0 ? Eigen::Vector3d::UnitZ().eval() : system_x_.cross(in_plane).eval();
  const Eigen::Vector3d y = z.cross(system_x_);
  if (system_rows_ > 1 || !(y.norm() > 0.0) || !std::isfinite(y.norm())) {
    in_.fail(line.line,
             "*SYSTEM rows are: the origin and a point of the x axis; a point of the xy plane, not "
             "on that axis.");
  }
  system_.linear().col(0) = system_x_.normalized();
  system_.linear().col(1) = y.normalized();
  system_.linear().col(2) = system_.linear().col(0).cross(system_.linear().col(1));
  ++system_rows_;
}

}  // namespace tandem::fem

#include <algorithm>
#include <limits>
#include <set>
#include <unordered_map>

#include "fem_process/mesh/deck.h"
#include "fem_process/mesh/deck_lexer.h"
#include "fem_process/mesh/deck_surfaces.h"
#include "fem_process/mesh/text_scanner.h"

namespace tandem::fem {
namespace {

/// Nodes and elements of all sets together: sets that name each other could make more of a small
/// file than memory holds.
constexpr std::size_t kMostMembers = 20'000'000;

class DeckAssembly {
 public:
  DeckAssembly(const Deck& deck, RawMesh& raw) : deck_(deck), raw_(raw), surfaces_(raw, others_) {
    for (const DeckScope& instance : deck.instances) {
      index_[deck_key(instance.name)] = placed_.size();
      placed_.push_back({&instance, 0});
    }
    index_[""] = placed_.size();
    placed_.push_back({&deck.root, 0});
  }

  void run() {
    set_offsets();
    for (const Placed& placed : placed_) add(placed);
    count_names();
    for (const Placed& placed : placed_) publish_surfaces(placed);
    for (const Placed& placed : placed_) publish_node_sets(placed);
    for (const Placed& placed : placed_) publish_element_sets(placed);
    if (deck_.instances.size() > 1) publish_instances();
    surfaces_.note();
  }

 private:
  struct Placed {
    const DeckScope* scope;
    std::int64_t offset;
  };

  // ---- numbers -------------------------------------------------------------------------------

  [[nodiscard]] bool collide() const {
    std::unordered_map<std::int64_t, const DeckScope*> nodes, elements;
    const auto taken = [](auto& owners, std::int64_t tag, const DeckScope* scope) {
      return owners.emplace(tag, scope).first->second != scope;
    };
    for (const Placed& placed : placed_) {
      const DeckScope& scope = *placed.scope;
      for (std::int64_t tag : scope.node_tags) {
        if (taken(nodes, tag, &scope)) return true;
      }
      for (const auto& tet : scope.tets) {
        if (taken(elements, tet.tag, &scope)) return true;
      }
      for (const auto& other : scope.others) {
        if (taken(elements, other.tag, &scope)) return true;
      }
    }
    return false;
  }

  [[nodiscard]] std::int64_t largest_tag() const {
    std::int64_t largest = 0;
    for (const Placed& placed : placed_) {
      for (std::int64_t tag : placed.scope->node_tags) largest = std::max(largest, tag);
      for (const auto& tet : placed.scope->tets) largest = std::max(largest, tet.tag);
      for (const auto& other : placed.scope->others) largest = std::max(largest, other.tag);
    }
    return largest;
  }

  void set_offsets() {
    if (deck_.instances.empty() || !collide()) return;
    const std::int64_t largest = largest_tag();
    const auto most = std::numeric_limits<std::int64_t>::max() /
                      static_cast<std::int64_t>(10 * (placed_.size() + 1));
    if (largest >= most) {
      raw_.fail(1, "number " + std::to_string(largest) +
                       " leaves no numbers for the other instances. Number the nodes and "
                       "elements of the parts from 1.");
    }
    std::int64_t step = 10;
    while (step <= largest) step *= 10;
    bool instances = false;
    for (std::size_t k = 1; k < placed_.size(); ++k) {
      placed_[k].offset = static_cast<std::int64_t>(k) * step;
      instances = instances || k + 1 < placed_.size();
    }
    if (!instances) return;
    raw_.notes.push_back("numbers of instances: n of '" + deck_.instances[1].name + "' is " +
                         std::to_string(step) + " + n" +
                         (deck_.instances.size() > 2 ? ", and so on" : ""));
  }

  void add(const Placed& placed) {
    const DeckScope& scope = *placed.scope;
    for (std::size_t i = 0; i < scope.node_tags.size(); ++i) {
      raw_.add_node(scope.node_tags[i] + placed.offset, scope.placement * scope.node_positions[i],
                    scope.node_lines[i]);
    }
    for (RawMesh::Tetrahedron tet : scope.tets) {
      tet.tag += placed.offset;
      for (std::int64_t& tag : tet.nodes) tag += placed.offset;
      for (std::int64_t& tag : tet.mids) tag += placed.offset;
      raw_.add_tet(tet);
    }
    for (const DeckScope::Other& other : scope.others) {
      OtherElement& element = others_[other.tag + placed.offset];
      element.shape = other.shape;
      element.nodes.clear();
      for (std::size_t k = 0; k < other.count; ++k) {
        element.nodes.push_back(scope.other_nodes[other.first + k] + placed.offset);
      }
    }
  }

  // ---- members -------------------------------------------------------------------------------

  [[nodiscard]] const Placed& placed(const std::string& instance, int line) const {
    const auto found = index_.find(instance);
    if (found == index_.end()) {
      raw_.fail(line, "there is no instance '" + instance + "'. Correct the name.");
    }
    return placed_[found->second];
  }

  void count(std::size_t more, int line) {
    members_ += more;
    if (members_ > kMostMembers) {
      raw_.fail(line, "the sets up to here have more than " + std::to_string(kMostMembers) +
                          " members. Delete sets that are not needed.");
    }
  }

  void expand(const TagSet& set, const Placed& of, std::size_t most, int line,
              std::vector<std::int64_t>& tags) {
    count(set.tags().size(), line);
    for (std::int64_t tag : set.tags()) tags.push_back(tag + of.offset);
    for (const TagSet::Range& range : set.ranges()) {
      // From either end of the range of numbers to the other the difference itself is none.
      std::int64_t span = 0;
      if (__builtin_sub_overflow(range.last, range.first, &span) ||
          static_cast<std::uint64_t>(span / range.step) >= most) {
        raw_.fail(range.line, "GENERATE from " + std::to_string(range.first) + " to " +
                                  std::to_string(range.last) + " by " + std::to_string(range.step) +
                                  " makes no sense for this mesh. Correct the row.");
      }
      count(static_cast<std::size_t>(span / range.step) + 1, range.line);
      for (std::int64_t k = 0; k <= span / range.step; ++k) {
        tags.push_back(range.first + k * range.step + of.offset);
      }
    }
  }

  using Sets = std::map<std::string, DeckScope::Set> DeckScope::*;

  const DeckScope::Set& whole_set(Sets kind, const std::pair<std::string, std::string>& name,
                                  int line) const {
    const auto& sets = placed(name.first, line).scope->*kind;
    const auto found = sets.find(name.second);
    if (found == sets.end()) {
      raw_.fail(line, "instance '" + name.first + "' has no set '" + name.second +
                          "'. Correct the name.");
    }
    return found->second;
  }

  /// Sets of the assembly name sets of instances, which name none but their own: two levels.
  std::vector<std::int64_t> elements_of(const DeckScope::Set& set, const Placed& own) {
    std::vector<std::int64_t> tags;
    for (const auto& [instance, members] : set.of) {
      const Placed& of = instance.empty() ? own : placed(instance, set.line);
      expand(members.tags, of, of.scope->elements(), set.line, tags);
    }
    for (const auto& name : set.sets) {
      const DeckScope::Set& whole = whole_set(&DeckScope::element_sets, name, set.line);
      const auto more = elements_of(whole, placed(name.first, set.line));
      tags.insert(tags.end(), more.begin(), more.end());
    }
    std::sort(tags.begin(), tags.end());
    tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
    return tags;
  }

  std::vector<std::int64_t> nodes_of(const DeckScope::Set& set, const Placed& own) {
    std::vector<std::int64_t> tags;
    for (const auto& [instance, members] : set.of) {
      const Placed& of = instance.empty() ? own : placed(instance, set.line);
      expand(members.tags, of, of.scope->node_tags.size(), set.line, tags);
      for (const std::string& elements : members.element_sets) {
        const auto found = of.scope->element_sets.find(elements);
        if (found == of.scope->element_sets.end()) {
          raw_.fail(set.line, "element set '" + elements + "' is not defined.");
        }
        for (std::int64_t tag : elements_of(found->second, of)) {
          surfaces_.add_nodes(tag, set.line, tags);
        }
      }
    }
    for (const auto& name : set.sets) {
      const DeckScope::Set& whole = whole_set(&DeckScope::node_sets, name, set.line);
      const auto more = nodes_of(whole, placed(name.first, set.line));
      tags.insert(tags.end(), more.begin(), more.end());
    }
    return tags;
  }

  // ---- names ---------------------------------------------------------------------------------

  void count_names() {
    for (const Placed& placed : placed_) {
      std::set<std::string> names;
      for (const auto& [key, set] : placed.scope->node_sets) names.insert(key);
      for (const auto& [key, set] : placed.scope->element_sets) names.insert(key);
      for (const auto& [key, set] : placed.scope->surfaces) names.insert(key);
      for (const std::string& name : names) ++owners_[name];
    }
  }

  [[nodiscard]] std::vector<std::string> names_of(const Placed& placed,
                                                  const std::string& name) const {
    if (placed.scope == &deck_.root) return {name};
    std::vector<std::string> names{placed.scope->name + "." + name};
    if (owners_.at(deck_key(name)) == 1) names.push_back(name);
    return names;
  }

  void publish_surfaces(const Placed& placed) {
    for (const auto& [key, surface] : placed.scope->surfaces) {
      RawMesh::Set set;
      set.line = surface.line;
      for (const DeckScope::SurfaceRow& row : surface.rows) {
        if (surface.of_nodes) {
          add_surface_nodes(row, placed, set);
        } else {
          surfaces_.add(surface_elements(row, placed), row.face, row.line, set);
        }
      }
      set.node_list = surface.of_nodes;
      for (const std::string& name : names_of(placed, surface.name)) raw_.sets[name] = set;
    }
  }

  /// The scope and the name or number that a surface's row means.
  std::pair<const Placed*, std::string> owner_of(const std::string& item, const Placed& own,
                                                 int line) const {
    if (own.scope == &deck_.root && item.find('.') != std::string::npos &&
        own.scope->element_sets.count(deck_key(item)) == 0) {
      const auto [instance, rest] = split_at_instance(deck_, item);
      return {&placed(instance, line), rest};
    }
    return {&own, item};
  }

  std::vector<std::int64_t> surface_elements(const DeckScope::SurfaceRow& row, const Placed& own) {
    const auto [owner, item] = owner_of(row.item, own, row.line);
    std::int64_t single = 0;
    if (parse(item, single)) {
      count(1, row.line);
      return {single + owner->offset};
    }
    const auto found = owner->scope->element_sets.find(deck_key(item));
    if (found == owner->scope->element_sets.end()) {
      raw_.fail(row.line, "element set '" + row.item + "' is not defined.");
    }
    return elements_of(found->second, *owner);
  }

  void add_surface_nodes(const DeckScope::SurfaceRow& row, const Placed& own, RawMesh::Set& set) {
    const auto [owner, item] = owner_of(row.item, own, row.line);
    std::int64_t single = 0;
    if (parse(item, single)) {
      set.nodes.insert(single + owner->offset);
      return;
    }
    const auto found = owner->scope->node_sets.find(deck_key(item));
    if (found == owner->scope->node_sets.end()) {
      raw_.fail(row.line, "node set '" + row.item + "' is not defined.");
    }
    const std::vector<std::int64_t> nodes = nodes_of(found->second, *owner);
    set.nodes.insert(nodes.begin(), nodes.end());
  }

  void publish_node_sets(const Placed& placed) {
    for (const auto& [key, named] : placed.scope->node_sets) {
      const std::vector<std::int64_t> nodes = nodes_of(named, placed);
      for (const std::string& name : names_of(placed, named.name)) {
        RawMesh::Set& set = raw_.sets[name];
        set.nodes = {nodes.begin(), nodes.end()};
        set.node_list = true;
        set.line = named.line;
      }
    }
  }

  /// One name may be a node set, a surface and an element set at once: its nodes are those of the
  /// node set, else of the surface.
  void publish_element_sets(const Placed& placed) {
    for (const auto& [key, named] : placed.scope->element_sets) {
      const std::vector<std::int64_t> elements = elements_of(named, placed);
      for (const std::string& name : names_of(placed, named.name)) {
        publish_elements(name, elements, named.line);
      }
    }
  }

  void publish_elements(const std::string& name, const std::vector<std::int64_t>& elements,
                        int line) {
    const bool named_before = raw_.sets.count(name) > 0;
    RawMesh::Set& set = raw_.sets[name];
    if (!named_before) set.line = line;
    set.tets_apart = named_before;
    std::vector<std::int64_t> nodes;
    for (std::int64_t tag : elements) {
      surfaces_.add_nodes(tag, line, nodes);
      if (raw_.tet_index.count(tag) > 0) {
        set.tets.push_back(tag);
      } else if (!named_before) {
        surfaces_.add_other(tag, set);
      }
    }
    if (!named_before) set.nodes.insert(nodes.begin(), nodes.end());
  }

  void publish_instances() {
    for (std::size_t k = 0; k + 1 < placed_.size(); ++k) {
      const DeckScope& scope = *placed_[k].scope;
      if (scope.tets.empty() || raw_.sets.count(scope.name) > 0) continue;
      std::vector<std::int64_t> elements;
      for (const auto& tet : scope.tets) elements.push_back(tet.tag + placed_[k].offset);
      publish_elements(scope.name, elements, scope.tets.front().line);
    }
  }

  const Deck& deck_;
  RawMesh& raw_;
  OtherElements others_;
  DeckSurfaces surfaces_;
  std::vector<Placed> placed_;                ///< the instances, then the root
  std::map<std::string, std::size_t> index_;  ///< into `placed_` by instance, "" for the root
  std::map<std::string, int> owners_;         ///< scopes that have a set of the name
  std::size_t members_ = 0;
};

}  // namespace

void assemble(const Deck& deck, RawMesh& raw) { DeckAssembly(deck, raw).run(); }

std::pair<std::string, std::string> split_at_instance(const Deck& deck, const std::string& name) {
  for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', dot + 1)) {
    const std::string key = deck_key(name.substr(0, dot));
    for (const DeckScope& instance : deck.instances) {
      if (deck_key(instance.name) == key) return {key, name.substr(dot + 1)};
    }
  }
  return {"", name};
}

}  // namespace tandem::fem

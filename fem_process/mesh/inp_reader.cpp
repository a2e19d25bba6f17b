// Decks of Abaqus and CalculiX: nodes, tetrahedra, sets and surfaces, flat or in parts, instances
// and an assembly [Abaqus Keywords Guide; CalculiX CrunchiX User's Manual].
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <numbers>
#include <utility>

#include "fem_process/mesh/deck.h"
#include "fem_process/mesh/deck_keywords.h"
#include "fem_process/mesh/deck_lexer.h"
#include "fem_process/mesh/deck_notes.h"
#include "fem_process/mesh/deck_rows.h"
#include "fem_process/mesh/raw_mesh.h"

namespace tandem::fem {
namespace {

/// Nodes and elements of all instances together: many instances of a part make more of a small
/// file than memory holds.
constexpr std::size_t kMostPlaced = 20'000'000;

class InpReader {
 public:
  explicit InpReader(const std::filesystem::path& file) : in_(file), rows_(in_, deck_, notes_) {
    raw_.file = file;
  }

  RawMesh read() {
    DeckLine line;
    while (in_.next(line)) {
      if (line.is_keyword) {
        rows_.finish();
        keyword(line);
      } else {
        data(line);
      }
    }
    rows_.finish();
    raw_.lines = in_.lines();
    refuse_unknown();
    require_closed();
    place_parts_without_instances();
    notes_.step(in_.step_line());
    raw_.notes = notes_.lines(raw_.lines);
    assemble(deck_, raw_);
    return std::move(raw_);
  }

 private:
  enum class Rows { None, PassOver, Geometry, Placement };

  [[noreturn]] void fail(int line, const std::string& text) const { in_.fail(line, text); }

  void keyword(const DeckLine& line) {
    mode_ = Rows::PassOver;
    const DeckKeyword kind = kind_of_keyword(line.keyword);
    switch (kind) {
      case DeckKeyword::Node:
      case DeckKeyword::Element:
      case DeckKeyword::Nset:
      case DeckKeyword::Elset:
      case DeckKeyword::Surface:
      case DeckKeyword::System:
        mode_ = Rows::Geometry;
        return rows_.begin(kind, line, *scope_);
      case DeckKeyword::Part:
        return begin_part(line);
      case DeckKeyword::Instance:
        return begin_instance(line);
      case DeckKeyword::Assembly:
        require_root(line);
        in_assembly_ = line.line;
        return;
      case DeckKeyword::EndPart:
      case DeckKeyword::EndInstance:
      case DeckKeyword::EndAssembly:
        return end(kind, line);
      case DeckKeyword::ChangesMesh:
        fail(line.line, "*" + line.keyword +
                            " makes, moves or imports nodes or elements, which is not read. Write "
                            "the mesh out as *NODE and *ELEMENT.");
      case DeckKeyword::Unknown:
        unknown_.emplace_back(line.keyword, line.line);
        return;
      default:
        notes_.passed_over(line.keyword, line.line, kind == DeckKeyword::Connects);
    }
  }

  void data(const DeckLine& line) {
    switch (mode_) {
      case Rows::None:
        fail(line.line, "data before the first keyword. Begin with *NODE.");
      case Rows::PassOver:
        return;
      case Rows::Geometry:
        return rows_.row(line);
      case Rows::Placement:
        return placement(line);
    }
  }

  // ---- parts, instances, assembly ------------------------------------------------------------

  void require_root(const DeckLine& line) const {
    if (scope_ == &deck_.root && in_assembly_ == 0) return;
    fail(line.line, "*" + line.keyword + " within " +
                        (scope_ == &deck_.root ? "*ASSEMBLY" : "'" + scope_->name + "'") +
                        ", which does not end before. Write its *END line.");
  }

  std::string named(const DeckLine& line, const char* key,
                    std::initializer_list<std::string_view> allowed) const {
    allow(in_, line, allowed);
    return needed(in_, line, key);
  }

  void begin_part(const DeckLine& line) {
    require_root(line);
    const std::string name = named(line, "NAME", {"NAME"});
    const auto [part, is_new] = parts_.emplace(deck_key(name), DeckScope{});
    if (!is_new) fail(line.line, "part '" + name + "' is defined twice. Rename one of them.");
    scope_ = &part->second;
    scope_->name = name;
    open_ = {DeckKeyword::EndPart, line.line};
  }

  void begin_instance(const DeckLine& line) {
    if (scope_ != &deck_.root) {
      fail(line.line, "*INSTANCE within '" + scope_->name +
                          "', which does not end before. Write its *END line.");
    }
    if (parameter(line, "LIBRARY") != nullptr || parameter(line, "INSTANCE") != nullptr) {
      fail(line.line,
           "*INSTANCE with LIBRARY or INSTANCE takes the part from results of another analysis, "
           "which is not read. Write the part's mesh into the deck.");
    }
    const std::string name = named(line, "NAME", {"NAME", "PART"});
    const std::string part = needed(in_, line, "PART");
    const auto found = parts_.find(deck_key(part));
    if (found == parts_.end()) {
      fail(line.line, "part '" + part + "' is not defined before here. Correct PART=.");
    }
    for (const DeckScope& other : deck_.instances) {
      if (deck_key(other.name) == deck_key(name)) {
        fail(line.line, "instance '" + name + "' is defined twice. Rename one of them.");
      }
    }
    placed_ += found->second.size() + 1;
    if (placed_ > kMostPlaced) {
      fail(line.line, "the instances up to here have more than " + std::to_string(kMostPlaced) +
                          " nodes and elements. Mesh coarser.");
    }
    scope_ = &deck_.instances.emplace_back(found->second);
    scope_->name = name;
    open_ = {DeckKeyword::EndInstance, line.line};
    placement_rows_ = 0;
    mode_ = Rows::Placement;
  }

  /// The first row moves, the second turns the moved instance about the axis from a to b.
  void placement(const DeckLine& line) {
    const std::size_t most = placement_rows_ == 0 ? 3 : 7;
    const std::vector<double> v = reals(in_, line, most);
    const Eigen::Vector3d a(v[0], v[1], v[2]);
    if (placement_rows_ == 0) {
      scope_->placement = Eigen::Translation3d(a);
    } else if (placement_rows_ == 1) {
      const Eigen::Vector3d axis = Eigen::Vector3d(v[3], v[4], v[5]) - a;
      if (!(axis.norm() > 0.0) || !std::isfinite(axis.norm()) || line.fields.size() != 7) {
        fail(line.line, "a rotation row is: x, y, z of two points of the axis, angle in degrees.");
      }
      const Eigen::AngleAxisd turn(v[6] * std::numbers::pi / 180.0, axis.normalized());
      scope_->placement =
          Eigen::Translation3d(a) * turn * Eigen::Translation3d(-a) * scope_->placement;
    } else {
      fail(line.line, "*INSTANCE has two rows at most: translation and rotation.");
    }
    ++placement_rows_;
  }

  void end(DeckKeyword kind, const DeckLine& line) {
    const bool assembly = kind == DeckKeyword::EndAssembly;
    const bool fits = assembly ? in_assembly_ != 0 && scope_ == &deck_.root : open_.first == kind;
    if (!fits) fail(line.line, "*" + line.keyword + " without its beginning. Delete it.");
    scope_ = &deck_.root;
    rows_.reset_system();
    if (assembly) in_assembly_ = 0;
    open_ = {DeckKeyword::Unknown, 0};
  }

  void require_closed() const {
    if (open_.second == 0 && in_assembly_ == 0) return;
    fail(open_.second != 0 ? open_.second : in_assembly_,
         "what begins here has no *END line. The file may be truncated.");
  }

  /// A deck that has parts alone: each where it is.
  void place_parts_without_instances() {
    if (!deck_.instances.empty()) return;
    for (auto& [key, part] : parts_) deck_.instances.push_back(std::move(part));
  }

  void refuse_unknown() const {
    if (unknown_.empty()) return;
    std::string others;
    for (std::size_t k = 1; k < unknown_.size() && k < 6; ++k) {
      others += (k == 1 ? " So are: *" : ", *") + unknown_[k].first + " (" +
                raw_.lines.named(unknown_[k].second) + ")";
    }
    fail(unknown_.front().second,
         "*" + unknown_.front().first + " is no known keyword of Abaqus or CalculiX." +
             keyword_meant(unknown_.front().first) +
             " If it leaves nodes, elements and sets alone, delete it with its rows." + others +
             (others.empty() ? "" : "."));
  }

  DeckLexer in_;
  Deck deck_;
  DeckNotes notes_;
  DeckRows rows_;
  RawMesh raw_;
  std::map<std::string, DeckScope> parts_;
  DeckScope* scope_ = &deck_.root;
  Rows mode_ = Rows::None;
  std::pair<DeckKeyword, int> open_{DeckKeyword::Unknown, 0};  ///< awaited end of part or instance
  int in_assembly_ = 0;                                        ///< the line that began it
  int placement_rows_ = 0;
  std::size_t placed_ = 0;
  std::vector<std::pair<std::string, int>> unknown_;
};

}  // namespace

RawMesh read_inp(const std::filesystem::path& file) { return InpReader(file).read(); }

std::vector<std::filesystem::path> included_files(const std::filesystem::path& file) {
  DeckLexer in(file);
  DeckLine line;
  while (in.next(line)) {
    if (line.is_keyword) include_input(in, line);
  }
  return in.included();
}

}  // namespace tandem::fem

#include "protocol/scenario/yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <sstream>
#include <utility>

#include "protocol/scenario/data.h"

namespace tandem::scenario {
namespace {

using Kind = YamlValue::Kind;

/// Builds the tree from the parser's events: the parser's own tree drops duplicate keys, quotes
/// and anchors.
class TreeBuilder final : public YAML::EventHandler {
 public:
  TreeBuilder(std::string file, std::optional<Place> fixed, std::vector<Defect>& defects)
      : file_(std::move(file)), fixed_(std::move(fixed)), defects_(defects) {}

  [[nodiscard]] Place place(const YAML::Mark& mark) const {
    return fixed_ ? *fixed_ : Place{file_, mark.line + 1, mark.column + 1};
  }
  [[nodiscard]] YamlValue take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ == 2) {
      defects_.push_back({place(mark), "",
                          "a second document ('---') or a stray character stands here. A scenario "
                          "is one mapping; indent what belongs to it."});
    }
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    YamlValue value;
    value.place = place(mark);
    add(std::move(value));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override {
    defects_.push_back(
        {place(mark), path(), "aliases (*name) are not supported. Write the value out."});
    YamlValue value;
    value.kind = Kind::Refused;
    value.place = place(mark);
    add(std::move(value));
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    add(yaml_scalar(text, tag == "!", place(mark)));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(Kind::List, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(Kind::Mapping, mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YamlValue value;
    std::optional<YamlEntry> entry;  // key seen, value to come
    bool drop = false;               // the key is refused, and its value with it
  };

  [[nodiscard]] std::string path() const {
    std::string joined;
    for (auto level = open_.begin(); level != open_.end(); ++level) {
      if (level->value.kind == Kind::List) {
        const auto inner = std::next(level);
        const YamlValue* name = inner != open_.end() ? inner->value.find("name") : nullptr;
        joined = join_path(
            joined, name != nullptr ? name->text : std::to_string(level->value.items.size()));
      } else if (level->entry) {
        joined = join_path(joined, level->entry->key);
      }
    }
    return joined;
  }

  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor == 0) return;
    defects_.push_back({place(mark), path(),
                        "anchors (&name) are not supported. Write the value out at each place."});
  }
  // The parser's own tags: "?" for plain scalars and collections, "!" for quoted scalars.
  void refuse_tag(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?" || tag == "!") return;
    defects_.push_back({place(mark), path(),
                        fmt::format("the tag {} is not supported. Write plain values.", tag)});
  }
  void open(Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    Open level;
    level.value.kind = kind;
    level.value.place = place(mark);
    open_.push_back(std::move(level));
  }
  void close() {
    YamlValue value = std::move(open_.back().value);
    open_.pop_back();
    add(std::move(value));
  }
  void add(YamlValue value) {
    if (open_.empty()) {
      if (documents_ <= 1) root_ = std::move(value);
      return;
    }
    Open& level = open_.back();
    // The parser places a missing value at the next word of the file, maybe lines below.
    if (value.kind == Kind::Null)
      value.place = level.entry ? level.entry->place : level.value.place;
    if (level.value.kind == Kind::List) {
      level.value.items.push_back(std::move(value));
    } else if (!level.entry) {
      level.entry = YamlEntry{value.text, value.place, {}};
      level.drop = refuse_key(level.value, value);
    } else {
      level.entry->value = std::move(value);
      if (!level.drop) level.value.entries.push_back(std::move(*level.entry));
      level.entry.reset();
    }
  }
  bool refuse_key(const YamlValue& mapping, const YamlValue& key) {
    const auto first = std::ranges::find(mapping.entries, key.text, &YamlEntry::key);
    std::string text;
    if (key.kind != Kind::Scalar) {
      text = "a key must be a word, not a list, a mapping or nothing.";
    } else if (key.text == "<<") {
      text = "merge keys are not supported. Write the merged keys out.";
    } else if (first != mapping.entries.end()) {
      text = fmt::format("is given twice; the first is at {}. Remove one of the two.",
                         first->place.text());
    } else {
      return false;
    }
    defects_.push_back({key.place, path(), text});
    return true;
  }

  std::string file_;
  std::optional<Place> fixed_;
  std::vector<Defect>& defects_;
  std::vector<Open> open_;
  YamlValue root_;
  int documents_ = 0;
};

std::optional<YamlValue> parse(const std::string& text, TreeBuilder builder,
                               std::vector<Defect>& defects) {
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    // Never more than two: before a stray ',' or ']' the parser finds empty documents for ever.
    if (parser.HandleNextDocument(builder)) parser.HandleNextDocument(builder);
  } catch (const YAML::Exception& error) {
    defects.push_back(
        {builder.place(error.mark), "",
         fmt::format("is not YAML here: {}. Check indentation, ':' and brackets.", error.msg)});
    return std::nullopt;
  }
  return builder.take();
}

/// Whether a line opens a block scalar ("key: |", "- >-"), below which tabs are text.
bool opens_block_scalar(std::string_view line) {
  const auto last = line.find_last_not_of(" \t\r");
  if (last == std::string_view::npos) return false;
  const auto mark = line.find_last_of("|>", last);
  if (mark == std::string_view::npos || mark < 2) return false;
  const std::string_view rest = line.substr(mark + 1, last - mark);
  return rest.find_first_not_of("+-0123456789") == std::string_view::npos &&
         line[mark - 1] == ' ' && (line[mark - 2] == ':' || line[mark - 2] == '-');
}

/// Tabs in the indentation: the parser takes some for spaces and gives strange errors for others.
void find_tabs(const std::string& text, const std::string& file, std::vector<Defect>& defects) {
  std::istringstream stream(text);
  std::string line;
  std::optional<std::size_t> block;  // indentation of the key that opened a block scalar
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos) continue;
    const std::size_t spaces = line.find_first_not_of(' ');
    if (block && spaces > *block) continue;
    block.reset();
    if (line[begin] != '#' && line[spaces] == '\t') {
      defects.push_back({{file, number, static_cast<int>(spaces) + 1},
                         "",
                         "a tab is used for indentation. Indent with spaces."});
    }
    if (opens_block_scalar(line)) block = spaces;
  }
}

}  // namespace

YamlValue* YamlValue::find(std::string_view key) {
  const auto entry = std::ranges::find(entries, key, &YamlEntry::key);
  return entry == entries.end() ? nullptr : &entry->value;
}

const YamlValue* YamlValue::find(std::string_view key) const {
  const auto entry = std::ranges::find(entries, key, &YamlEntry::key);
  return entry == entries.end() ? nullptr : &entry->value;
}

YamlValue yaml_scalar(std::string text, bool quoted, const Place& place) {
  YamlValue value;
  value.kind = Kind::Scalar;
  value.place = place;
  value.text = std::move(text);
  value.quoted = quoted;
  return value;
}

std::optional<YamlValue> parse_yaml(const std::string& text, const std::string& file,
                                    std::vector<Defect>& defects) {
  find_tabs(text, file, defects);
  if (!defects.empty()) return std::nullopt;
  return parse(text, TreeBuilder(file, std::nullopt, defects), defects);
}

std::optional<YamlValue> parse_yaml_at(const std::string& text, const Place& place,
                                       std::vector<Defect>& defects) {
  return parse(text, TreeBuilder(place.file, place, defects), defects);
}

}  // namespace tandem::scenario

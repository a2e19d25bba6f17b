#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "protocol/scenario/data.h"
#include "protocol/scenario/key_text.h"
#include "protocol/scenario/scenario_file.h"
#include "protocol/scenario/suggest.h"

namespace tandem::scenario {
namespace {

std::string cell(const std::string& text) {
  if (text.empty()) return "–";
  std::string out;
  for (const char c : text) {
    if (c == '|') out += '\\';
    out += c;
  }
  return out;
}

/// The link target that Markdown viewers give a heading.
std::string anchor(const std::string& heading) {
  std::string out;
  for (const char c : heading) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter) != 0 || c == '_' || c == '-') {
      out += static_cast<char>(std::tolower(letter));
    } else if (c == ' ') {
      out += '-';
    }
  }
  return out;
}

/// A page under construction: sections follow their parent, shared ones come once at the end.
class Page {
 public:
  void add(const Section& section, const std::string& path) {
    const std::string heading = section.shared || path.empty()
                                    ? section.title
                                    : fmt::format("{} ({})", section.title, path);
    out_ += fmt::format("## {}\n\n", heading);
    if (!section.doc.empty()) out_ += section.doc + "\n\n";
    out_ += "| key | type | unit | range | default | meaning |\n|---|---|---|---|---|---|\n";
    for (const Key& key : section.keys) add_row(key, section, path);
    out_ += "\n";
    for (const Key& key : section.keys) {
      if (!key.section) continue;
      if (!key.section->shared) {
        add(*key.section, child_path(path, key));
      } else if (seen_.insert(key.section->title).second) {
        shared_.push_back(key.section.get());
      }
    }
  }

  [[nodiscard]] std::string finish() {
    for (std::size_t i = 0; i < shared_.size(); ++i) add(*shared_[i], "");
    return std::move(out_);
  }

 private:
  static std::string child_path(const std::string& path, const Key& key) {
    const char* list = key.type == Type::Sections ? "[]" : "";
    return join_path(path, fmt::format("{}{}", key.name, list));
  }

  static std::string type_cell(const Key& key, const std::string& path) {
    if (!key.section) return type_text(key);
    const std::string title =
        key.section->shared ? key.section->title
                            : fmt::format("{} ({})", key.section->title, child_path(path, key));
    const std::string count = count_text(key);
    const std::string link = fmt::format("[{}](#{})", key.section->title, anchor(title));
    if (key.or_list) return fmt::format("{}, or a list of them with names", link);
    if (key.type == Type::Section) return link;
    return count.empty() ? fmt::format("list of {}", link)
                         : fmt::format("list of {} {}", count, link);
  }

  /// In a shared section a key without unit in its name is in the unit of the key that holds it.
  static std::string unit_cell(const Key& key, const Section& section) {
    const bool of_holder =
        section.shared && !key.unit.empty() && without_unit(key.name) == key.name;
    return of_holder ? "of the holding key" : key.unit;
  }

  void add_row(const Key& key, const Section& section, const std::string& path) {
    std::string meaning = key.doc;
    if (!key.when_key.empty()) {
      meaning +=
          fmt::format(" Only when `{}` is {}.", key.when_key, fmt::join(key.when_values, " or "));
    }
    const std::string by_default = key.required       ? "required"
                                   : key.default_text ? fmt::format("`{}`", *key.default_text)
                                                      : "";
    Key unitless = key;
    unitless.unit.clear();
    out_ += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.name, cell(type_cell(key, path)),
                        cell(unit_cell(key, section)), cell(range_text(unitless)), cell(by_default),
                        cell(meaning));
  }

  std::string out_;
  std::set<std::string> seen_;
  std::vector<const Section*> shared_;
};

}  // namespace

std::string reference_markdown(const Section& table, const std::string& title) {
  Page page;
  page.add(table, "");
  return fmt::format("# {}\n\n{}", title, page.finish());
}

}  // namespace tandem::scenario

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <regex>

#include "tests/architecture/source_tree.h"

namespace tandem::architecture {
namespace {

namespace fs = std::filesystem;

/// Anchor that GitHub makes of a heading: lower case, punctuation dropped, blanks to hyphens.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '_' || c == '-' || byte >= 0x80) {
      anchor += static_cast<char>(std::tolower(byte));
    } else if (c == ' ') {
      anchor += '-';
    }
  }
  return anchor;
}

std::vector<std::string> anchors_of(const SourceFile& page) {
  static const std::regex kHeading(R"(^#{1,6}\s+(.*?)\s*$)");
  std::vector<std::string> anchors;
  bool code = false;
  for (const std::string& line : page.lines) {
    if (line.starts_with("```")) code = !code;
    std::smatch match;
    if (!code && std::regex_match(line, match, kHeading)) anchors.push_back(anchor_of(match[1]));
  }
  return anchors;
}

/// What is wrong with a link, empty = nothing. `anchors` by page path.
std::string defect_of(const std::string& link, const std::string& page, const fs::path& root,
                      const std::map<std::string, std::vector<std::string>>& anchors) {
  static const std::regex kElsewhere("^(https?|mailto):.*");
  if (std::regex_match(link, kElsewhere)) return {};
  const auto hash = link.find('#');
  const std::string file = link.substr(0, hash);
  const std::string target =
      file.empty() ? page
                   : (fs::path(page).parent_path() / file).lexically_normal().generic_string();
  if (!fs::exists(root / target)) return fmt::format("'{}' does not exist", target);
  const auto known = anchors.find(target);
  if (hash == std::string::npos || known == anchors.end()) return {};
  const std::string anchor = link.substr(hash + 1);
  const bool there =
      std::find(known->second.begin(), known->second.end(), anchor) != known->second.end();
  return there ? "" : fmt::format("'{}' has no heading '#{}'", target, anchor);
}

}  // namespace

Findings find_broken_links(const std::vector<SourceFile>& tree, const fs::path& root) {
  static const std::regex kLink(R"re(\]\(([^)\s]+)\)|(?:src|href)="([^"]+)")re");
  std::map<std::string, std::vector<std::string>> anchors;
  for (const SourceFile& page : tree) {
    if (page.path.ends_with(".md")) anchors[page.path] = anchors_of(page);
  }
  Findings findings;
  for (const SourceFile& page : tree) {
    if (!page.path.ends_with(".md")) continue;
    for (std::size_t i = 0; i < page.lines.size(); ++i) {
      const std::string& line = page.lines[i];
      for (std::sregex_iterator link(line.begin(), line.end(), kLink), end; link != end; ++link) {
        const std::string target = (*link)[1].matched ? (*link)[1] : (*link)[2];
        const std::string defect = defect_of(target, page.path, root, anchors);
        if (!defect.empty()) findings.push_back(fmt::format("{}:{}: {}", page.path, i + 1, defect));
      }
    }
  }
  return findings;
}

Findings find_unnamed_examples(const std::vector<SourceFile>& tree) {
  std::string readme;
  for (const SourceFile& file : tree) {
    if (file.path != "README.md") continue;
    for (const std::string& line : file.lines) readme += line + "\n";
  }
  Findings findings;
  for (const SourceFile& file : tree) {
    if (!file.path.starts_with("examples/") || !file.path.ends_with(".yaml")) continue;
    if (readme.find(file.path) == std::string::npos) {
      findings.push_back(fmt::format("{}: the README does not name it", file.path));
    }
  }
  return findings;
}

}  // namespace tandem::architecture

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <regex>
#include <string_view>

#include "tests/architecture/source_tree.h"

namespace tandem::architecture {
namespace {

bool is_cpp(const SourceFile& file) {
  return file.path.ends_with(".h") || file.path.ends_with(".cpp");
}

/// Which of the repository's folders a folder may include, its own not repeated.
struct Layer {
  std::string_view folder;
  std::vector<std::string_view> below;
};
const std::vector<Layer>& layers() {
  static const std::vector<Layer> kLayers{
      {"protocol/contract/", {}},
      {"protocol/scenario/", {"protocol/contract/"}},
      {"protocol/schemes/", {"protocol/contract/", "protocol/scenario/"}},
      {"protocol/wire/", {"protocol/contract/"}},
      {"protocol/driver/",
       {"protocol/contract/", "protocol/scenario/", "protocol/schemes/", "protocol/wire/"}},
      {"mbs_process/", {"protocol/"}},
      {"fem_process/", {"protocol/"}},
      {"orchestrator/", {"protocol/", "mbs_process/", "fem_process/"}},
      {"tests/", {"protocol/", "mbs_process/", "fem_process/", "orchestrator/"}}};
  return kLayers;
}

/// The rooms of a folder, lower ones first: each may include those before it.
struct House {
  std::string_view folder;
  std::vector<std::string_view> rooms;
};
const std::vector<House>& houses() {
  static const std::vector<House> kHouses{
      {"fem_process/",
       {"kernels", "mesh", "matrix", "material", "elements", "solvers", "body", "ports", "turning",
        "transient", "reduced", "output", "ancf", "keys", "sides"}},
      {"orchestrator/",
       {"files", "process", "scenario", "verdict", "run", "record", "page", "warnings", "study",
        "advise", "bench", "commands"}}};
  return kHouses;
}

/// Which room of a house a path lies in; the number of rooms if in none.
std::size_t room_of(const House& house, std::string_view path) {
  path.remove_prefix(house.folder.size());
  const std::string_view room = path.substr(0, path.find('/'));
  const auto found = room.size() == path.size()
                         ? house.rooms.end()
                         : std::find(house.rooms.begin(), house.rooms.end(), room);
  return static_cast<std::size_t>(found - house.rooms.begin());
}

/// Headers beginning with `prefix` belong to files whose paths begin with one of `homes`. Tests may
/// use them too: they check against the library itself.
struct Confinement {
  std::string_view prefix;
  std::vector<std::string_view> homes;
};
const std::vector<Confinement>& confinements() {
  static const std::vector<Confinement> kConfinements{
      {"ode/", {"mbs_process/ode_world.", "mbs_process/ode_joint."}},
      {"lcm/", {"protocol/wire/"}},
      {"tandem_wire/", {"protocol/wire/"}},
      {"cholmod", {"fem_process/solvers/cholmod_solver."}},
      {"klu", {"fem_process/ancf/klu_solver."}},
      {"Spectra/", {"fem_process/reduced/modal_analysis."}},
      {"yaml-cpp/", {"protocol/scenario/yaml_tree."}},
      {"CLI/", {"orchestrator/", "protocol/driver/side_process."}}};
  return kConfinements;
}

bool begins_with_any(std::string_view text, const std::vector<std::string_view>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](std::string_view prefix) { return text.starts_with(prefix); });
}

/// Calls `visit(line number, name, quoted)` for each include of a C++ file.
template <class Visit>
void for_each_include(const SourceFile& file, Visit visit) {
  static const std::regex kInclude(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  for (std::size_t i = 0; i < file.lines.size(); ++i) {
    std::smatch match;
    if (std::regex_search(file.lines[i], match, kInclude)) {
      visit(i + 1, match[2].str(), match[1].str() == "\"");
    }
  }
}

}  // namespace

Findings find_forbidden_includes(const std::vector<SourceFile>& tree) {
  Findings findings;
  for (const SourceFile& file : tree) {
    if (!is_cpp(file)) continue;
    const auto layer = std::find_if(layers().begin(), layers().end(), [&](const Layer& candidate) {
      return file.path.starts_with(candidate.folder);
    });
    if (layer == layers().end()) {
      findings.push_back(fmt::format("{}: belongs to no folder of the layering", file.path));
      continue;
    }
    for_each_include(file, [&](std::size_t line, const std::string& name, bool quoted) {
      if (!quoted || name.starts_with(layer->folder) || begins_with_any(name, layer->below)) return;
      findings.push_back(
          fmt::format("{}:{}: {} must not include \"{}\"", file.path, line, layer->folder, name));
    });
  }
  return findings;
}

Findings find_misplaced_rooms(const std::vector<SourceFile>& tree) {
  Findings findings;
  for (const SourceFile& file : tree) {
    const auto house = std::find_if(houses().begin(), houses().end(), [&](const House& candidate) {
      return file.path.starts_with(candidate.folder);
    });
    if (!is_cpp(file) || house == houses().end()) continue;
    const std::size_t own = room_of(*house, file.path);
    if (own == house->rooms.size()) {
      findings.push_back(fmt::format("{}: stands in no room of {}", file.path, house->folder));
      continue;
    }
    for_each_include(file, [&](std::size_t line, const std::string& name, bool quoted) {
      if (!quoted || !name.starts_with(house->folder) || room_of(*house, name) <= own) return;
      findings.push_back(fmt::format("{}:{}: {} must not include \"{}\"", file.path, line,
                                     house->rooms[own], name));
    });
  }
  return findings;
}

Findings find_untold_rooms(const std::vector<SourceFile>& tree) {
  Findings findings;
  for (const House& house : houses()) {
    const std::string page = std::string(house.folder) + "README.md";
    const auto file = std::find_if(tree.begin(), tree.end(), [&](const SourceFile& candidate) {
      return candidate.path == page;
    });
    std::string headings, expected;
    if (file != tree.end()) {
      for (const std::string& line : file->lines) {
        if (line.starts_with("## ")) headings.append(" ").append(line, 3);
      }
    }
    for (std::string_view room : house.rooms) expected.append(" ").append(room);
    if (headings == expected) continue;
    findings.push_back(
        fmt::format("{}: its headings must be the rooms, lower ones first:{}", page, expected));
  }
  return findings;
}

Findings find_leaking_libraries(const std::vector<SourceFile>& tree) {
  Findings findings;
  for (const SourceFile& file : tree) {
    if (!is_cpp(file) || file.path.starts_with("tests/")) continue;
    for_each_include(file, [&](std::size_t line, const std::string& name, bool) {
      for (const Confinement& library : confinements()) {
        if (!name.starts_with(library.prefix) || begins_with_any(file.path, library.homes)) {
          continue;
        }
        findings.push_back(fmt::format("{}:{}: <{}> belongs to {}* alone", file.path, line, name,
                                       library.homes.front()));
      }
    });
  }
  return findings;
}

Findings find_long_files(const std::vector<SourceFile>& tree) {
  constexpr std::size_t kMostLines = 450;
  Findings findings;
  for (const SourceFile& file : tree) {
    if (!is_cpp(file) || file.lines.size() <= kMostLines) continue;
    findings.push_back(
        fmt::format("{}: {} lines, at most {}", file.path, file.lines.size(), kMostLines));
  }
  return findings;
}

Findings find_unfinished_marks(const std::vector<SourceFile>& tree) {
  // In two parts, or this file would be the first finding.
  static const std::regex kMark(std::string("\\b(TO") + "DO|FIX" + "ME|X" + "XX|HA" + "CK)\\b");
  Findings findings;
  for (const SourceFile& file : tree) {
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      std::smatch match;
      if (std::regex_search(file.lines[i], match, kMark)) {
        findings.push_back(fmt::format("{}:{}: {}", file.path, i + 1, match.str()));
      }
    }
  }
  return findings;
}

Findings find_unbuilt_sources(const std::vector<SourceFile>& tree) {
  const auto folder_of = [](const SourceFile& file) {
    return file.path.substr(0, file.path.rfind('/') + 1);
  };
  std::map<std::string, std::string> build;  // text of the CMake files of each folder
  for (const SourceFile& file : tree) {
    if (!file.path.ends_with("CMakeLists.txt") && !file.path.ends_with(".cmake")) continue;
    for (const std::string& line : file.lines) build[folder_of(file)] += line + "\n";
  }
  Findings findings;
  for (const SourceFile& file : tree) {
    if (!file.path.ends_with(".cpp")) continue;
    const bool listed = std::any_of(build.begin(), build.end(), [&](const auto& entry) {
      const auto& [folder, text] = entry;
      if (!file.path.starts_with(folder)) return false;
      const std::string name =
          std::regex_replace(file.path.substr(folder.size()), std::regex("\\."), "\\.");
      return std::regex_search(text, std::regex("(^|[\\s(])" + name + "($|[\\s)])"));
    });
    if (!listed) findings.push_back(fmt::format("{}: no CMake file names it", file.path));
  }
  return findings;
}

}  // namespace tandem::architecture

#include "protocol/scenario/scenario_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <tuple>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/contract/hash.h"
#include "protocol/scenario/data.h"
#include "protocol/scenario/override.h"
#include "protocol/scenario/validate.h"
#include "protocol/scenario/yaml_tree.h"

namespace tandem::scenario {
namespace {

std::string read_text(const std::filesystem::path& file) {
  std::error_code code;
  const auto status = std::filesystem::status(file, code);
  require(status.type() != std::filesystem::file_type::not_found,
          fmt::format("{}: there is no such file. Check the name and the working directory.",
                      file.string()));
  require(!std::filesystem::is_directory(status),
          fmt::format("{}: is a directory. Give the scenario file in it, for example {}.",
                      file.string(), (file / "scenario.yaml").string()));
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (stream && stream.peek() != std::ifstream::traits_type::eof()) text << stream.rdbuf();
  require(stream.is_open() && !stream.bad() && !text.bad(),
          fmt::format("{}: cannot be read ({}). Check its permissions.", file.string(),
                      errno != 0 ? std::strerror(errno) : "unknown cause"));
  return text.str();
}

/// One line per defect in the order of the file, --set last.
void throw_if_any(std::vector<Defect>& defects) {
  if (defects.empty()) return;
  std::ranges::stable_sort(defects, {}, [](const Defect& defect) {
    return std::tuple(defect.place.line == 0, defect.place.line, defect.place.column);
  });
  std::string lines;
  for (const Defect& defect : defects) {
    if (!lines.empty()) lines += '\n';
    lines += defect_line(defect);
  }
  throw Error(ErrorKind::Usage, lines);
}

std::uint64_t hash_of(const std::string& text) {
  StateHash hash;
  for (const char c : text) hash.add(std::uint64_t{static_cast<unsigned char>(c)});
  return hash.value();
}

}  // namespace

Loaded load(const std::filesystem::path& file, const Section& table,
            const std::vector<Override>& overrides, UnknownKeys unknown) {
  const std::string text = read_text(file);
  const Place top{file.string(), 1, 1};
  std::vector<Defect> defects;
  std::optional<YamlValue> root = parse_yaml(text, file.string(), defects);
  if (!root || root->kind != YamlValue::Kind::Mapping) throw_if_any(defects);
  if (root->kind == YamlValue::Kind::Null) {
    throw Error(ErrorKind::Usage,
                fmt::format("{}: the file is empty. A scenario is a mapping of keys to values.",
                            top.text()));
  }
  if (root->kind != YamlValue::Kind::Mapping) {
    throw Error(ErrorKind::Usage,
                fmt::format("{}: the file holds no mapping at its top. A scenario is a mapping of "
                            "keys to values, 'name: …' first.",
                            root->place.text()));
  }
  for (const Override& change : overrides) apply_override(*root, table, change, defects);

  const auto folder = std::filesystem::absolute(file).parent_path();
  Validated valid =
      validate(*root, std::make_shared<const Section>(table), folder, unknown, defects);
  throw_if_any(defects);
  std::string resolved = to_yaml(valid.resolved);
  const std::uint64_t hash = hash_of(resolved);
  return {Node(std::move(valid.data)), std::move(resolved), hash};
}

}  // namespace tandem::scenario

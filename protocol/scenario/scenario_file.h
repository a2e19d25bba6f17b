#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::scenario {

/// `--set coupling.scheme=implicit`, `--set mbs.bodies.crank.mass_kg=2`: the path names list
/// entries by their `name` key or by index; the value is YAML text.
struct Override {
  std::string path;
  std::string value;
  std::string given_as = {};  ///< what the user wrote, for messages; empty = "--set path=value"
};
[[nodiscard]] Override parse_override(const std::string& argument);

/// Keys outside the table: an error, or passed over (a side reads a resolved scenario with the part
/// of the table that concerns it). Passed-over keys stay in resolved_yaml, so that a resolved
/// scenario has the same hash whichever part of the table reads it.
enum class UnknownKeys { Refuse, Ignore };

struct Loaded {
  Node root;
  std::string
      resolved_yaml;       ///< complete: every default written out, overrides applied, rerunnable
  std::uint64_t hash = 0;  ///< of resolved_yaml; both sides compare it
};

/// Reads, overrides and validates. All defects of the file are collected and thrown as one Usage
/// error, one "file:line:column: key: what is wrong. What would be right." per line.
[[nodiscard]] Loaded load(const std::filesystem::path& file, const Section& table,
                          const std::vector<Override>& overrides = {},
                          UnknownKeys unknown = UnknownKeys::Refuse);

/// JSON Schema (draft 2020-12) of a table, for editors.
[[nodiscard]] std::string json_schema(const Section& table, const std::string& title);

/// The reference page (Markdown) of a table.
[[nodiscard]] std::string reference_markdown(const Section& table, const std::string& title);

}  // namespace tandem::scenario

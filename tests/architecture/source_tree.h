#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem::architecture {

/// A text file of the repository. `path` is relative to its root, with '/'.
struct SourceFile {
  std::string path;
  std::vector<std::string> lines;
};

/// The repository's own text files, sorted by path: what the top level names, without build and run
/// folders. Data files (meshes, tables of references) are left out.
[[nodiscard]] std::vector<SourceFile> read_tree(const std::filesystem::path& root);

/// What breaks a rule, one line each: "path:line: what". Empty = the rule holds.
using Findings = std::vector<std::string>;

/// Folders include only what lies below them: contract ← scenario ← schemes, contract ← wire, both
/// ← driver; protocol ← mbs_process, fem_process ← orchestrator. The sides never include each
/// other.
[[nodiscard]] Findings find_forbidden_includes(const std::vector<SourceFile>& tree);

/// fem_process and orchestrator consist of rooms (sub-folders) in an order: a file lies in one, and
/// includes only its own and those before it.
[[nodiscard]] Findings find_misplaced_rooms(const std::vector<SourceFile>& tree);

/// The README of such a folder has one heading a room, in that order.
[[nodiscard]] Findings find_untold_rooms(const std::vector<SourceFile>& tree);

/// A third party's headers appear only in the files that confine it.
[[nodiscard]] Findings find_leaking_libraries(const std::vector<SourceFile>& tree);

/// C++ files longer than 450 lines.
[[nodiscard]] Findings find_long_files(const std::vector<SourceFile>& tree);

/// Notes of unfinished work.
[[nodiscard]] Findings find_unfinished_marks(const std::vector<SourceFile>& tree);

/// .cpp files that no CMake file of their own folder or of one above names: nobody builds them.
[[nodiscard]] Findings find_unbuilt_sources(const std::vector<SourceFile>& tree);

/// Relative links of Markdown pages to files or headings that do not exist.
[[nodiscard]] Findings find_broken_links(const std::vector<SourceFile>& tree,
                                         const std::filesystem::path& root);

/// Scenarios of examples/ that the README does not name.
[[nodiscard]] Findings find_unnamed_examples(const std::vector<SourceFile>& tree);

}  // namespace tandem::architecture

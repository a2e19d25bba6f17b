// Each rule twice: it holds for the repository, and it finds what breaks it when that is planted.

#include <gtest/gtest.h>

#include <fstream>

#include "tests/architecture/source_tree.h"

namespace tandem::architecture {
namespace {

namespace fs = std::filesystem;

const std::vector<SourceFile>& repository() {
  static const std::vector<SourceFile> kTree = read_tree(TANDEM_SOURCE_DIR);
  return kTree;
}

std::string list(const Findings& findings) {
  std::string text;
  for (const std::string& finding : findings) text += "\n  " + finding;
  return text;
}

void expect_none(const Findings& findings) { EXPECT_TRUE(findings.empty()) << list(findings); }

/// One finding, that begins with `where`.
void expect_one(const Findings& findings, const std::string& where) {
  ASSERT_EQ(findings.size(), 1U) << list(findings);
  EXPECT_TRUE(findings.front().starts_with(where)) << findings.front();
}

/// Split so that this file does not break the rule it tests.
const std::string kMark = std::string("// TO") + "DO later";

TEST(ArchitectureTree, HoldsTheWholeRepository) {
  std::size_t cpp = 0;
  for (const SourceFile& file : repository()) cpp += file.path.ends_with(".cpp") ? 1 : 0;
  // A root that is not the repository's would let every rule hold for nothing.
  EXPECT_GT(cpp, 100U);
}

TEST(ArchitectureIncludes, PointOneWay) { expect_none(find_forbidden_includes(repository())); }

TEST(ArchitectureIncludes, SidesThatIncludeEachOtherAreFound) {
  expect_one(find_forbidden_includes(
                 {{"mbs_process/a.cpp", {"", "#include \"fem_process/body/model.h\""}}}),
             "mbs_process/a.cpp:2");
  expect_one(find_forbidden_includes({{"fem_process/a.h", {"#include \"mbs_process/state.h\""}}}),
             "fem_process/a.h:1");
}

TEST(ArchitectureIncludes, UpwardAndRelativeOnesAreFound) {
  expect_one(find_forbidden_includes(
                 {{"protocol/schemes/a.cpp", {"  #  include \"protocol/wire/bus.h\""}}}),
             "protocol/schemes/a.cpp:1");
  expect_one(
      find_forbidden_includes({{"protocol/contract/a.h", {"#include \"orchestrator/run/run.h\""}}}),
      "protocol/contract/a.h:1");
  expect_one(find_forbidden_includes({{"fem_process/a.cpp", {"#include \"../mbs_process/x.h\""}}}),
             "fem_process/a.cpp:1");
  expect_one(find_forbidden_includes({{"helpers/a.cpp", {}}}), "helpers/a.cpp");
}

TEST(ArchitectureRooms, UseThoseBeforeThem) { expect_none(find_misplaced_rooms(repository())); }

TEST(ArchitectureRooms, IncludesOfLaterRoomsAndFilesWithoutARoomAreFound) {
  const std::string mesh = "#include \"fem_process/mesh/mesh.h\"";
  expect_none(find_misplaced_rooms({{"fem_process/elements/a.cpp", {mesh}}}));
  expect_none(find_misplaced_rooms({{"fem_process/mesh/a.cpp", {mesh}}}));
  expect_one(find_misplaced_rooms({{"fem_process/kernels/a.cpp", {"", mesh}}}),
             "fem_process/kernels/a.cpp:2");
  expect_one(find_misplaced_rooms({{"fem_process/a.cpp", {}}}), "fem_process/a.cpp");
  expect_one(find_misplaced_rooms({{"orchestrator/attic/a.cpp", {}}}), "orchestrator/attic/");
  expect_one(find_misplaced_rooms(
                 {{"orchestrator/run/a.h", {"#include \"orchestrator/commands/commands.h\""}}}),
             "orchestrator/run/a.h:1");
}

TEST(ArchitectureRooms, AreToldInTheirOrder) { expect_none(find_untold_rooms(repository())); }

TEST(ArchitectureRooms, UntoldOnesAreFound) {
  EXPECT_EQ(find_untold_rooms({}).size(), 2U);
  EXPECT_EQ(find_untold_rooms({{"orchestrator/README.md", {"# Rooms", "## files"}}}).size(), 2U);
}

TEST(ArchitectureLibraries, StayWhereTheyAreConfined) {
  expect_none(find_leaking_libraries(repository()));
}

TEST(ArchitectureLibraries, LeaksAreFound) {
  for (const char* header :
       {"ode/ode.h", "lcm/lcm.h", "tandem_wire/reply_t.hpp", "cholmod.h", "yaml-cpp/yaml.h"}) {
    const std::string include = std::string("#include <") + header + ">";
    expect_one(find_leaking_libraries({{"fem_process/body/model.h", {include}}}),
               "fem_process/body/model.h:1");
    expect_none(find_leaking_libraries({{"tests/unit/a.cpp", {include}}}));
  }
  expect_none(find_leaking_libraries({{"mbs_process/ode_world.cpp", {"#include <ode/ode.h>"}}}));
}

TEST(ArchitectureSize, FilesAreShort) { expect_none(find_long_files(repository())); }

TEST(ArchitectureSize, LongFilesAreFound) {
  expect_none(find_long_files({{"tests/a.cpp", std::vector<std::string>(450)}}));
  expect_one(find_long_files({{"tests/a.cpp", std::vector<std::string>(451)}}), "tests/a.cpp");
}

TEST(ArchitectureText, NothingIsMarkedUnfinished) {
  expect_none(find_unfinished_marks(repository()));
}

TEST(ArchitectureText, UnfinishedMarksAreFound) {
  expect_one(find_unfinished_marks({{"docs/wire.md", {"good", kMark}}}), "docs/wire.md:2");
}

TEST(ArchitectureBuild, EverySourceIsBuilt) { expect_none(find_unbuilt_sources(repository())); }

TEST(ArchitectureBuild, SourcesThatNobodyBuildsAreFound) {
  const SourceFile cmake{"tests/fem.cmake", {"  SOURCES unit/fem/mesh.cpp", "  LIBS fem"}};
  expect_none(find_unbuilt_sources({cmake, {"tests/unit/fem/mesh.cpp", {}}}));
  expect_one(find_unbuilt_sources({cmake, {"tests/unit/mesh.cpp", {}}}), "tests/unit/mesh.cpp");
  // Named by the CMake file of another folder: not the same source.
  expect_one(find_unbuilt_sources({cmake, {"fem_process/fem_mesh.cpp", {}}}), "fem_process/");
}

TEST(ArchitecturePages, LinksResolve) {
  expect_none(find_broken_links(repository(), TANDEM_SOURCE_DIR));
}

TEST(ArchitecturePages, BrokenLinksAreFound) {
  const fs::path root = fs::path(testing::TempDir()) / "tandem_links";
  fs::create_directories(root / "docs");
  std::ofstream(root / "docs" / "wire.md") << "# The wire\n";
  const SourceFile wire{"docs/wire.md", {"# The wire, again"}};
  const auto links = [&](const std::string& line) {
    return find_broken_links({wire, {"README.md", {line}}}, root);
  };
  expect_none(links("[a](docs/wire.md), [b](docs/wire.md#the-wire-again), [c](https://x.org/#y)"));
  expect_one(links("see [wire](docs/wires.md)"), "README.md:1: 'docs/wires.md'");
  expect_one(links("[a](docs/wire.md#wire)"), "README.md:1: 'docs/wire.md' has no heading");
  expect_one(links("<img src=\"docs/flow.svg\">"), "README.md:1: 'docs/flow.svg'");
  fs::remove_all(root);
}

TEST(ArchitecturePages, ReadmeNamesEveryExample) {
  expect_none(find_unnamed_examples(repository()));
}

TEST(ArchitecturePages, UnnamedExamplesAreFound) {
  const SourceFile readme{"README.md", {"`examples/lug/scenario.yaml`"}};
  expect_none(find_unnamed_examples({readme, {"examples/lug/scenario.yaml", {}}}));
  expect_one(find_unnamed_examples({readme, {"examples/rod/scenario.yaml", {}}}),
             "examples/rod/scenario.yaml");
}

}  // namespace
}  // namespace tandem::architecture

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// Two tets on five nodes with sparse tags, one orphan node 90, a face group, a point group and an
/// unnamed volume group.
const std::string kMsh =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n2\n0 7 \"tip\"\n2 3 \"base\"\n$EndPhysicalNames\n"
    "$Entities\n1 0 1 1\n1 0 0 0 1 7\n5 0 0 0 1 1 0 1 3 0\n2 0 0 0 1 1 1 1 -9 1 5\n$EndEntities\n"
    "$Nodes\n2 6 10 90\n2 5 0 4\n10\n20\n30\n90\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n"
    "3 2 0 2\n40\n50\n0 0 1\n1 1 1\n$EndNodes\n"
    "$Elements\n3 4 1 8\n0 1 15 1\n1 40\n2 5 2 1\n4 10 30 20\n3 2 4 2\n7 10 20 30 40\n"
    "8 20 50 30 40\n$EndElements\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string error_of(const std::string& name, const std::string& text) {
  try {
    static_cast<void>(read_mesh({.file = temporary_file(name, text)}));
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), 2);
    return error.what();
  }
  return "no error";
}

void expect_error(const std::string& name, const std::string& text, int line,
                  const std::string& part) {
  const std::string found = error_of(name, text);
  EXPECT_NE(found.find(name + ":" + std::to_string(line) + ": "), std::string::npos) << found;
  EXPECT_NE(found.find(part), std::string::npos) << found;
}

TEST(FemMesh, ReadsGmshGroupsSparseTagsAndDropsOrphans) {
  const TetMesh mesh = read_mesh({.file = temporary_file("good.msh", kMsh)});
  EXPECT_EQ(mesh.node_tags, (std::vector<std::int64_t>{10, 20, 30, 40, 50}));
  EXPECT_EQ(mesh.element_tags, (std::vector<std::int64_t>{7, 8}));
  EXPECT_EQ(find_set(mesh, {.name = "tip"}).nodes, (std::vector<int>{3}));
  EXPECT_EQ(find_set(mesh, {.name = "base"}).nodes, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(find_set(mesh, {.name = "base"}).triangles.size(), 1U);
  EXPECT_EQ(find_set(mesh, {.name = "9"}).nodes.size(), 5U);
  EXPECT_DOUBLE_EQ(signed_volume(mesh, mesh.tets[0]), 1.0 / 6.0);
}

TEST(FemMesh, ScalesTurnsAndMoves) {
  const TetMesh mesh = read_mesh({.file = temporary_file("placed.msh", kMsh),
                                  .length_scale_m = 1e-3,
                                  .position_m = {1, 2, 3},
                                  .orientation = rotation({0, 0, M_PI / 2})});
  EXPECT_LT((mesh.X[1] - Eigen::Vector3d(1, 2.001, 3)).norm(), 1e-15);
}

TEST(FemMesh, GmshAndAbaqusFilesOfOneMeshAgree) {
  const TetMesh msh = read_mesh({.file = data_file("lug.msh")});
  const TetMesh inp = read_mesh({.file = data_file("lug.inp")});
  EXPECT_EQ(msh.nodes(), 432);
  EXPECT_EQ(inp.nodes(), 432);
  ASSERT_EQ(msh.tets.size(), inp.tets.size());
  const auto by_tag = [](const TetMesh& mesh) {
    std::map<std::int64_t, Eigen::Vector3d> nodes;
    for (std::size_t i = 0; i < mesh.X.size(); ++i) nodes[mesh.node_tags[i]] = mesh.X[i];
    return nodes;
  };
  const auto a = by_tag(msh);
  const auto b = by_tag(inp);
  for (const auto& [tag, X] : a) EXPECT_LT((X - b.at(tag)).norm(), 1e-9) << tag;
  const auto tags = [](const TetMesh& mesh, const std::string& name) {
    std::set<std::int64_t> result;
    for (int i : find_set(mesh, {.name = name}).nodes) {
      result.insert(mesh.node_tags[static_cast<std::size_t>(i)]);
    }
    return result;
  };
  EXPECT_EQ(tags(msh, "fixed"), tags(inp, "FIXED"));
  EXPECT_EQ(tags(msh, "load"), tags(inp, "LOAD"));
  EXPECT_EQ(tags(msh, "monitor"), (std::set<std::int64_t>{11}));
}

TEST(FemMesh, ReadsAbaqusSetsAndSurfaces) {
  const std::string text = box_inp(2) +
                           "*NSET, NSET=both\nleft, RIGHT, 6\n"
                           "*ELSET, ELSET=first, GENERATE\n1, 6, 1\n*ELSET, ELSET=again\nFIRST, 7\n"
                           "*MATERIAL, NAME=M\n*ELASTIC\n1.0, 0.3\n";
  const TetMesh mesh = read_mesh({.file = temporary_file("box.inp", text)});
  EXPECT_EQ(find_set(mesh, {.name = "both"}).nodes.size(), 9U);
  EXPECT_EQ(find_set(mesh, {.name = "first"}).nodes.size(), 8U);
  EXPECT_GT(find_set(mesh, {.name = "again"}).nodes.size(), 8U);
  const NodeSet& end = find_set(mesh, {.name = "END"});
  double total = 0.0;
  for (const Triangle& triangle : end.triangles) total += area(mesh, triangle);
  EXPECT_DOUBLE_EQ(total, 1.0);  // the far face of the row of unit cubes
  for (int node : end.nodes) EXPECT_EQ(mesh.X[static_cast<std::size_t>(node)].x(), 2.0);
  EXPECT_EQ(mesh.notes.size(), 1U);  // *MATERIAL and *ELASTIC
}

TEST(FemMesh, SurfaceLoadSumsToTractionTimesArea) {
  Params params;
  params.mesh.file = temporary_file("load.inp", box_inp(2));
  params.micro_step = SimTime(1'000'000);
  params.fixed = {{"LEFT"}};
  params.loads = {{.kind = Load::Kind::Surface, .set = {"END"}, .value = {3, -2, 7}}};
  const Model model(params);
  const Eigen::VectorXd f = model.loads(0.0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < model.mesh.nodes(); ++i) sum += f.segment<3>(3 * i);
  EXPECT_LT((sum - Eigen::Vector3d(3, -2, 7)).norm(), 1e-14);
}

TEST(FemMesh, UnknownSetSaysWhatThereIs) {
  const TetMesh mesh = read_mesh({.file = temporary_file("sets.msh", kMsh)});
  try {
    static_cast<void>(find_set(mesh, {.name = "bsae", .place = {"case.yaml", 12, 7}}));
    FAIL();
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("case.yaml:12:7: "), 0U) << text;
    EXPECT_NE(text.find("Did you mean 'base'?"), std::string::npos) << text;
    EXPECT_NE(text.find("9, base, tip"), std::string::npos) << text;
  }
}

TEST(FemMesh, GroupWithoutTetNodesIsRefusedWhenUsed) {
  const std::string text = replaced(kMsh, "1 40\n2 5 2", "1 90\n2 5 2");  // tip on the orphan
  const TetMesh mesh = read_mesh({.file = temporary_file("empty.msh", text)});
  EXPECT_THROW(static_cast<void>(find_set(mesh, {.name = "tip"})), Error);
}

TEST(FemMeshDefects, TextWithTheHeadOfABinaryFile) {
  expect_error("binary.msh", replaced(kMsh, "4.1 0 8", "4.1 1 8"), 3, "the byte order");
}
TEST(FemMeshDefects, UnknownVersionSaysHowToConvert) {
  expect_error("old.msh", replaced(kMsh, "4.1 0 8", "3 0 8"), 2,
               "MSH version 3 is not read, 2 to 4.1 are. Convert it: gmsh old.msh -save");
}
TEST(FemMeshDefects, NotAMesh) { expect_error("not.msh", "hello\n", 1, "$MeshFormat"); }
TEST(FemMeshDefects, MissingFile) {
  EXPECT_THROW(static_cast<void>(read_mesh({.file = "/no/such/mesh.msh"})), Error);
}
TEST(FemMeshDefects, UnknownExtension) {
  EXPECT_NE(error_of("mesh.vtk", kMsh).find("'.vtk'"), std::string::npos);
}
// Cut anywhere: always an error with a line, never a crash or a silent success.
TEST(FemMeshDefects, TruncatedFile) {
  const std::size_t last = kMsh.find("$EndElements") + 12;
  for (std::size_t size = 1; size < last; ++size) {
    const std::string found = error_of("cut.msh", kMsh.substr(0, size));
    EXPECT_NE(found.find("cut.msh:"), std::string::npos) << size << ": " << found;
  }
}
TEST(FemMeshDefects, HugeCountIsRefusedBeforeMemoryIsTaken) {
  expect_error("huge.msh", replaced(kMsh, "2 5 0 4\n", "2 5 0 4000000000000\n"), 17,
               "bytes follow");
}
TEST(FemMeshDefects, UndefinedNode) {
  expect_error("undefined.msh", replaced(kMsh, "7 10 20 30 40", "7 10 20 30 41"), 39,
               "element 7 uses node 41");
}
TEST(FemMeshDefects, InvertedTet) {
  expect_error("inverted.msh", replaced(kMsh, "7 10 20 30 40", "7 10 30 20 40"), 39,
               "element 7 has negative volume");
}
TEST(FemMeshDefects, FlatTet) {
  expect_error("flat.msh", replaced(kMsh, "\n0 0 1\n", "\n0.5 0.5 0\n"), 39,
               "element 7 has no volume");
}
TEST(FemMeshDefects, DuplicateNode) {
  expect_error("nodes.msh", replaced(kMsh, "10\n20\n30\n90", "10\n20\n20\n90"), 24,
               "node 20 is defined twice");
}
TEST(FemMeshDefects, DuplicateElement) {
  expect_error("elements.msh", replaced(kMsh, "\n8 20 50", "\n7 20 50"), 40,
               "element 7 is defined twice");
}
TEST(FemMeshDefects, NoTets) {
  const std::string text = replaced(replaced(kMsh, "3 4 1 8\n", "2 2 1 4\n"),
                                    "3 2 4 2\n7 10 20 30 40\n8 20 50 30 40\n", "");
  expect_error("none.msh", text, 1, "no tetrahedra");
}
TEST(FemMeshDefects, ThirdOrderTets) {
  expect_error("third.msh", replaced(kMsh, "3 2 4 2", "3 2 29 2"), 38,
               "Mesh.ElementOrder = 1 or 2");
}
TEST(FemMeshDefects, Hexahedra) {
  expect_error("hex.msh", replaced(kMsh, "3 2 4 2", "3 2 5 2"), 38, "element type 5");
}
TEST(FemMeshDefects, WordForNumber) {
  expect_error("word.msh", replaced(kMsh, "\n5 5 5", "\n5 five 5"), 25, "'five'");
}
TEST(FemMeshDefects, AbaqusUnknownElement) {
  expect_error("hex.inp", replaced(box_inp(1), "C3D4", "C3D8"), 10, "C3D8");
}
TEST(FemMeshDefects, AbaqusUnknownKeyword) {
  expect_error("part.inp", "*PRAT, NAME=A\n" + box_inp(1), 1, "Did you mean '*PART'?");
}
TEST(FemMeshDefects, AbaqusShortElement) {
  expect_error("short.inp", replaced(box_inp(1), "\n*NSET", "\n7, 1, 2\n*NSET"), 17, "3 numbers");
}
TEST(FemMeshDefects, AbaqusBadFace) {
  expect_error("face.inp", replaced(box_inp(1), ", S3", ", S5"), 22, "S1, S2, S3, S4");
}
TEST(FemMeshDefects, AbaqusUnknownSet) {
  expect_error("set.inp", box_inp(1) + "*NSET, NSET=N\nNOWHERE\n", 25, "NOWHERE");
}

TEST(FemMeshDefects, AbaqusEmptyNames) {
  for (const std::string keyword : {"*NSET, NSET=", "*NSET, NSET= ,", "*ELSET, ELSET="}) {
    expect_error("empty.inp", box_inp(1) + keyword + "\n1\n", 24, "is empty");
  }
  expect_error("node.inp", "*NODE, NSET=\n1, 0, 0, 0\n", 1, "NSET= is empty");
  expect_error("element.inp", "*ELEMENT, TYPE=C3D4, ELSET=\n1, 1, 2, 3, 4\n", 1, "ELSET= is empty");
}
TEST(FemMeshDefects, AbaqusGenerateOverTheWholeRangeOfNumbers) {
  expect_error("generate.inp",
               box_inp(1) +
                   "*NSET, NSET=N, GENERATE\n-9223372036854775808, "
                   "9223372036854775807, 9223372036854775807\n",
               25, "makes no sense");
}
TEST(FemMeshDefects, NumbersBeyondTheirRange) {
  // Whose absolute value is no number of 64 bits, and one that an int would take for dimension 2.
  expect_error("tag.msh", replaced(kMsh, "1 -9 1 5", "1 -9223372036854775808 1 5"), 13,
               "out of range");
  expect_error("dimension.msh", replaced(kMsh, "\n3 2 4 2\n", "\n4294967299 2 4 2\n"), 38,
               "dimension 4294967299");
  expect_error("names.msh", replaced(kMsh, "\n2 3 \"base\"", "\n-1 3 \"base\""), 7, "dimension -1");
}
TEST(FemMeshDefects, NoNumbersLeftForMidNodes) {
  std::string text = replaced(kMsh, "\n90\n", "\n9223372036854775807\n");
  const auto file = temporary_file("last.msh", text);
  EXPECT_EQ(read_mesh({.file = file}).nodes(), 5);
  try {
    static_cast<void>(read_mesh({.file = file, .order = 2}));
    FAIL() << "read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("no numbers for mid nodes"), std::string::npos)
        << error.what();
  }
}
TEST(FemMeshDefects, TheSameElementTwice) {
  // Under another number, with its corners in another order.
  expect_error("twice.msh", replaced(kMsh, "\n8 20 50 30 40", "\n8 20 30 10 40"), 40,
               "element 8 has the same corners as element 7 (line 39)");
}

std::string missing_set(const std::string& name, const std::string& text) {
  try {
    static_cast<void>(find_set(read_mesh({.file = temporary_file(name, text)}), {.name = "top"}));
  } catch (const Error& error) {
    return error.what();
  }
  return "found";
}

TEST(FemMeshDefects, NoGroupsAtAllSayHowToMakeThem) {
  const std::string no_names =
      replaced(kMsh, "$PhysicalNames\n2\n0 7 \"tip\"\n2 3 \"base\"\n$EndPhysicalNames\n", "");
  const std::string bare = replaced(
      replaced(replaced(no_names, "0 0 0 1 7\n", "0 0 0 0\n"), "1 1 0 1 3 0\n", "1 1 0 0 0\n"),
      "1 1 1 1 -9 1 5\n", "1 1 1 0 1 5\n");
  const std::string gmsh = missing_set("bare.msh", bare);
  EXPECT_NE(gmsh.find("Physical Surface(\"NAME\")"), std::string::npos) << gmsh;
  EXPECT_NE(gmsh.find("Mesh.SaveAll = 0"), std::string::npos) << gmsh;
  const std::string abaqus = missing_set("bare.inp",
                                         "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n"
                                         "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n");
  EXPECT_NE(abaqus.find("*NSET, NSET=NAME"), std::string::npos) << abaqus;
  const std::string other = missing_set("named.msh", kMsh);
  EXPECT_NE(other.find("It has: 9, base, tip."), std::string::npos) << other;
}

TEST(FemModel, SetOfAllNodesIsRefusedAtItsPlace) {
  const auto refusal = [](Params params) -> std::string {
    try {
      Model model(params);
    } catch (const Error& error) {
      return error.what();
    }
    return "taken";
  };
  Params params = bar_with_two_ports();
  params.mesh.file = temporary_file("all.inp", box_inp(2));
  const Params good = params;
  params.ports.resize(1);
  params.ports[0].set = {.name = "ALL", .place = {"a.yaml", 7, 3}};
  EXPECT_NE(refusal(params).find("a.yaml:7:3: the set 'ALL' of port '" + params.ports[0].name +
                                 "' holds every node"),
            std::string::npos)
      << refusal(params);
  params = good;
  params.ports.clear();
  params.fixed = {{.name = "ALL", .place = {"a.yaml", 8, 3}}};
  EXPECT_NE(refusal(params).find("a.yaml:8:3: the fixed set 'ALL' holds every node"),
            std::string::npos)
      << refusal(params);
}

TEST(FemModel, NodeInTwoPortsIsRefused) {
  Params params = bar_with_two_ports();
  params.ports[1].set.name = "left";
  EXPECT_THROW(Model model(params), Error);
}
TEST(FemModel, NodeInAPortAndFixedIsRefused) {
  Params params = bar_with_two_ports();
  params.fixed = {{"left"}};
  EXPECT_THROW(Model model(params), Error);
}
TEST(FemModel, EachBadParameterIsRefused) {
  const auto refused = [](auto spoil) {
    Params params = bar_with_two_ports();
    spoil(params);
    EXPECT_THROW(Model model(params), Error);
  };
  refused([](Params& p) { p.material.young_Pa = 0.0; });
  refused([](Params& p) { p.material.poisson = 0.5; });
  refused([](Params& p) { p.material.density_kg_per_m3 = -1.0; });
  refused([](Params& p) { p.mesh.length_scale_m = 0.0; });
  refused([](Params& p) { p.mesh.orientation.coeffs().setConstant(1.0); });
  refused([](Params& p) { p.damping.alpha_per_s = -1.0; });
  refused([](Params& p) { p.damping.beta_s = -1.0; });
  refused([](Params& p) { p.integrator.hht_alpha = 0.1; });
  refused([](Params& p) { p.solver.tolerance = 0.0; });
  refused([](Params& p) { p.solver.max_iterations = 0; });
  refused([](Params& p) { p.micro_step = SimTime{}; });
  refused([](Params& p) { p.watch = {{"nothing"}}; });
  refused([](Params& p) { p.loads = {{.kind = Load::Kind::Surface, .set = {"nothing"}}}; });
}

}  // namespace
}  // namespace tandem::fem

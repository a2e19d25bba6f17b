// Decks of Abaqus and CalculiX as their programs write them.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

const std::string kNodes = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n";
const std::string kTet = kNodes + "*ELEMENT, TYPE=C3D4, ELSET=BODY\n1, 1, 2, 3, 4\n";

TetMesh read_deck(const std::string& name, const std::string& text) {
  return read_mesh({.file = temporary_file(name, text)});
}

double volume_of(const TetMesh& mesh) {
  double volume = 0.0;
  for (const Tet& tet : mesh.tets) volume += signed_volume(mesh, tet);
  return volume;
}

std::size_t nodes_of(const TetMesh& mesh, const std::string& set) {
  return find_set(mesh, {.name = set}).nodes.size();
}

std::string notes_of(const TetMesh& mesh) {
  std::string all;
  for (const std::string& note : mesh.notes) all += note + "\n";
  return all;
}

std::string refusal(const std::string& name, const std::string& text) {
  try {
    static_cast<void>(read_deck(name, text));
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), 2);
    return error.what();
  }
  return "read";
}

void expect_refused(const std::string& name, const std::string& text, const std::string& where,
                    const std::string& part) {
  const std::string found = refusal(name, text);
  EXPECT_NE(found.find(where), std::string::npos) << found;
  EXPECT_NE(found.find(part), std::string::npos) << found;
}

// ---- parts, instances, assembly --------------------------------------------------------------

/// As Abaqus/CAE writes a part whose instance is meshed.
const std::string kInstanceMesh =
    "*Heading\n** Job name: a Model name: Model-1\n*Part, name=block\n*End Part\n"
    "*Assembly, name=Assembly\n**\n*Instance, name=block-1, part=block\n" +
    kTet +
    "*Nset, nset=Set-1, generate\n 1, 3, 1\n*End Instance\n**\n"
    "*Nset, nset=hold, instance=block-1\n1, 2, 3\n*End Assembly\n";

TEST(FemDecks, OneInstanceIsAFlatMesh) {
  const TetMesh mesh = read_deck("part.inp", kInstanceMesh);
  EXPECT_DOUBLE_EQ(volume_of(mesh), 1.0 / 6.0);
  for (const char* set : {"Set-1", "block-1.Set-1", "hold"}) EXPECT_EQ(nodes_of(mesh, set), 3U);
  for (const char* set : {"BODY", "block-1.BODY"}) {
    EXPECT_EQ(find_set(mesh, {.name = set}).tets, (std::vector<int>{0})) << set;
  }
  EXPECT_EQ(mesh.node_tags, (std::vector<std::int64_t>{1, 2, 3, 4}));
}

/// A part with its mesh in it, two instances, the second moved by 10 along x and then turned by a
/// right angle about the z axis through (10, 0, 0).
const std::string kTwoInstances =
    "*PART, NAME=P\n" + kTet +
    "*NSET, NSET=foot\n1, 2\n*ELSET, ELSET=_top_S1, INTERNAL\n1\n*SURFACE, TYPE=ELEMENT, "
    "NAME=under\n_top_S1, S1\n*SOLID SECTION, ELSET=BODY, MATERIAL=M\n,\n*END PART\n"
    "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=P\n*END INSTANCE\n"
    "*INSTANCE, NAME=P-2, PART=P\n10., 0., 0.\n10., 0., 0., 10., 0., 1., 90.\n*END INSTANCE\n"
    "*NODE\n1, 3, 3, 3\n*NSET, NSET=_PickedSet5, INTERNAL, INSTANCE=P-2\n3\n"
    "*NSET, NSET=both\nP-1.foot, P-2.4\n*ELSET, ELSET=all, INSTANCE=P-1\n1\n"
    "*ELSET, ELSET=all, INSTANCE=P-2\n1\n*SURFACE, TYPE=ELEMENT, NAME=contact\nP-2.BODY, S2\n"
    "*TIE, NAME=t\ncontact, P-1.under\n*END ASSEMBLY\n*MATERIAL, NAME=M\n*ELASTIC\n1., .3\n";

TEST(FemDecks, InstancesAreMovedThenTurned) {
  const TetMesh mesh = read_deck("two.inp", kTwoInstances);
  ASSERT_EQ(mesh.nodes(), 8);
  EXPECT_DOUBLE_EQ(volume_of(mesh), 2.0 / 6.0);
  const auto position = [&](const std::string& set) {
    return mesh.X[static_cast<std::size_t>(find_set(mesh, {.name = set}).nodes.front())];
  };
  // Node 3 of the part, (0, 1, 0), goes to (10, 1, 0), then to (9, 0, 0).
  EXPECT_LT((position("_PickedSet5") - Eigen::Vector3d(9, 0, 0)).norm(), 1e-14);
  EXPECT_EQ(mesh.node_tags[4], 11);  // a power of ten above all numbers
  EXPECT_EQ(nodes_of(mesh, "both"), 3U);
  EXPECT_EQ(nodes_of(mesh, "P-2.foot"), 2U);
  EXPECT_EQ(mesh.sets.count("foot"), 0U);  // whose?
  EXPECT_EQ(find_set(mesh, {.name = "all"}).tets, (std::vector<int>{0, 1}));
  EXPECT_EQ(find_set(mesh, {.name = "P-2"}).tets, (std::vector<int>{1}));
  EXPECT_EQ(find_set(mesh, {.name = "P-1.under"}).triangles.size(), 1U);
  EXPECT_EQ(find_set(mesh, {.name = "contact"}).triangles.size(), 1U);
  const std::string notes = notes_of(mesh);
  EXPECT_NE(notes.find("n of 'P-2' is 10 + n"), std::string::npos) << notes;
  EXPECT_NE(notes.find("*TIE (line 37); what they connect stays apart"), std::string::npos)
      << notes;
}

TEST(FemDecks, BrokenAssembliesAreRefused) {
  expect_refused("open.inp", "*PART, NAME=P\n" + kTet, "open.inp:1: ", "no *END line");
  expect_refused("part.inp", "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=Q\n",
                 "part.inp:2: ", "part 'Q' is not defined");
  expect_refused("library.inp", "*INSTANCE, LIBRARY=job, INSTANCE=a\n",
                 "library.inp:1: ", "results of another analysis");
  expect_refused("end.inp", kTet + "*END PART\n", "end.inp:8: ", "without its beginning");
  expect_refused("instance.inp", kTet + "*NSET, NSET=a, INSTANCE=b\n1\n",
                 "instance.inp:8: ", "no instance 'b'");
}

// ---- includes --------------------------------------------------------------------------------

TEST(FemDecks, IncludesAreFollowed) {
  temporary_file("all.msh", kTet);
  temporary_file("fix.nam", "*NSET, NSET=Nfix\n1, 2, 3,\n");
  const auto main =
      temporary_file("main.inp",
                     "*INCLUDE, INPUT=all.msh\n*INCLUDE,\nINPUT=\"fix.nam\"\n*NSET,NSET"
                     "=more\n4\n*STEP\n*INCLUDE, INPUT=loads.not_there\n");
  const TetMesh mesh = read_mesh({.file = main});
  EXPECT_EQ(nodes_of(mesh, "Nfix"), 3U);
  EXPECT_EQ(nodes_of(mesh, "more"), 1U);
  // What is included is part of what a replay compares.
  const std::string before = mesh_checksum(main);
  temporary_file("fix.nam", "*NSET, NSET=Nfix\n1, 2, 4,\n");
  EXPECT_NE(mesh_checksum(main), before);
}

TEST(FemDecks, ErrorsNameTheIncludedFile) {
  temporary_file("bad.nam", "** sets\n*NSET, NSET=Nfix\n1, two\n");
  expect_refused("main.inp", kTet + "*INCLUDE, INPUT=bad.nam\n*NSET, NSET=x\n1\n",
                 "bad.nam:3: ", "node set 'two'");
  temporary_file("good.nam", "*NSET, NSET=Nfix\n1\n");
  expect_refused("main.inp", kTet + "*INCLUDE, INPUT=good.nam\n*NSET, NSET=x\ntwo\n",
                 "main.inp:10: ", "node set 'two'");
  expect_refused("main.inp", kTet + "*INCLUDE, INPUT=none.nam\n",
                 "main.inp:8: ", "'none.nam' is not there");
  expect_refused("main.inp", "*INCLUDE, INPUT=main.inp\n", "main.inp:1: ", "includes itself");
}

TEST(FemDecks, RowsOfOtherFiles) {
  temporary_file("nodes.txt", "1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n");
  const TetMesh mesh = read_deck(
      "input.inp", "*NODE, INPUT=nodes.txt, NSET=all\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n");
  EXPECT_EQ(nodes_of(mesh, "all"), 4U);
}

TEST(FemDecks, ADeckNamedMshSaysSo) {
  expect_refused("cgx.msh", kTet, "cgx.msh:1: ", "Name it cgx.inp");
}

// ---- rows and parameters ---------------------------------------------------------------------

TEST(FemDecks, CoordinatesLeftOutAreZero) {
  const TetMesh mesh = read_deck(
      "rows.inp", "*NODE\n1\n2, 1.\n3, 0., 1.0D+00\n4, , , 1.\n*ELEMENT, TYPE=C3D4\n1, 1,2,3,4\n");
  EXPECT_DOUBLE_EQ(volume_of(mesh), 1.0 / 6.0);
}

TEST(FemDecks, CylindricalCoordinatesAndSystems) {
  const TetMesh turned = read_deck("cylinder.inp",
                                   "*NODE, SYSTEM=C\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 90, 0\n4, 0, 0, "
                                   "1\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n");
  EXPECT_DOUBLE_EQ(volume_of(turned), 1.0 / 6.0);
  EXPECT_LT((turned.X[2] - Eigen::Vector3d(0, 1, 0)).norm(), 1e-15);
  // Origin (1, 1, 1), x' along y, y' along −x.
  const TetMesh system = read_deck("system.inp", "*SYSTEM\n1, 1, 1, 1, 2, 1\n0, 1, 1\n" + kTet);
  EXPECT_LT((system.X[1] - Eigen::Vector3d(1, 2, 1)).norm(), 1e-15);
  EXPECT_LT((system.X[2] - Eigen::Vector3d(0, 1, 1)).norm(), 1e-15);
  EXPECT_LT((system.X[3] - Eigen::Vector3d(1, 1, 2)).norm(), 1e-15);
}

TEST(FemDecks, ParametersAreReadOrRefused) {
  expect_refused("sphere.inp", "*NODE, SYSTEM=S\n", "sphere.inp:1: ", "SYSTEM=S is not read");
  expect_refused("offset.inp", kNodes + "*ELEMENT, TYPE=C3D4, OFFSET=1\n",
                 "offset.inp:6: ", "parameter 'OFFSET'");
  expect_refused("shift.inp", "*NODE, SHIFT=1\n", "shift.inp:1: ", "parameter 'SHIFT'");
  const TetMesh mesh = read_deck("nset.inp", kTet + "*NSET, NSET=hold, ELSET=BODY\n");
  EXPECT_EQ(nodes_of(mesh, "hold"), 4U);
}

TEST(FemDecks, CaseBlanksCommasAndQuotes) {
  const TetMesh mesh = read_deck(
      "style.inp",
      "* node ,\n NSET = Nall\n 1 , 0 , 0 , 0 ,\n2, 1, 0, 0,\n3, 0, 1, 0,\r\n4, 0, 0, 1,\n"
      "*Element, type=c3d4,\nelset=\"Solid part-1\"\n1,1,2,\n3,\n4\n*NSET,NSET=Nfix,\n1,\n2,\n"
      "*elset, Elset=again\nsolid PART-1\n*SURFACE, NAME=skin\nagain\n");
  EXPECT_EQ(nodes_of(mesh, "Nall"), 4U);
  EXPECT_EQ(nodes_of(mesh, "Nfix"), 2U);
  EXPECT_EQ(find_set(mesh, {.name = "Solid part-1"}).tets.size(), 1U);
  EXPECT_EQ(find_set(mesh, {.name = "again"}).tets.size(), 1U);
  EXPECT_EQ(find_set(mesh, {.name = "skin"}).triangles.size(), 4U);  // no face: the free ones
}

// ---- what is passed over ---------------------------------------------------------------------

TEST(FemDecks, WhatLeavesTheMeshAloneIsPassedOver) {
  const TetMesh mesh = read_deck(
      "deck.inp",
      kTet +
          "*PHYSICAL CONSTANTS, ABSOLUTE ZERO=0\n*MATERIAL, NAME=M\n*ELASTIC\n210000, 0.3\n"
          "*SPECIFIC HEAT\n0.5\n*PLASTIC\n250, 0\n*SolidSection, ELSET=BODY, MATERIAL=M\n"
          "*SURFACE INTERACTION, NAME=I\n*FRICTION\n0.1\n*ELASTIC\n1, 0\n"
          "*STEP\n*STATIC\n*DSLOAD\nS, P, 1\n*NO SUCH KEYWORD\n*END STEP\n");
  ASSERT_EQ(mesh.notes.size(), 2U) << notes_of(mesh);
  EXPECT_NE(mesh.notes[0].find("*PHYSICAL CONSTANTS (line 8), *MATERIAL (line 9), *ELASTIC (line "
                               "10, 2 times), *SPECIFIC HEAT"),
            std::string::npos)
      << mesh.notes[0];
  EXPECT_NE(mesh.notes[1].find("line 22: all from the first *STEP on"), std::string::npos)
      << mesh.notes[1];
}

TEST(FemDecks, WhatChangesTheMeshIsRefused) {
  expect_refused("ngen.inp", kTet + "*NGEN\n1, 4\n", "ngen.inp:8: ", "*NGEN makes, moves");
  expect_refused("typo.inp", kTet + "*NSETT, NSET=A\n1\n*FOO\n",
                 "typo.inp:8: ", "Did you mean '*NSET'?");
  expect_refused("typo.inp", kTet + "*NSETT, NSET=A\n1\n*FOO\n",
                 "typo.inp:8: ", "So are: *FOO (line 10).");
}

TEST(FemDecks, OtherElementsArePassedOverAndTrianglesAreSurfaces) {
  // As Gmsh writes it: curves and surfaces beside the volume.
  const TetMesh mesh =
      read_deck("gmsh.inp", kNodes +
                                "*ELEMENT, type=T3D2, ELSET=Line1\n5, 1, 2\n"
                                "*ELEMENT, type=CPS3, ELSET=Surface1\n1, 1, 3, 2\n"
                                "*ELEMENT, type=C3D4, ELSET=Volume1\n2, 1, 2, 3, 4\n"
                                "*ELEMENT, TYPE=GAPUNI, ELSET=gap\n8, 1, 2\n9, 3, 4\n"
                                "*ELSET, ELSET=clamp\n1\n*ELSET, ELSET=beam\n2\n"
                                "*SURFACE, NAME=shell\nSurface1, SPOS\n");
  const NodeSet& clamp = find_set(mesh, {.name = "clamp"});
  EXPECT_EQ(clamp.nodes.size(), 3U);
  ASSERT_EQ(clamp.triangles.size(), 1U);
  EXPECT_DOUBLE_EQ(area(mesh, clamp.triangles[0]), 0.5);
  EXPECT_EQ(find_set(mesh, {.name = "shell"}).triangles.size(), 1U);
  EXPECT_EQ(nodes_of(mesh, "Line1"), 2U);
  EXPECT_EQ(find_set(mesh, {.name = "beam"}).tets.size(), 1U);
  EXPECT_NE(notes_of(mesh).find("1 T3D2 (line 7), 1 CPS3 (line 9, surfaces in their sets), 2 "
                                "GAPUNI (line 13)"),
            std::string::npos)
      << notes_of(mesh);
}

TEST(FemDecks, SolidsThatWouldBeMissingAreRefused) {
  for (const char* type : {"C3D8R", "C3D6", "C3D20", "SC8R", "AC3D4"}) {
    expect_refused("solid.inp", kNodes + "*ELEMENT, TYPE=" + type + "\n", "solid.inp:6: ", type);
  }
}

TEST(FemDecks, VariantsOfTetrahedraAreTetrahedra) {
  const TetMesh mesh = read_deck("c3d4h.inp", kNodes + "*ELEMENT, TYPE=C3D4H\n1, 1, 2, 3, 4\n");
  EXPECT_EQ(mesh.notes.front(), "line 6: C3D4H was taken for C3D4");
}

TEST(FemDecks, SetsThatNameThemselvesStaySmall) {
  std::string text = kTet + "*ELSET, ELSET=A\n1\n*ELSET, ELSET=A\n";
  for (int k = 0; k < 200; ++k) text += "A, A, A, A, A, A, A, A\n";
  EXPECT_EQ(find_set(read_deck("self.inp", text), {.name = "A"}).tets.size(), 1U);
}

}  // namespace
}  // namespace tandem::fem

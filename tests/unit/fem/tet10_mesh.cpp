#include <gtest/gtest.h>

#include "fem_process/mesh/surface.h"
#include "fem_process/mesh/tet10.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// One second-order tet in Gmsh's node order with the face z = 0 as a group of 6-node triangles,
/// the edge from (0, 0, 0) to (1, 0, 0) as a 3-node line. Node 14 is on the edge 23, node 15 on 13.
const std::string kMsh =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n3\n1 3 \"edge\"\n2 1 \"base\"\n3 2 \"solid\"\n$EndPhysicalNames\n"
    "$Entities\n0 1 1 1\n1 0 0 0 1 1 1 1 3 0\n1 0 0 0 1 1 1 1 1 0\n1 0 0 0 1 1 1 1 2 0\n"
    "$EndEntities\n"
    "$Nodes\n1 10 1 15\n3 1 0 10\n1\n2\n3\n4\n10\n11\n12\n13\n14\n15\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "0.5 0 0\n0.5 0.5 0\n0 0.5 0\n0 0 0.5\n0 0.5 0.5\n0.5 0 0.5\n$EndNodes\n"
    "$Elements\n3 3 1 3\n1 1 8 1\n1 1 2 10\n2 1 9 1\n2 1 3 2 12 11 10\n3 1 11 1\n"
    "3 1 2 3 4 10 11 12 13 14 15\n$EndElements\n";

/// The same in Abaqus' order.
const std::string kInp =
    "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n10, 0.5, 0, 0\n11, 0.5, 0.5, 0\n"
    "12, 0, 0.5, 0\n13, 0, 0, 0.5\n14, 0, 0.5, 0.5\n15, 0.5, 0, 0.5\n"
    "*ELEMENT, TYPE=C3D10, ELSET=solid\n3, 1, 2, 3, 4, 10, 11, 12,\n13, 15, 14\n"
    "*SURFACE, NAME=base\nsolid, S1\n*SURFACE, NAME=S2\n3, S2\n*SURFACE, NAME=S3\n3, S3\n"
    "*SURFACE, NAME=S4\n3, S4\n*NSET, NSET=edge\n1, 2, 10\n";

TetMesh read(const std::string& name, const std::string& text, int order = 0) {
  return read_mesh({.file = temporary_file(name, text), .order = order});
}

std::string error_of(const std::string& name, const std::string& text, int order = 0) {
  try {
    static_cast<void>(read(name, text, order));
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), 2);
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

Eigen::Vector3d X(const TetMesh& mesh, int node) { return mesh.X[static_cast<std::size_t>(node)]; }

/// Every mid node of tets and triangles is in the middle of its edge.
void expect_straight(const TetMesh& mesh) {
  ASSERT_EQ(mesh.mids.size(), mesh.tets.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    for (std::size_t k = 0; k < 6; ++k) {
      const Eigen::Vector3d middle =
          0.5 * (X(mesh, mesh.tets[e][kTetEdges[k][0]]) + X(mesh, mesh.tets[e][kTetEdges[k][1]]));
      EXPECT_LT((X(mesh, mesh.mids[e][k]) - middle).norm(), 1e-15) << "edge " << k;
    }
  }
  for (const auto& [name, set] : mesh.sets) {
    ASSERT_EQ(set.triangle_mids.size(), set.triangles.size()) << name;
    for (std::size_t t = 0; t < set.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d middle =
            0.5 * (X(mesh, set.triangles[t][k]) + X(mesh, set.triangles[t][(k + 1) % 3]));
        EXPECT_LT((X(mesh, set.triangle_mids[t][k]) - middle).norm(), 1e-15) << name;
      }
    }
  }
}

TEST(FemTet10Mesh, GmshAndAbaqusNodeOrdersBecomeOne) {
  const TetMesh msh = read("one.msh", kMsh);
  const TetMesh inp = read("one.inp", kInp);
  expect_straight(msh);
  expect_straight(inp);
  EXPECT_EQ(msh.element(0), inp.element(0));
  for (const char* set : {"base", "edge", "solid"}) {
    EXPECT_EQ(find_set(msh, {.name = set}).nodes, find_set(inp, {.name = set}).nodes) << set;
  }
  EXPECT_EQ(find_set(msh, {.name = "base"}).nodes.size(), 6U);
  EXPECT_EQ(find_set(msh, {.name = "edge"}).nodes, (std::vector<int>{0, 1, 4}));
  EXPECT_EQ(find_set(msh, {.name = "solid"}).tets, (std::vector<int>{0}));
  EXPECT_EQ(find_set(inp, {.name = "solid"}).tets, (std::vector<int>{0}));
  for (const char* face : {"S2", "S3", "S4"}) {
    EXPECT_EQ(find_set(inp, {.name = face}).nodes.size(), 6U) << face;
  }
}

TEST(FemTet10Mesh, RaisingPutsANodeOnEveryEdge) {
  const std::string text = box_inp(3);
  const TetMesh low = read("low.inp", text);
  const TetMesh mesh = read("raised.inp", text, 2);
  std::set<std::pair<int, int>> edges;
  for (const Tet& tet : low.tets) {
    for (const auto& edge : kTetEdges) {
      edges.insert(std::minmax(tet[edge[0]], tet[edge[1]]));
    }
  }
  EXPECT_EQ(mesh.nodes(), low.nodes() + static_cast<int>(edges.size()));
  expect_straight(mesh);
  const std::set<std::int64_t> tags(mesh.node_tags.begin(), mesh.node_tags.end());
  EXPECT_EQ(tags.size(), mesh.node_tags.size());
  EXPECT_EQ(mesh.tets, low.tets);
}

// The far face of the box: 4 corners, its 4 sides and one diagonal, as a surface and as a list of
// nodes.
TEST(FemTet10Mesh, RaisedSetsTakeTheMidNodesOfTheirEdges) {
  const TetMesh mesh = read("sets.inp", box_inp(3), 2);
  EXPECT_EQ(find_set(mesh, {.name = "END"}).nodes.size(), 9U);
  EXPECT_EQ(find_set(mesh, {.name = "END"}).nodes, find_set(mesh, {.name = "RIGHT"}).nodes);
  EXPECT_EQ(static_cast<int>(find_set(mesh, {.name = "ALL"}).nodes.size()), mesh.nodes());
}

// In this mesh tets cross the bar's end between faces of the group: the edge through the volume is
// not the surface's, although both its ends are.
TEST(FemTet10Mesh, RaisedSurfacesTakeNoNodeInTheVolume) {
  const TetMesh mesh = read_mesh({.file = data_file("lug.msh"), .order = 2});
  const NodeSet& surface = find_set(mesh, {.name = "fixed"});
  std::set<int> of_triangles;
  for (const Triangle& corners : surface.triangles) {
    of_triangles.insert(corners.begin(), corners.end());
  }
  for (const Triangle& mids : surface.triangle_mids) of_triangles.insert(mids.begin(), mids.end());
  EXPECT_EQ(std::vector<int>(of_triangles.begin(), of_triangles.end()), surface.nodes);
}

// ∫ N_i dA of a straight triangle: nothing at corners, a third at mid nodes.
TEST(FemTet10Mesh, UniformTractionActsOnMidNodes) {
  const TetMesh mesh = read("traction.msh", kMsh);
  const std::vector<double> areas = nodal_areas(mesh, find_set(mesh, {.name = "base"}));
  for (int node = 0; node < mesh.nodes(); ++node) {
    const bool mid_of_base = node >= 4 && X(mesh, node).z() == 0.0;
    EXPECT_NEAR(areas[static_cast<std::size_t>(node)], mid_of_base ? 0.5 / 3.0 : 0.0, 1e-15);
  }
}

// The base bulges to z = −h · 4 x (1 − x − y) …: bounded by the straight triangle and by what the
// gradient adds, A ≤ ∫ √(1 + |∇z|²). A straight chord and an arch: numerically integrated here on a
// fine grid of the same parametric surface.
TEST(FemTet10Mesh, CurvedTriangleHasTheAreaOfItsParametricSurface) {
  const TetMesh mesh = read("bulge.msh", replaced(kMsh, "0.5 0 0\n0.5 0.5", "0.5 0 -0.1\n0.5 0.5"));
  const std::vector<double> areas = nodal_areas(mesh, find_set(mesh, {.name = "base"}));
  double area_found = 0.0;
  for (double a : areas) area_found += a;
  double expected = 0.0;
  const int n = 1000;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n - i; ++j) {
      // z = −0.4 x (1 − x − y); midpoints of the two triangles of a cell.
      for (int half = 0; half < (j < n - i - 1 ? 2 : 1); ++half) {
        const double x = (i + (1.0 + half) / 3.0) / n;
        const double y = (j + (1.0 + half) / 3.0) / n;
        const double z_x = -0.4 * (1.0 - 2.0 * x - y);
        const double z_y = 0.4 * x;
        expected += 0.5 / (n * n) * std::sqrt(1.0 + z_x * z_x + z_y * z_y);
      }
    }
  }
  EXPECT_NEAR(area_found, expected, 1e-5);  // the rule is of degree 5, the root no polynomial
  EXPECT_GT(area_found, 0.5 + 1e-3);
}

TEST(FemTet10MeshDefects, WrongOrderOfMidNodesIsFound) {
  // Gmsh's order given to Abaqus, and the reverse.
  EXPECT_NE(
      error_of("order.inp", replaced(kInp, "13, 15, 14", "13, 14, 15"))
          .find("order.inp:13: element 3 has the mid nodes of its edges 2-4 and 3-4 exchanged"),
      std::string::npos);
  EXPECT_NE(error_of("order.msh", replaced(kMsh, "13 14 15\n$End", "13 15 14\n$End"))
                .find("element 3 has the mid nodes of its edges 2-4 and 3-4 exchanged"),
            std::string::npos);
  // Any other order.
  EXPECT_NE(error_of("other.inp", replaced(kInp, "10, 11, 12,\n", "12, 10, 11,\n"))
                .find("other.inp:13: element 3 is folded"),
            std::string::npos);
}

// A crack-tip element: its Jacobian is zero at a corner, nowhere else.
TEST(FemTet10Mesh, QuarterPointElementsAreAccepted) {
  EXPECT_TRUE(read("quarter.inp", replaced(kInp, "10, 0.5, 0, 0", "10, 0.25, 0, 0")).notes.empty());
}

TEST(FemTet10Mesh, FoldAtANodeAloneIsNoted) {
  const TetMesh mesh = read("node.inp", replaced(kInp, "10, 0.5, 0, 0", "10, 0.8, 0, 0"));
  ASSERT_EQ(mesh.notes.size(), 1U);
  EXPECT_NE(mesh.notes[0].find("line 13: element 3 is folded at a node"), std::string::npos);
}

TEST(FemTet10MeshDefects, MidNodeFarOffItsEdge) {
  const std::string text = replaced(kInp, "10, 0.5, 0, 0", "10, 1.2, 0, 0");
  EXPECT_NE(error_of("far.inp", text).find("far.inp:13: element 3 is folded"), std::string::npos);
}

TEST(FemTet10MeshDefects, MixedOrders) {
  const std::string text = kInp + "*ELEMENT, TYPE=C3D4\n4, 2, 3, 4, 1\n";
  EXPECT_NE(error_of("mixed.inp", text).find("mixed.inp:26: element 4 is of another order"),
            std::string::npos);
}

TEST(FemTet10MeshDefects, UndefinedNodeOfARaisedMesh) {
  const std::string text =
      "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n*ELEMENT, TYPE=C3D4\n"
      "7, 1, 2, 3, 4\n";
  EXPECT_NE(error_of("undefined.inp", text, 2).find("undefined.inp:6: element 7 uses node 4"),
            std::string::npos);
  // A set's missing node must not become the first new one either.
  EXPECT_NE(error_of("set.inp", box_inp(1) + "*NSET, NSET=more\n1, 9\n", 2)
                .find("set.inp:24: set 'more' uses node 9"),
            std::string::npos);
}

TEST(FemTet10MeshDefects, ShortRow) {
  const std::string text = replaced(kInp, "13, 15, 14", "13, 15");
  EXPECT_NE(error_of("short.inp", text).find("short.inp:13: a C3D10 row is: number and 10 nodes"),
            std::string::npos);
}

TEST(FemTet10MeshDefects, OrderOneOfASecondOrderMesh) {
  EXPECT_NE(error_of("lower.msh", kMsh, 1).find("fem.mesh.order asks for the first"),
            std::string::npos);
}

TEST(FemTet10MeshDefects, TruncatedAnywhereIsAnError) {
  for (std::size_t size = 1; size < kMsh.find("$EndElements") + 12; ++size) {
    EXPECT_NE(error_of("cut10.msh", kMsh.substr(0, size)).find("cut10.msh:"), std::string::npos)
        << size;
  }
}

}  // namespace
}  // namespace tandem::fem

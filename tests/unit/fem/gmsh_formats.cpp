// One mesh in the versions of Gmsh's format, as text and as bytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// Numbers as a file of this kind has them.
class Writer {
 public:
  Writer(bool binary, bool swapped) : binary_(binary), swapped_(swapped) {}
  Writer& line(const std::string& words) {
    text += (text.empty() || text.back() == '\n' ? "" : "\n") + words + "\n";
    return *this;
  }
  Writer& i(std::int32_t value) { return put(value); }
  Writer& s(std::uint64_t value) { return put(value); }
  Writer& d(double value) { return put(value); }
  std::string text;

 private:
  template <class T>
  Writer& put(T value) {
    if (!binary_) {
      text += std::to_string(static_cast<std::int64_t>(value)) + "\n";
      return *this;
    }
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (swapped_) std::reverse(bytes, bytes + sizeof(T));
    text.append(bytes, sizeof(T));
    return *this;
  }
  bool binary_, swapped_;
};

constexpr int kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

void begin(Writer& file, const std::string& version, bool binary) {
  file.line("$MeshFormat").line(version + (binary ? " 1 8" : " 0 8"));
  if (binary) file.i(1);
  file.line("$EndMeshFormat");
  file.line("$PhysicalNames").line("2").line("2 7 \"base side\"").line("3 8 \"solid\"");
  file.line("$EndPhysicalNames");
}

/// A tetrahedron, its face z = 0 as the physical group 7, itself as 8.
std::string version_2(bool binary, bool swapped) {
  Writer file(binary, swapped);
  begin(file, "2.2", binary);
  file.line("$Nodes").line("4");
  for (int n = 0; n < 4; ++n) {
    file.i(n + 1).d(kCorners[n][0]).d(kCorners[n][1]).d(kCorners[n][2]);
  }
  file.line("$EndNodes").line("$Elements").line("2");
  // Text: number, type, tags; bytes: type, elements, tags, then number.
  binary ? file.i(2).i(1).i(2).i(1) : file.i(1).i(2).i(2);
  file.i(7).i(1).i(1).i(3).i(2);
  binary ? file.i(4).i(1).i(2).i(2) : file.i(2).i(4).i(2);
  file.i(8).i(1).i(1).i(2).i(3).i(4);
  return file.line("$EndElements").text;
}

std::string version_4(bool newest, bool binary, bool swapped) {
  Writer file(binary, swapped);
  begin(file, newest ? "4.1" : "4", binary);
  file.line("$Entities").s(1).s(0).s(1).s(1);
  file.i(3);
  for (int k = 0; k < (newest ? 3 : 6); ++k) file.d(0);
  file.s(0);
  for (int k = 0; k < 2; ++k) {
    file.i(5 + k);
    for (int n = 0; n < 6; ++n) file.d(n / 3);
    file.s(1).i(k == 0 ? -7 : 8).s(1).i(3);
  }
  file.line("$EndEntities").line("$Nodes").s(1).s(4);
  if (newest) file.s(1).s(4);
  const auto block = [&](int dimension, int tag) {
    newest ? file.i(dimension).i(tag) : file.i(tag).i(dimension);
  };
  block(3, 6);
  file.i(0).s(4);
  for (int n = 0; n < 4 && newest; ++n) file.s(static_cast<std::uint64_t>(n + 1));
  for (int n = 0; n < 4; ++n) {
    if (!newest) file.i(n + 1);
    file.d(kCorners[n][0]).d(kCorners[n][1]).d(kCorners[n][2]);
  }
  file.line("$EndNodes").line("$Elements").s(2).s(2);
  if (newest) file.s(1).s(2);
  const auto number = [&](int n) { newest ? file.s(static_cast<std::uint64_t>(n)) : file.i(n); };
  block(2, 5);
  file.i(2).s(1);
  for (int n : {1, 1, 3, 2}) number(n);
  block(3, 6);
  file.i(4).s(1);
  for (int n : {2, 1, 2, 3, 4}) number(n);
  return file.line("$EndElements").text;
}

void expect_one_tet(const std::string& name, const std::string& text) {
  const TetMesh mesh = read_mesh({.file = temporary_file(name, text)});
  EXPECT_EQ(mesh.node_tags, (std::vector<std::int64_t>{1, 2, 3, 4})) << name;
  ASSERT_EQ(mesh.tets.size(), 1U) << name;
  EXPECT_DOUBLE_EQ(signed_volume(mesh, mesh.tets[0]), 1.0 / 6.0) << name;
  const NodeSet& base = find_set(mesh, {.name = "base side"});
  EXPECT_EQ(base.nodes, (std::vector<int>{0, 1, 2})) << name;
  EXPECT_EQ(base.triangles.size(), 1U) << name;
  EXPECT_EQ(find_set(mesh, {.name = "solid"}).tets, (std::vector<int>{0})) << name;
}

TEST(FemGmshFormats, AllVersionsAndByteOrdersAreOneMesh) {
  for (const bool swapped : {false, true}) {
    for (const bool binary : {false, true}) {
      std::string kind = binary ? "b" : "a";
      kind += swapped ? "s.msh" : "n.msh";
      expect_one_tet("two" + kind, version_2(binary, swapped));
      expect_one_tet("four" + kind, version_4(false, binary, swapped));
      expect_one_tet("four_one" + kind, version_4(true, binary, swapped));
    }
  }
}

std::string refusal_of(const std::string& name, const std::string& text) {
  try {
    static_cast<void>(read_mesh({.file = temporary_file(name, text)}));
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), 2);
    return error.what();
  }
  return "read";
}

TEST(FemGmshFormats, EveryTruncationIsRefusedWithALine) {
  for (const std::string& text : {version_2(true, false), version_4(false, true, false),
                                  version_4(true, true, false), version_2(false, false)}) {
    for (std::size_t size = 1; size + 2 < text.size(); ++size) {
      const std::string found = refusal_of("cut.msh", text.substr(0, size));
      EXPECT_NE(found.find("cut.msh:"), std::string::npos) << size << ": " << found;
    }
  }
}

TEST(FemGmshFormats, AnElementInTwoGroupsIsOneElement) {
  std::string text = version_2(false, false);
  const std::size_t at = text.find("$Elements\n2");
  text.replace(at, 11, "$Elements\n3");
  text.insert(text.find("$EndElements"), "3 4 2 9 1 1 2 3 4\n");
  const TetMesh mesh = read_mesh({.file = temporary_file("groups.msh", text)});
  EXPECT_EQ(mesh.tets.size(), 1U);
  EXPECT_EQ(find_set(mesh, {.name = "9"}).tets, find_set(mesh, {.name = "solid"}).tets);
}

TEST(FemGmshFormats, TheAdviceNamesTheFiles) {
  const std::string found = refusal_of("first.msh", "$NOD\n4\n1 0 0 0\n");
  EXPECT_NE(found.find("first.msh:1: MSH version 1 is not read, 2 to 4.1 are. Convert it: gmsh "
                       "first.msh -save -format msh41 -o first_41.msh"),
            std::string::npos)
      << found;
  EXPECT_NE(refusal_of("next.msh", "$MeshFormat\n5 0 8\n$EndMeshFormat\n").find("MSH version 5"),
            std::string::npos);
}

}  // namespace
}  // namespace tandem::fem

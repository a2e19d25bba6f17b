#pragma once

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string>

namespace tandem::fem::testing {

/// Writes `text` to a file of its own in the temporary folder and returns the path.
inline std::filesystem::path temporary_file(const std::string& name, const std::string& text) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("tandem_fem_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name, std::ios::binary) << text;
  return folder / name;
}

/// Abaqus text of n unit cubes in a row along x, six tets each (Kuhn's division, conforming). Node
/// sets LEFT (x = 0), RIGHT (x = n), surface END (x = n), element set ALL.
inline std::string box_inp(int n) {
  const auto tag = [](int x, int y, int z) { return 1 + 4 * x + 2 * y + z; };
  std::string nodes = "*NODE\n";
  for (int x = 0; x <= n; ++x) {
    for (int y = 0; y < 2; ++y) {
      for (int z = 0; z < 2; ++z) {
        nodes += std::to_string(tag(x, y, z)) + ", " + std::to_string(x) + ", " +
                 std::to_string(y) + ", " + std::to_string(z) + "\n";
      }
    }
  }
  std::string tets = "*ELEMENT, TYPE=C3D4, ELSET=ALL\n";
  std::string faces;
  int element = 0;
  for (int x = 0; x < n; ++x) {
    std::array<int, 3> axes{0, 1, 2};
    do {
      std::array<int, 3> at{x, 0, 0};
      std::array<int, 4> corner{tag(at[0], at[1], at[2]), 0, 0, 0};
      for (std::size_t k = 0; k < 3; ++k) {
        ++at[static_cast<std::size_t>(axes[k])];
        corner[k + 1] = tag(at[0], at[1], at[2]);
      }
      const bool odd = (axes[0] > axes[1]) ^ (axes[0] > axes[2]) ^ (axes[1] > axes[2]);
      // Stepping along x first leaves corners 2, 3, 4 on the far face: S3 before a swap.
      if (odd) std::swap(corner[1], corner[2]);
      ++element;
      tets += std::to_string(element);
      for (int c : corner) tets += ", " + std::to_string(c);
      tets += "\n";
      if (x == n - 1 && axes[0] == 0) faces += std::to_string(element) + ", S3\n";
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  return nodes + tets + "*NSET, NSET=LEFT, GENERATE\n1, 4\n*NSET, NSET=RIGHT, GENERATE\n" +
         std::to_string(4 * n + 1) + ", " + std::to_string(4 * n + 4) +
         "\n*SURFACE, NAME=END, TYPE=ELEMENT\n" + faces;
}

/// Abaqus text of a box with a corner at the origin, divided into cells of six tets each. Node sets
/// LEFT and RIGHT: its ends along x. With twice the cells, the nodes are those of the same box of
/// second-order tets. Lengths of cells: six decimals at most.
inline std::string cells_inp(const std::array<int, 3>& cells, const std::array<double, 3>& size) {
  const auto tag = [&](const std::array<int, 3>& at) {
    return 1 + ((cells[1] + 1) * at[0] + at[1]) * (cells[2] + 1) + at[2];
  };
  std::string nodes = "*NODE\n";
  std::string tets = "*ELEMENT, TYPE=C3D4, ELSET=ALL\n";
  int element = 0;
  std::array<int, 3> at{};
  for (at[0] = 0; at[0] <= cells[0]; ++at[0]) {
    for (at[1] = 0; at[1] <= cells[1]; ++at[1]) {
      for (at[2] = 0; at[2] <= cells[2]; ++at[2]) {
        nodes += std::to_string(tag(at));
        for (std::size_t k = 0; k < 3; ++k) {
          nodes += ", " + std::to_string(size[k] * at[k] / cells[k]);
        }
        nodes += "\n";
        if (at[0] == cells[0] || at[1] == cells[1] || at[2] == cells[2]) continue;
        std::array<int, 3> axes{0, 1, 2};
        do {
          std::array<int, 3> corner = at;
          std::array<int, 4> tet{tag(corner), 0, 0, 0};
          for (std::size_t k = 0; k < 3; ++k) {
            ++corner[static_cast<std::size_t>(axes[k])];
            tet[k + 1] = tag(corner);
          }
          const bool odd = (axes[0] > axes[1]) ^ (axes[0] > axes[2]) ^ (axes[1] > axes[2]);
          if (odd) std::swap(tet[1], tet[2]);
          tets += std::to_string(++element);
          for (int c : tet) tets += ", " + std::to_string(c);
          tets += "\n";
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  const int end = (cells[1] + 1) * (cells[2] + 1);
  const int before = cells[0] * end;
  return nodes + tets + "*NSET, NSET=LEFT, GENERATE\n1, " + std::to_string(end) +
         "\n*NSET, NSET=RIGHT, GENERATE\n" + std::to_string(before + 1) + ", " +
         std::to_string(before + end) + "\n";
}

/// The unit cube divided into n³ cells of six tets each.
inline std::string cube_inp(int n) { return cells_inp({n, n, n}, {1.0, 1.0, 1.0}); }

}  // namespace tandem::fem::testing

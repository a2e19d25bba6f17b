#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>

#include "fem_process/output/vtu_writer.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

/// Bytes of the named array, decoded by a table-free reading of RFC 4648.
std::vector<unsigned char> array_bytes(const std::string& vtu, const std::string& name) {
  const std::size_t at = vtu.find("Name=\"" + name + "\"");
  EXPECT_NE(at, std::string::npos) << name;
  const std::size_t begin = vtu.find('>', at) + 1;
  std::vector<unsigned char> bytes;
  unsigned bits = 0;
  int held = 0;
  for (std::size_t i = begin; vtu[i] != '<' && vtu[i] != '='; ++i) {
    const char c = vtu[i];
    const int digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                                             : 63;
    bits = bits << 6 | static_cast<unsigned>(digit);
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes.push_back(static_cast<unsigned char>(bits >> held & 255U));
    }
  }
  return bytes;
}

TEST(FemVtu, ArraysHoldTheStateBitForBit) {
  FlexibleBody body(bar_with_two_ports());
  body.initialize(pair_motion(0.0));
  body.advance(request(pair_motion(0.0), pair_motion(1e-3), SimTime(1'000'000)));
  const std::string vtu = vtu_text(body.model(), body.state());
  const auto doubles = [&](const std::string& name) {
    const std::vector<unsigned char> bytes = array_bytes(vtu, name);
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data(), 4);
    EXPECT_EQ(size + 4U, bytes.size());
    Eigen::VectorXd values(size / 8);
    std::memcpy(values.data(), bytes.data() + 4, size);
    return values;
  };
  EXPECT_EQ(doubles("position_m"), body.state().x);
  EXPECT_EQ(doubles("velocity_m_per_s"), body.state().v);
  EXPECT_EQ(doubles("displacement_m"), body.state().x - body.model().reference());
  EXPECT_EQ(doubles("von_mises_Pa").size(), 369);
  const std::vector<unsigned char> types = array_bytes(vtu, "types");
  EXPECT_EQ(types.size(), 4U + 369U);
  EXPECT_EQ(types.back(), 10);  // VTK_TETRA
}

// VTK_QUADRATIC_TETRA: corners, then mid nodes of the edges 01, 12, 20, 03, 13, 23.
TEST(FemVtu, SecondOrderTetsAreQuadraticTetras) {
  Params params = bar_with_two_ports();
  params.mesh.order = 2;
  FlexibleBody body(params);
  body.initialize(pair_motion(0.0));
  const std::string vtu = vtu_text(body.model(), body.state());
  const std::vector<unsigned char> types = array_bytes(vtu, "types");
  ASSERT_EQ(types.size(), 4U + 369U);
  EXPECT_EQ(types.back(), 24);
  const std::vector<unsigned char> bytes = array_bytes(vtu, "connectivity");
  ASSERT_EQ(bytes.size(), 4U + 4U * 3690U);
  std::vector<std::int32_t> nodes(3690);
  std::memcpy(nodes.data(), bytes.data() + 4, 4 * nodes.size());
  constexpr std::size_t kVtkEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  const auto X = [&](std::size_t cell, std::size_t k) {
    return body.model().mesh.X[static_cast<std::size_t>(nodes[10 * cell + k])];
  };
  for (std::size_t cell = 0; cell < 369; ++cell) {
    for (std::size_t k = 0; k < 6; ++k) {
      const Eigen::Vector3d middle = 0.5 * (X(cell, kVtkEdges[k][0]) + X(cell, kVtkEdges[k][1]));
      EXPECT_LT((X(cell, 4 + k) - middle).norm(), 1e-15);
    }
  }
}

TEST(FemVtu, WritesEveryNthAcceptedStateAndTheCollection) {
  FlexibleBody body(bar_with_two_ports());
  const std::filesystem::path folder = temporary_file("x", "").parent_path() / "vtu";
  VtuWriter writer(body.model(), folder, "fem", 2);
  body.on_accepted([&](const State& state) { writer.write(state); });
  body.initialize(pair_motion(0.0));
  body.checkpoint();
  for (int k = 0; k < 4; ++k) {
    body.advance(request(pair_motion(1e-3 * k), pair_motion(1e-3 * (k + 1)), SimTime(1'000'000)));
    body.checkpoint();
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "fem_000000.vtu"));
  EXPECT_FALSE(std::filesystem::exists(folder / "fem_000001.vtu"));
  EXPECT_TRUE(std::filesystem::exists(folder / "fem_000004.vtu"));
  std::ifstream in(folder / "fem.pvd");
  const std::string pvd{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(pvd.find("timestep=\"0.004"), std::string::npos) << pvd;
}

}  // namespace
}  // namespace tandem::fem

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>

#include "fem_process/vtu_writer.h"
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

#include "orchestrator/verdict/body_rates.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/tandem_process.h"

namespace tandem::orchestrator {
namespace {

constexpr const char* kHeader =
    "t_s,a.p_x_m,a.w_x_rad_per_s,a.w_y_rad_per_s,a.w_z_rad_per_s,"
    "b.w_x_rad_per_s,b.w_y_rad_per_s,b.w_z_rad_per_s\n";

TEST(FastestBody, IsFoundAmongThoseThatAreAskedFor) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "bodies.csv";
  std::ofstream(file) << kHeader << "0,9,0,0,0,1,0,0\n0.1,9,3,0,4,1,0,0\n0.3,9,2,0,0,0,0,7\n";
  EXPECT_EQ(fastest_body(file).body, "b");
  EXPECT_EQ(fastest_body(file).rate_rad_per_s, 7.0);
  EXPECT_EQ(fastest_body(file, {"b"}).body, "a");
  EXPECT_EQ(fastest_body(file, {"b"}).rate_rad_per_s, 5.0);
  EXPECT_DOUBLE_EQ(fastest_body(file).turn_between_rows_rad, 7.0 * 0.2);
}

TEST(FastestBody, IsNoneWithoutATable) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(fastest_body(folder / "bodies.csv").body.empty());
}

// A killed writer's last row may lack digits.
TEST(FastestBody, PassesOverARowWithoutItsEnd) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "bodies.csv";
  std::ofstream(file) << kHeader << "0,9,0,0,2,1,0,0\n0.1,9,3,0,4,1,0,99";
  EXPECT_EQ(fastest_body(file).rate_rad_per_s, 2.0);
}

}  // namespace
}  // namespace tandem::orchestrator

// The whole drive of the tracked vehicle as users start it: 2 s and 20 000 macro steps in two
// processes, against the run in one process and against an independent program with planar rigid
// bodies.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/ancf_support.h"
#include "tests/support/tandem_process.h"

namespace tandem::test {
namespace {

using fem::ancf::testing::number;
using fem::ancf::testing::read_rows;
using fem::ancf::testing::read_table;
using fem::ancf::testing::Row;

/// The row of a time; times are whole multiples of 5 ms and more.
const Row& row_at(const std::vector<Row>& rows, const std::string& time, double t_s) {
  for (const Row& row : rows) {
    if (std::abs(number(row, time) - t_s) < 1e-6) return row;
  }
  throw Error(ErrorKind::Usage, "no row at " + std::to_string(t_s) + " s");
}

TEST(AncfDrive, TwoSecondsOverLcmAreThoseOfOneProcessBitForBitAndTheReferences) {
  const TemporaryFolder folder;
  const double patience_s = 120.0;
  const Ended remote = run_command(run_of("tracked_vehicle", folder / "lcm"), {}, patience_s);
  ASSERT_EQ(remote.code, 0) << remote.output;
  const Ended local = run_command(
      run_of("tracked_vehicle", folder / "inproc", {"--transport", "inproc"}), {}, patience_s);
  ASSERT_EQ(local.code, 0) << local.output;
  const auto here = summary_of(folder / "inproc");
  const auto there = summary_of(folder / "lcm");
  EXPECT_EQ(there.at("macro_steps"), 20000);
  EXPECT_EQ(there.at("state_hash"), here.at("state_hash"));
  EXPECT_EQ(there.at("ports"), here.at("ports"));
  for (const char* file : {"bodies.csv", "beam.csv"}) {
    EXPECT_EQ(read_file(folder / "lcm" / file), read_file(folder / "inproc" / file)) << file;
  }

  // The reference differs from itself by 0.2 % when its step is halved or doubled, velocities by
  // more: their bounce has another phase.
  const std::vector<Row> bodies = read_table((folder / "lcm" / "bodies.csv").string());
  const std::vector<Row> reference = read_rows("vehicle_base_full.csv");
  const double start = number(bodies.front(), "chassis.p_x_m");
  for (const double t : {0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0}) {
    const double expected = number(row_at(reference, "t", t), "x") - 0.41866002;
    const double moved = number(row_at(bodies, "t_s", t), "chassis.p_x_m") - start;
    EXPECT_NEAR(moved, expected, 0.01 * expected) << "t = " << t;
  }
  double speed = 0.0;
  double expected_speed = 0.0;
  int samples = 0;
  for (const Row& row : reference) {
    if (number(row, "t") <= 1.0) continue;
    expected_speed += number(row, "vx");
    speed += number(row_at(bodies, "t_s", number(row, "t")), "chassis.v_x_m_per_s");
    ++samples;
  }
  ASSERT_EQ(samples, 50);
  EXPECT_NEAR(speed, expected_speed, 0.02 * expected_speed);
}

}  // namespace
}  // namespace tandem::test

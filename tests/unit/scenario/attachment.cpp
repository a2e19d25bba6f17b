// What a bushing's keys may not say: each is refused at the place in the file, with the remedy.
#include <array>

#include "protocol/scenario/common_keys.h"
#include "tests/unit/scenario/support.h"

namespace tandem::scenario {
namespace {

Section table() {
  Section root;
  root.title = "Scenario";
  root.keys = {ports_keys()};
  return root;
}

/// A port on a bushing, whose keys stand in line 5 from column 9 on.
std::string port_with(const std::string& bushing) {
  return "ports:\n"
         "  - name: eye\n    body: arm\n    attachment: bushing\n"
         "    bushing: {" +
         bushing + "}\n    node_set: EYE\n";
}

void expect_bushing(const std::string& bushing, const std::string& column_and_words) {
  expect_defect(port_with(bushing), table(), "scenario.yaml:5:" + column_and_words);
}

/// Diagonal (1, 1, 1, 2, 2, 2) with two entries set: row, column and value of each.
struct Entry {
  int row = 1, column = 1;
  double value = 0.0;
};
std::string matrix_with(std::array<Entry, 2> entries) {
  std::array<double, 36> values{};
  for (std::size_t i = 0; i < 6; ++i) values[7 * i] = i < 3 ? 1.0 : 2.0;
  for (const Entry& e : entries) {
    values[static_cast<std::size_t>(6 * (e.row - 1) + e.column - 1)] = e.value;
  }
  std::string text = "[";
  for (double value : values) text += (text.size() > 1 ? ", " : "") + std::to_string(value);
  return text + "]";
}

TEST(BushingKeys, GoodMatricesAndDiagonalsAreAccepted) {
  for (const std::string& good :
       {std::string("stiffness_N_per_m: [1, 0, 2]"), std::string("damping_Nms_per_rad: [1, 1, 1]"),
        "stiffness_matrix: " + matrix_with({Entry{1, 5, 0.3}, Entry{5, 1, 0.3}}),
        // On the edge: (1, 1; 1, 1) is singular, so one direction is free.
        "damping_matrix: " + matrix_with({Entry{1, 2, 1.0}, Entry{2, 1, 1.0}})}) {
    EXPECT_TRUE(defects_of(port_with(good), table()).empty()) << good;
  }
}

TEST(BushingKeys, AMatrixThatIsNotSymmetricIsRefused) {
  for (const std::string key : {"stiffness_matrix", "damping_matrix"}) {
    expect_bushing(key + ": " + matrix_with({Entry{1, 5, 0.3}, Entry{5, 1, 0.2}}),
                   std::to_string(15 + key.size() + 2) + ": ports.eye.bushing." + key +
                       ": is not symmetric: row 5, column 1 differs from row 1, column 5. Write "
                       "the same value in both.");
  }
}

TEST(BushingKeys, AMatrixThatMakesEnergyIsRefused) {
  const std::string words =
      ": has a negative eigenvalue: the bushing would make energy. Make the diagonal positive and "
      "the couplings smaller.";
  expect_bushing("stiffness_matrix: " + matrix_with({Entry{1, 5, 1.5}, Entry{5, 1, 1.5}}),
                 "33: ports.eye.bushing.stiffness_matrix" + words);
  expect_bushing("damping_matrix: " + matrix_with({Entry{2, 2, -0.1}, Entry{1, 1, 1.0}}),
                 "31: ports.eye.bushing.damping_matrix" + words);
  expect_bushing("stiffness_N_per_m: [1, -1, 1]",
                 "34: ports.eye.bushing.stiffness_N_per_m" + words);
  expect_bushing("stiffness_Nm_per_rad: [1, 1, -1e-3]",
                 "37: ports.eye.bushing.stiffness_Nm_per_rad" + words);
}

TEST(BushingKeys, WrongSizesAreRefused) {
  expect_bushing("stiffness_matrix: [1, 0, 0, 1]",
                 "33: ports.eye.bushing.stiffness_matrix: has 4 entries. It must be a list of "
                 "exactly 36 numbers.");
  expect_bushing("stiffness_N_per_m: [1, 1]",
                 "34: ports.eye.bushing.stiffness_N_per_m: has 2 entries. It must be a list of "
                 "exactly 3 numbers.");
}

TEST(BushingKeys, AMatrixBesideItsDiagonalIsRefused) {
  expect_bushing("stiffness_N_per_m: [1, 1, 1], stiffness_matrix: " +
                     matrix_with({Entry{1, 1, 1.0}, Entry{2, 2, 1.0}}),
                 "63: ports.eye.bushing.stiffness_matrix: stands beside stiffness_N_per_m or "
                 "stiffness_Nm_per_rad. Give the matrix or its diagonal.");
}

TEST(BushingKeys, ABushingOfNothingIsRefused) {
  const auto lines = defects_of(port_with("stiffness_N_per_m: [0, 0, 0]"), table());
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].find("scenario.yaml:5:"), 0U) << lines[0];
  EXPECT_NE(lines[0].find("without stiffness and damping. Add stiffness_N_per_m: [x, y, z]"),
            std::string::npos)
      << lines[0];
}

TEST(BushingKeys, ABushingNeedsItsAttachmentAndTheAttachmentItsBushing) {
  expect_defect(
      "ports:\n  - name: eye\n    body: arm\n    attachment: bushing\n    node_set: EYE\n", table(),
      "scenario.yaml:2:5: ports.eye.bushing: is missing. Give a mapping of keys to values.");
  expect_defect(
      "ports:\n  - {name: eye, body: arm, node_set: EYE,\n"
      "     bushing: {stiffness_N_per_m: [1, 1, 1]}}\n",
      table(),
      "scenario.yaml:3:15: ports.eye.bushing: is not used when attachment is rigid, only when it "
      "is bushing. Remove it or change attachment.");
}

}  // namespace
}  // namespace tandem::scenario

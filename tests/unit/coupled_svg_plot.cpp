#include <gtest/gtest.h>

#include <limits>

#include "orchestrator/svg_plot.h"

namespace tandem::orchestrator {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(NiceTicks, AreWholeMultiplesOfOneTwoOrFive) {
  EXPECT_EQ(nice_ticks(0.0, 1.0, 5), (std::vector<double>{0.0, 0.2, 0.4, 3 * 0.2, 0.8, 1.0}));
  EXPECT_EQ(nice_ticks(-7.0, 12.0, 4), (std::vector<double>{-5.0, 0.0, 5.0, 10.0}));
  EXPECT_EQ(nice_ticks(990.0, 1010.0, 2), (std::vector<double>{990.0, 1000.0, 1010.0}));
  EXPECT_TRUE(nice_ticks(1.0, 1.0, 5).empty());
}

TEST(SvgDocument, IsTheSameTextForTheSamePlots) {
  const Plot plot{.title = "A", .series = {{.label = "s", .x = {0, 1, 2}, .y = {3, 1, 2}}}};
  EXPECT_EQ(svg_document({plot}), svg_document({plot}));
}

TEST(SvgDocument, BreaksTheLineWhereAValueCannotBeShown) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Plot gap{.series = {{.label = "s", .x = {0, 1, 2, 3, 4}, .y = {1, 2, nan, 2, 1}}}};
  EXPECT_EQ(count(svg_document({gap}), "M"), 2U);
  EXPECT_EQ(count(svg_document({gap}), "nan"), 0U);
  // Zero and negative numbers have no logarithm.
  const Plot log{.y_scale = AxisScale::Logarithmic,
                 .series = {{.label = "s", .x = {0, 1, 2, 3}, .y = {1, 0, -1, 10}}}};
  EXPECT_EQ(count(svg_document({log}), "M"), 2U);
  EXPECT_EQ(count(svg_document({log}), "nan") + count(svg_document({log}), "inf"), 0U);
}

TEST(SvgDocument, EscapesLabelsAndNamesEverySeries) {
  const Plot plot{.title = "a < b & \"c\"",
                  .series = {{.label = "one", .x = {0, 1}, .y = {0, 1}},
                             {.label = "two", .x = {0, 1}, .y = {1, 0}}}};
  const std::string svg = svg_document({plot});
  EXPECT_NE(svg.find("a &lt; b &amp; &quot;c&quot;"), std::string::npos);
  EXPECT_EQ(count(svg, ">one<") + count(svg, ">two<"), 2U);
}

TEST(SvgDocument, ShowsPlotsWithoutDataOrSpread) {
  const Plot empty{.title = "empty"};
  const Plot flat{.series = {{.label = "s", .x = {0, 1}, .y = {5, 5}}}};
  const std::string svg = svg_document({empty, flat}, 2);
  EXPECT_EQ(count(svg, "nan") + count(svg, "inf"), 0U);
  EXPECT_EQ(count(svg, "<g "), 2U);
}

}  // namespace
}  // namespace tandem::orchestrator

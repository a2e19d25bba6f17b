#include "orchestrator/page/svg_plot.h"

#include <gtest/gtest.h>

#include <limits>
#include <regex>
#include <set>

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

TEST(LogTicks, AreAtLeastThreeHoweverShortTheAxis) {
  EXPECT_EQ(log_ticks(1e-3, 1.0, 10), (std::vector<double>{1e-3, 1e-2, 1e-1, 1.0}));
  EXPECT_EQ(log_ticks(0.8, 90.0, 10).size(), 6U);  // 1, 2, 5, 10, 20, 50
  EXPECT_EQ(log_ticks(0.8, 30.0, 10), (std::vector<double>{1.0, 2.0, 5.0, 10.0, 20.0}));
  // An error that halves with the step: a third of a decade.
  for (const double low : {1.1e-3, 4.9e-4, 0.07, 9.0, 123.0}) {
    EXPECT_GE(log_ticks(low, 2.1 * low, 10).size(), 3U) << low;
    EXPECT_GE(log_ticks(low, 1.01 * low, 10).size(), 3U) << low;
  }
  const std::vector<double> many = log_ticks(1e-30, 1.0, 10);
  EXPECT_LE(many.size(), 10U);
  EXPECT_GE(many.size(), 5U);
}

/// All groups of a regular expression's first match in each line.
std::vector<std::smatch> matches(const std::string& text, const char* expression) {
  const std::regex regex(expression);
  return {std::sregex_iterator(text.begin(), text.end(), regex), std::sregex_iterator()};
}

Plot plot_of(int series, const std::string& label) {
  Plot plot;
  for (int i = 0; i < series; ++i) {
    plot.series.push_back({.label = label + std::to_string(i), .x = {0, 1}, .y = {0, 1.0 * i}});
  }
  return plot;
}

// A sans-serif font of 12 pixels is about 6.1 pixels a character wide (measured:
// "interface_jacobian, adaptive" in DejaVu Sans, 170 pixels).
TEST(SvgDocument, LegendHasRoomInItsOwnPlot) {
  for (const int series : {2, 3, 9, 30}) {
    const std::string label = "interface_jacobian of a name that is long, adaptive ";
    const std::string svg = svg_document({plot_of(series, label), plot_of(series, label)}, 2);
    const auto box = matches(svg, "viewBox=\"0 0 ([0-9]+) ([0-9]+)\"");
    ASSERT_EQ(box.size(), 1U);
    const double width = 0.5 * std::stod(box[0][1]), height = std::stod(box[0][2]);
    const auto labels =
        matches(svg, "<text x=\"([0-9.]+)\" y=\"([0-9.]+)\" text-anchor=\"start\">([^<]*)<");
    EXPECT_EQ(labels.size(), 2U * static_cast<unsigned>(series));
    for (const auto& text : labels) {
      EXPECT_LT(std::stod(text[1]) + 6.1 * static_cast<double>(text[3].length()), width);
      EXPECT_LT(std::stod(text[2]), height);
    }
  }
}

TEST(SvgDocument, NoTwoCurvesLookTheSame) {
  Plot plot = plot_of(21, "");
  for (std::size_t i = 1; i < plot.series.size(); i += 2) {
    plot.series[i].dashed = plot.series[i].as_before = true;
  }
  for (const Plot& p : {plot, plot_of(21, "")}) {
    std::set<std::string> looks;
    const std::string svg = svg_document({p});
    for (const auto& path : matches(svg, "<path [^>]*stroke=(\"#[^>]*)/>")) looks.insert(path[1]);
    EXPECT_EQ(looks.size(), 21U);
  }
}

// Numbers of colours or names that go on from document to document would change a report's bytes.
TEST(SvgDocument, IsTheSameTextWhateverWasDrawnBefore) {
  const Plot plot{.title = "A", .series = {{.label = "s", .x = {0, 1, 2}, .y = {3, 1, 2}}}};
  const std::string first = svg_document({plot});
  (void)svg_document({plot_of(21, "B"), plot});
  EXPECT_EQ(svg_document({plot}), first);
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

#pragma once

#include <string>
#include <vector>

namespace tandem::orchestrator {

enum class AxisScale { Linear, Logarithmic };

/// One curve. On a logarithmic axis points that are not positive are left out, on any axis those
/// that are not finite; the line is broken there.
struct PlotSeries {
  std::string label;
  std::vector<double> x, y;
  bool markers = false;  ///< a dot at every point
  bool dashed = false;
  bool as_before = false;  ///< in the colour of the series before: a variant of it
};

/// A line plot. Labels carry the units: "t (s)". Series' labels stand beside the frame; the plot
/// is as wide and as high as they need.
struct Plot {
  std::string title;
  std::string x_label, y_label;
  AxisScale x_scale = AxisScale::Linear;
  AxisScale y_scale = AxisScale::Linear;
  std::vector<PlotSeries> series;
};

/// As text, or the value of an attribute, in SVG and HTML.
[[nodiscard]] std::string escaped(const std::string& text);

/// Positions of 1-2-5 ticks within [low, high], about `wanted` of them.
[[nodiscard]] std::vector<double> nice_ticks(double low, double high, int wanted);

/// Positions of ticks of a logarithmic axis within [low, high], both above 0: powers of ten, at
/// most `most` of them; where there are fewer than three, also 2 and 5 times these; and where that
/// is too little, as nice_ticks.
[[nodiscard]] std::vector<double> log_ticks(double low, double high, int most);

/// The plots as one SVG document, `columns` side by side, self-contained (no scripts, no fonts, no
/// links). Curves take the colours of Okabe & Ito (2008), which colour-blind people can tell apart;
/// more curves than colours differ by their dashes. Deterministic: the same plots give the same
/// text.
[[nodiscard]] std::string svg_document(const std::vector<Plot>& plots, int columns = 1);

}  // namespace tandem::orchestrator

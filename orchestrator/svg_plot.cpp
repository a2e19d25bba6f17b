#include "orchestrator/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tandem::orchestrator {
namespace {

// Sizes in pixels.
constexpr double kWidth = 640.0, kHeight = 360.0;
constexpr double kLeft = 78.0, kRight = 170.0, kTop = 34.0, kBottom = 50.0;
constexpr double kLegendRow = 16.0;

// Okabe & Ito (2008): black, vermillion, blue, bluish green, orange, reddish purple, sky blue.
constexpr std::array<const char*, 7> kColours = {"#000000", "#d55e00", "#0072b2", "#009e73",
                                                 "#e69f00", "#cc79a7", "#56b4e9"};

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else {
      out += c;
    }
  }
  return out;
}

/// One axis: data values to pixels.
class Axis {
 public:
  Axis(AxisScale scale, double pixel_low, double pixel_high)
      : scale_(scale), pixel_low_(pixel_low), pixel_high_(pixel_high) {}

  [[nodiscard]] bool shows(double value) const {
    return std::isfinite(value) && (scale_ == AxisScale::Linear || value > 0.0);
  }
  void include(double value) {
    low_ = std::min(low_, coordinate(value));
    high_ = std::max(high_, coordinate(value));
  }
  /// Room around the data; an axis without data, or of one value, gets a width.
  void settle(double margin) {
    if (low_ > high_) low_ = high_ = 0.0;
    const double width = high_ - low_;
    const double half = std::max(0.5 * std::abs(low_), 0.5);
    const double room = width > 0.0 ? margin * width : half;
    low_ -= room;
    high_ += room;
  }
  [[nodiscard]] double pixel(double value) const {
    return pixel_low_ + (coordinate(value) - low_) / (high_ - low_) * (pixel_high_ - pixel_low_);
  }
  [[nodiscard]] std::vector<double> ticks(int wanted) const {
    if (scale_ == AxisScale::Linear) return nice_ticks(low_, high_, wanted);
    // Decades; over less than two also their 2 and 5.
    std::vector<double> ticks;
    const bool fine = high_ - low_ < 2.0;
    for (int decade = static_cast<int>(std::floor(low_)); decade <= high_; ++decade) {
      for (double factor : {1.0, 2.0, 5.0}) {
        const double value = factor * std::pow(10.0, decade);
        const bool inside = coordinate(value) >= low_ && coordinate(value) <= high_;
        if (inside && (fine || factor == 1.0)) ticks.push_back(value);
      }
    }
    return ticks;
  }

 private:
  [[nodiscard]] double coordinate(double value) const {
    return scale_ == AxisScale::Linear ? value : std::log10(value);
  }
  AxisScale scale_;
  double pixel_low_, pixel_high_;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

std::string text(double x, double y, const char* anchor, const std::string& content,
                 const char* extra = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, extra, escaped(content));
}

std::string line(double x1, double y1, double x2, double y2, const char* colour) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x1, y1, x2,
      y2, colour);
}

std::string dash_of(const PlotSeries& series) {
  return series.dashed ? " stroke-dasharray=\"6 4\"" : "";
}

std::string frame(const Plot& plot, const Axis& x, const Axis& y) {
  std::string out;
  for (double value : x.ticks(6)) {
    const double at = x.pixel(value);
    out += line(at, kTop, at, kHeight - kBottom, "#dddddd");
    out += text(at, kHeight - kBottom + 16, "middle", fmt::format("{:.4g}", value));
  }
  for (double value : y.ticks(6)) {
    const double at = y.pixel(value);
    out += line(kLeft, at, kWidth - kRight, at, "#dddddd");
    out += text(kLeft - 6, at + 4, "end", fmt::format("{:.4g}", value));
  }
  out += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" "
      "stroke=\"#444444\"/>\n",
      kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - kBottom);
  out += text(0.5 * (kLeft + kWidth - kRight), kHeight - 14, "middle", plot.x_label);
  const double middle = 0.5 * (kTop + kHeight - kBottom);
  out += text(16, middle, "middle", plot.y_label,
              fmt::format(" transform=\"rotate(-90 16 {:.1f})\"", middle).c_str());
  out += text(0.5 * (kLeft + kWidth - kRight), 20, "middle", plot.title, " font-weight=\"bold\"");
  return out;
}

std::string curve(const PlotSeries& series, const char* colour, const Axis& x, const Axis& y) {
  std::string path;
  std::string dots;
  bool pen_down = false;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.y[i])) {
      pen_down = false;
      continue;
    }
    const double px = x.pixel(series.x[i]);
    const double py = y.pixel(series.y[i]);
    path += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M", px, py);
    pen_down = true;
    if (series.markers) {
      dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>\n", px, py,
                          colour);
    }
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"{}/>\n", path,
                     colour, dash_of(series)) +
         dots;
}

/// Beside the frame, where it covers no curve.
std::string legend(const Plot& plot) {
  std::string out;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const double left = kWidth - kRight + 10.0;
    const double at = kTop + kLegendRow * (static_cast<double>(i) + 0.5);
    out += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{2:.1f}\" y2=\"{1:.1f}\" stroke=\"{3}\" "
        "stroke-width=\"1.5\"{4}/>\n",
        left, at, left + 24, kColours[i % kColours.size()], dash_of(plot.series[i]));
    out += text(left + 29, at + 4, "start", plot.series[i].label);
  }
  return out;
}

std::string drawn(const Plot& plot) {
  Axis x(plot.x_scale, kLeft, kWidth - kRight);
  Axis y(plot.y_scale, kHeight - kBottom, kTop);
  for (const PlotSeries& series : plot.series) {
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!x.shows(series.x[i]) || !y.shows(series.y[i])) continue;
      x.include(series.x[i]);
      y.include(series.y[i]);
    }
  }
  x.settle(plot.x_scale == AxisScale::Linear ? 0.0 : 0.05);
  y.settle(0.06);
  std::string out = frame(plot, x, y);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    out += curve(plot.series[i], kColours[i % kColours.size()], x, y);
  }
  if (plot.series.size() > 1) out += legend(plot);
  return out;
}

}  // namespace

std::vector<double> nice_ticks(double low, double high, int wanted) {
  std::vector<double> ticks;
  if (!(high > low) || wanted < 1) return ticks;
  const double raw = (high - low) / wanted;
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * decade;
  for (double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= raw) {
      step = factor * decade;
      break;
    }
  }
  // Whole multiples, so that zero is 0 and not a sum's round-off.
  const double first = std::ceil(low / step);
  const double last = std::floor(high / step);
  for (double n = first; n <= last; n += 1.0) ticks.push_back(n == 0.0 ? 0.0 : n * step);
  return ticks;
}

std::string svg_document(const std::vector<Plot>& plots, int columns) {
  const int across = std::max(1, std::min(columns, static_cast<int>(plots.size())));
  const int down = (static_cast<int>(plots.size()) + across - 1) / across;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "width=\"{0:.0f}\" height=\"{1:.0f}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      kWidth * across, kHeight * down);
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const int index = static_cast<int>(i);
    out += fmt::format("<g transform=\"translate({:.0f} {:.0f})\">\n", kWidth * (index % across),
                       kHeight * (index / across));
    out += drawn(plots[i]);
    out += "</g>\n";
  }
  return out + "</svg>\n";
}

}  // namespace tandem::orchestrator

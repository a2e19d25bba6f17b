#include "orchestrator/page/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tandem::orchestrator {
namespace {

// Sizes in pixels.
constexpr double kHeight = 360.0;
constexpr double kLeft = 78.0, kFrameRight = 470.0, kTop = 34.0, kBottom = 50.0;
constexpr double kLegendRow = 16.0, kLegendLine = 24.0, kLegendText = kFrameRight + 39.0;
constexpr double kLeastWidth = 640.0;  // with room for 20 characters beside the frame
constexpr double kCharacter = 6.5;     // mean width in a sans-serif font of 12 pixels

// Okabe & Ito (2008): black, vermillion, blue, bluish green, orange, reddish purple, sky blue.
constexpr std::array<const char*, 7> kColours = {"#000000", "#d55e00", "#0072b2", "#009e73",
                                                 "#e69f00", "#cc79a7", "#56b4e9"};

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
    return log_ticks(std::pow(10.0, low_), std::pow(10.0, high_), wanted + 4);
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

/// How a curve is drawn.
struct Look {
  const char* colour;
  std::string dashes;  ///< the attribute
};

/// Each series another colour than the one before, and other dashes once the colours are used up.
std::vector<Look> looks_of(const Plot& plot) {
  constexpr std::array<const char*, 3> kSolid = {"", "2 3", "10 3 2 3"};
  constexpr std::array<const char*, 3> kDashed = {"6 4", "4 2", "12 4"};
  std::vector<Look> looks;
  std::size_t hue = 0;
  for (const PlotSeries& series : plot.series) {
    if (!looks.empty() && !series.as_before) ++hue;
    const auto& kinds = series.dashed ? kDashed : kSolid;
    const std::string dashes = kinds[hue / kColours.size() % kinds.size()];
    looks.push_back({kColours[hue % kColours.size()],
                     dashes.empty() ? "" : " stroke-dasharray=\"" + dashes + "\""});
  }
  return looks;
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
    out += line(kLeft, at, kFrameRight, at, "#dddddd");
    out += text(kLeft - 6, at + 4, "end", fmt::format("{:.4g}", value));
  }
  out += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" "
      "stroke=\"#444444\"/>\n",
      kLeft, kTop, kFrameRight - kLeft, kHeight - kTop - kBottom);
  out += text(0.5 * (kLeft + kFrameRight), kHeight - 14, "middle", plot.x_label);
  const double middle = 0.5 * (kTop + kHeight - kBottom);
  out += text(16, middle, "middle", plot.y_label,
              fmt::format(" transform=\"rotate(-90 16 {:.1f})\"", middle).c_str());
  out += text(0.5 * (kLeft + kFrameRight), 20, "middle", plot.title, " font-weight=\"bold\"");
  return out;
}

std::string curve(const PlotSeries& series, const Look& look, const Axis& x, const Axis& y) {
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
                          look.colour);
    }
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"{}/>\n", path,
                     look.colour, look.dashes) +
         dots;
}

/// Beside the frame, where it covers no curve.
std::string legend(const Plot& plot, const std::vector<Look>& looks) {
  std::string out;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const double left = kFrameRight + 10.0;
    const double at = kTop + kLegendRow * (static_cast<double>(i) + 0.5);
    out += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{2:.1f}\" y2=\"{1:.1f}\" stroke=\"{3}\" "
        "stroke-width=\"1.5\"{4}/>\n",
        left, at, left + kLegendLine, looks[i].colour, looks[i].dashes);
    out += text(kLegendText, at + 4, "start", plot.series[i].label);
  }
  return out;
}

std::string drawn(const Plot& plot) {
  Axis x(plot.x_scale, kLeft, kFrameRight);
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
  const std::vector<Look> looks = looks_of(plot);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    out += curve(plot.series[i], looks[i], x, y);
  }
  if (plot.series.size() > 1) out += legend(plot, looks);
  return out;
}

/// Of a text in UTF-8: all bytes but those that continue a character.
std::size_t characters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) >> 6U) != 2; }));
}

/// The size of one plot, the same for all of a document.
struct Size {
  double width = kLeastWidth, height = kHeight;
};

Size size_of(const std::vector<Plot>& plots) {
  Size size;
  for (const Plot& plot : plots) {
    for (const PlotSeries& series : plot.series) {
      const double label = kCharacter * static_cast<double>(characters(series.label));
      size.width = std::max(size.width, std::ceil(kLegendText + label));
    }
    const double rows = kLegendRow * static_cast<double>(plot.series.size() + 1);
    size.height = std::max(size.height, kTop + rows);
  }
  return size;
}

}  // namespace

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

std::vector<double> log_ticks(double low, double high, int most) {
  const double first = std::ceil(std::log10(low));
  const double last = std::floor(std::log10(high));
  const bool fine = last - first < 2.0;
  const double stride = std::max(1.0, std::ceil((last - first + 1.0) / most));
  std::vector<double> ticks;
  for (double decade = fine ? first - 1.0 : first; decade <= last; decade += stride) {
    for (double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10.0, decade);
      if (value >= low && value <= high && (fine || factor == 1.0)) ticks.push_back(value);
    }
  }
  for (int wanted = 4; ticks.size() < 3 && wanted <= most; ++wanted) {
    ticks = nice_ticks(low, high, wanted);
  }
  return ticks;
}

std::string svg_document(const std::vector<Plot>& plots, int columns) {
  const Size size = size_of(plots);
  const int across = std::max(1, std::min(columns, static_cast<int>(plots.size())));
  const int down = (static_cast<int>(plots.size()) + across - 1) / across;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "width=\"{0:.0f}\" height=\"{1:.0f}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      size.width * across, size.height * down);
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const int index = static_cast<int>(i);
    out += fmt::format("<g transform=\"translate({:.0f} {:.0f})\">\n",
                       size.width * (index % across), size.height * (index / across));
    out += drawn(plots[i]);
    out += "</g>\n";
  }
  return out + "</svg>\n";
}

}  // namespace tandem::orchestrator

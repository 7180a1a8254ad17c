// SPDX-License-Identifier: MIT
#include "edvo/report/plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <string_view>

namespace edvo {
namespace {

// Sizes in SVG user units [px].
constexpr double kWidth = 760;
constexpr double kPlotHeight = 300;
constexpr double kMapHeight = 480;
constexpr double kLeft = 74, kRight = 16, kTop = 40, kBottom = 50;
constexpr double kLegendRow = 20;
constexpr double kGlyphWidth = 7;    // of the 13 px font, on average
constexpr double kInvisible = 0.2;   // deviation of a line that cannot be seen
constexpr double kTickSpacing = 80;  // between grid lines, at least [px]
constexpr double kRowSpacing = 50;   // the same between horizontal ones [px]

// Okabe and Ito's colours: told apart by the colour-blind, on white and on black.
// After the last one they come again, dashed.
constexpr std::array<std::string_view, 6> kPalette = {"#0072b2", "#d55e00", "#009e73",
                                                      "#cc79a7", "#e69f00", "#56b4e9"};
constexpr std::string_view kTextColor = "#767b82";  // contrast above 4 on white and on black

struct Point {
  double x = 0, y = 0;
};

struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
};

// Plot area in the picture and the values at its borders.
struct Canvas {
  double left = 0, top = 0, width = 0, height = 0;  // [px]
  Interval x, y;
};

double length(const Interval& interval) {
  return interval.high - interval.low;
}

std::string escape(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

bool is_drawable(const Series& series, std::size_t i) {
  return std::isfinite(series.x[i]) && std::isfinite(series.y[i]);
}

void cover(Interval& interval, double value) {
  interval.low = std::min(interval.low, value);
  interval.high = std::max(interval.high, value);
}

// A little air around the data, also where all values are the same or there are none.
Interval with_margin(Interval interval) {
  if (interval.low > interval.high) return {0, 1};
  const double smallest = 1e-6 * std::max(std::abs(interval.low), std::abs(interval.high));
  const double margin = std::max({0.03 * length(interval), smallest, 1e-9});
  return {interval.low - margin, interval.high + margin};
}

Interval widened_to(const Interval& interval, double wanted) {
  const double extra = 0.5 * (wanted - length(interval));
  return {interval.low - extra, interval.high + extra};
}

Canvas make_canvas(const Plot& plot, double top) {
  Canvas canvas{.left = kLeft,
                .top = top,
                .width = kWidth - kLeft - kRight,
                .height = plot.equal_axes ? kMapHeight : kPlotHeight,
                .x = {},
                .y = {}};
  for (const Series& series : plot.series)
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (is_drawable(series, i)) {
        cover(canvas.x, series.x[i]);
        cover(canvas.y, series.y[i]);
      }
  canvas.x = with_margin(canvas.x);
  canvas.y = with_margin(canvas.y);
  if (plot.equal_axes) {
    const double unit_per_px =
        std::max(length(canvas.x) / canvas.width, length(canvas.y) / canvas.height);
    canvas.x = widened_to(canvas.x, unit_per_px * canvas.width);
    canvas.y = widened_to(canvas.y, unit_per_px * canvas.height);
  }
  return canvas;
}

Point to_pixel(const Canvas& canvas, double x, double y) {
  return {canvas.left + (x - canvas.x.low) / length(canvas.x) * canvas.width,
          canvas.top + (canvas.y.high - y) / length(canvas.y) * canvas.height};
}

double distance_to_chord(const Point& p, const Point& a, const Point& b) {
  const Point chord{b.x - a.x, b.y - a.y};
  const double squared = chord.x * chord.x + chord.y * chord.y;
  if (squared == 0) return std::hypot(p.x - a.x, p.y - a.y);
  const double along =
      std::clamp(((p.x - a.x) * chord.x + (p.y - a.y) * chord.y) / squared, 0.0, 1.0);
  return std::hypot(p.x - a.x - along * chord.x, p.y - a.y - along * chord.y);
}

// Ramer, Douglas and Peucker: keeps the points without which the line would look different.
std::vector<Point> thinned(const std::vector<Point>& line) {
  if (line.size() < 3) return line;
  std::vector<bool> keep(line.size(), false);
  keep.front() = keep.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> open = {{0, line.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    std::size_t farthest = first;
    double largest = kInvisible;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double distance = distance_to_chord(line[i], line[first], line[last]);
      if (distance > largest) {
        largest = distance;
        farthest = i;
      }
    }
    if (farthest == first) continue;
    keep[farthest] = true;
    open.emplace_back(first, farthest);
    open.emplace_back(farthest, last);
  }
  std::vector<Point> kept;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (keep[i]) kept.push_back(line[i]);
  return kept;
}

std::string path_of(const std::vector<Point>& line) {
  std::string path;
  const std::vector<Point> points = thinned(line);
  for (std::size_t i = 0; i < points.size(); ++i)
    path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", points[i].x, points[i].y);
  if (points.size() == 1) path += "h0";  // with round caps: a dot
  return path;
}

std::string path_of(const Canvas& canvas, const Series& series) {
  std::string path;
  std::vector<Point> line;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (is_drawable(series, i)) {
      line.push_back(to_pixel(canvas, series.x[i], series.y[i]));
    } else {
      path += path_of(line);
      line.clear();
    }
  }
  return path + path_of(line);
}

// At least so large, and 1, 2 or 5 times a power of ten.
double tick_step(double raw) {
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= raw) return factor * power;
  return 10.0 * power;
}

std::string tick_label(double value, double step) {
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  if (decimals > 6 || std::abs(value) >= 1e7) return fmt::format("{:.4g}", value);
  return fmt::format("{:.{}f}", std::abs(value) < 0.5 * step ? 0.0 : value, decimals);
}

std::string text(double x, double y, std::string_view anchor, std::string_view content) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                     escape(content));
}

std::string axes_of(const Canvas& canvas, const Plot& plot) {
  std::string labels, grid;
  const double bottom = canvas.top + canvas.height;
  const double right = canvas.left + canvas.width;
  // The grid of a map is made of squares.
  const double row_spacing = plot.equal_axes ? kTickSpacing : kRowSpacing;
  const double x_step = tick_step(length(canvas.x) / canvas.width * kTickSpacing);
  const double y_step = tick_step(length(canvas.y) / canvas.height * row_spacing);
  for (double i = std::ceil(canvas.x.low / x_step); i * x_step <= canvas.x.high; ++i) {
    const double x = to_pixel(canvas, i * x_step, 0).x;
    grid += fmt::format("M{:.1f} {:.1f}V{:.1f}", x, canvas.top, bottom);
    labels += text(x, bottom + 17, "middle", tick_label(i * x_step, x_step));
  }
  for (double i = std::ceil(canvas.y.low / y_step); i * y_step <= canvas.y.high; ++i) {
    const double y = to_pixel(canvas, 0, i * y_step).y;
    grid += fmt::format("M{:.1f} {:.1f}H{:.1f}", canvas.left, y, right);
    labels += text(canvas.left - 8, y + 4, "end", tick_label(i * y_step, y_step));
  }
  const double middle = canvas.top + 0.5 * canvas.height;
  return fmt::format("<path d=\"{}\" stroke=\"#888\" stroke-opacity=\".3\" fill=\"none\"/>\n",
                     grid) +
         fmt::format(
             "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" "
             "stroke=\"#888\" stroke-opacity=\".7\"/>\n",
             canvas.left, canvas.top, canvas.width, canvas.height) +
         labels + text(canvas.left + 0.5 * canvas.width, bottom + 38, "middle", plot.x_label) +
         fmt::format(
             "<text transform=\"translate(16 {:.1f}) rotate(-90)\" "
             "text-anchor=\"middle\">{}</text>\n",
             middle, escape(plot.y_label));
}

// How a line is drawn: the attributes of its stroke.
std::string stroke_of(const Plot& plot, std::size_t i) {
  if (!plot.series[i].color.empty())
    return fmt::format("stroke=\"{}\"", escape(plot.series[i].color));
  // Lines of given colours use up none of the palette: the n-th of the others looks the same in all
  // plots of a page.
  const auto before = plot.series.begin() + static_cast<std::ptrdiff_t>(i);
  const auto n = static_cast<std::size_t>(std::count_if(
      plot.series.begin(), before, [](const Series& series) { return series.color.empty(); }));
  const bool dashed = n / kPalette.size() % 2 == 1;
  return fmt::format("stroke=\"{}\"{}", kPalette[n % kPalette.size()],
                     dashed ? " stroke-dasharray=\"6 4\"" : "");
}

struct Legend {
  std::string svg;
  double height = 0;  // [px]
};

double legend_width(const Series& series) {
  return 46 + kGlyphWidth * static_cast<double>(series.name.size());
}

Legend make_legend(const Plot& plot) {
  if (plot.series.size() < 2) return {};
  Legend legend{.svg = {}, .height = kLegendRow};
  double x = kLeft;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const double width = legend_width(plot.series[i]);
    if (x > kLeft && x + width > kWidth) {
      x = kLeft;
      legend.height += kLegendRow;
    }
    const double y = kTop + legend.height - kLegendRow;
    legend.svg += fmt::format("<path d=\"M{:.1f} {:.1f}h22\" {} stroke-width=\"3\"/>", x, y,
                              stroke_of(plot, i));
    legend.svg += text(x + 28, y + 4, "start", plot.series[i].name);
    x += width;
  }
  return legend;
}

}  // namespace

std::string to_svg(const Plot& plot) {
  const Legend legend = make_legend(plot);
  const Canvas canvas = make_canvas(plot, kTop + legend.height);
  const double height = canvas.top + canvas.height + kBottom;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" style=\"max-width:100%;height:auto\" role=\"img\" aria-label=\"{2}\" "
      "font-family=\"system-ui,sans-serif\" font-size=\"13\" fill=\"{3}\">\n",
      kWidth, height, escape(plot.title), kTextColor);
  svg += fmt::format("<text x=\"{}\" y=\"22\" font-size=\"15\" font-weight=\"600\">{}</text>\n",
                     kLeft, escape(plot.title));
  svg += legend.svg + axes_of(canvas, plot);
  bool empty = true;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    assert(plot.series[i].x.size() == plot.series[i].y.size());
    const std::string path = path_of(canvas, plot.series[i]);
    if (path.empty()) continue;
    empty = false;
    svg += fmt::format(
        "<path d=\"{}\" fill=\"none\" {} stroke-width=\"1.6\" stroke-linejoin=\"round\" "
        "stroke-linecap=\"round\"><title>{}</title></path>\n",
        path, stroke_of(plot, i), escape(plot.series[i].name));
  }
  if (empty)
    svg += text(canvas.left + 0.5 * canvas.width, canvas.top + 0.5 * canvas.height, "middle",
                "no data");
  return svg + "</svg>\n";
}

}  // namespace edvo

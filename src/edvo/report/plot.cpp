// SPDX-License-Identifier: MIT
#include "edvo/report/plot.hpp"

#include "edvo/report/markup.hpp"
#include "edvo/report/plot_events.hpp"

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
constexpr double kPlotHeight = 300;
constexpr double kMapHeight = 480;
constexpr double kLeft = 74, kRight = 16, kTop = 10, kBottom = 50;
constexpr double kTitleHeight = 30;
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

using Interval = Limits;
constexpr Interval kEmpty{.low = std::numeric_limits<double>::infinity(),
                          .high = -std::numeric_limits<double>::infinity()};

// Plot area in the picture and the values at its borders.
struct Canvas {
  double left = 0, top = 0, width = 0, height = 0;  // [px]
  Interval x = kEmpty, y = kEmpty;
};

double length(const Interval& interval) {
  return interval.high - interval.low;
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
                .width = plot.width - kLeft - kRight,
                .height = plot.equal_axes ? kMapHeight : kPlotHeight};
  if (plot.height > 0) canvas.height = plot.height - top - kBottom;
  for (const Series& series : plot.series)
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (is_drawable(series, i)) {
        cover(canvas.x, series.x[i]);
        cover(canvas.y, series.y[i]);
      }
  canvas.x = plot.x_limits.value_or(with_margin(canvas.x));
  canvas.y = plot.y_limits.value_or(with_margin(canvas.y));
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

// A line of many points from left to right, cut to what one column of pixels can show of it: where
// it enters and leaves, its lowest and its highest point.
std::vector<Point> one_column_each(const std::vector<Point>& line) {
  std::vector<Point> kept;
  std::size_t first = 0;
  while (first < line.size()) {
    std::size_t end = first + 1;
    while (end < line.size() && std::floor(line[end].x) == std::floor(line[first].x)) ++end;
    const auto [low, high] =
        std::minmax_element(line.begin() + static_cast<std::ptrdiff_t>(first),
                            line.begin() + static_cast<std::ptrdiff_t>(end),
                            [](const Point& a, const Point& b) { return a.y < b.y; });
    std::array<std::size_t, 4> chosen = {first, static_cast<std::size_t>(low - line.begin()),
                                         static_cast<std::size_t>(high - line.begin()), end - 1};
    std::sort(chosen.begin(), chosen.end());
    for (std::size_t i = 0; i < chosen.size(); ++i)
      if (i == 0 || chosen[i] != chosen[i - 1]) kept.push_back(line[chosen[i]]);
    first = end;
  }
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

std::string path_of(const Canvas& canvas, const Series& series, bool is_map) {
  std::string path;
  std::vector<Point> line;
  const auto finish_line = [&] {
    path += path_of(is_map ? line : one_column_each(line));
    line.clear();
  };
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (is_drawable(series, i)) {
      line.push_back(to_pixel(canvas, series.x[i], series.y[i]));
    } else {
      finish_line();
    }
  }
  finish_line();
  return path;
}

// Series on top of each other: each becomes the sum of itself and those before it.
std::vector<Series> piled_up(std::vector<Series> series) {
  for (std::size_t k = 0; k < series.size(); ++k)
    for (std::size_t i = 0; i < series[k].y.size(); ++i) {
      if (!std::isfinite(series[k].y[i])) series[k].y[i] = 0;
      if (k > 0) series[k].y[i] += series[k - 1].y[i];
    }
  return series;
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
                     escape_markup(content));
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
             middle, escape_markup(plot.y_label));
}

// The place of a series in the palette. Lines of given colours use up none of it: the n-th of the
// others looks the same in all plots of a page.
std::size_t palette_index(const Plot& plot, std::size_t i) {
  const auto before = plot.series.begin() + static_cast<std::ptrdiff_t>(i);
  return static_cast<std::size_t>(std::count_if(
      plot.series.begin(), before, [](const Series& series) { return series.color.empty(); }));
}

std::string color_of(const Plot& plot, std::size_t i) {
  if (!plot.series[i].color.empty()) return escape_markup(plot.series[i].color);
  return std::string(kPalette[palette_index(plot, i) % kPalette.size()]);
}

// How a line is drawn: the attributes of its stroke.
std::string stroke_of(const Plot& plot, std::size_t i) {
  const bool dashed =
      plot.series[i].color.empty() && palette_index(plot, i) / kPalette.size() % 2 == 1;
  return fmt::format("stroke=\"{}\"{}", color_of(plot, i),
                     dashed ? " stroke-dasharray=\"6 4\"" : "");
}

struct Legend {
  std::string svg;
  double height = 0;  // [px]
};

double legend_width(const Series& series) {
  return 46 + kGlyphWidth * static_cast<double>(series.name.size());
}

Legend make_legend(const Plot& plot, double top) {
  if (plot.series.size() < 2) return {};
  Legend legend{.svg = {}, .height = kLegendRow};
  double x = kLeft;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const double width = legend_width(plot.series[i]);
    if (x > kLeft && x + width > plot.width) {
      x = kLeft;
      legend.height += kLegendRow;
    }
    const double y = top + legend.height - kLegendRow;
    legend.svg += fmt::format(
        "<path d=\"M{:.1f} {:.1f}h22\" {} stroke-width=\"3\" stroke-linecap=\"round\"/>", x, y,
        stroke_of(plot, i));
    legend.svg += text(x + 28, y + 4, "start", plot.series[i].name);
    x += width;
  }
  return legend;
}

std::string lines_of(const Canvas& canvas, const Plot& plot) {
  std::string lines;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const std::string path = path_of(canvas, plot.series[i], plot.equal_axes);
    if (path.empty()) continue;
    lines += fmt::format(
        "<path d=\"{}\" class=\"series\" fill=\"none\" {} stroke-width=\"{}\" "
        "stroke-linejoin=\"round\" stroke-linecap=\"round\"><title>{}</title></path>\n",
        path, stroke_of(plot, i), plot.series[i].thickness, escape_markup(plot.series[i].name));
  }
  return lines;
}

// The highest pile is painted first, so that the lower ones stay in sight.
std::string areas_of(const Canvas& canvas, const Plot& plot) {
  std::string areas;
  const double bottom = to_pixel(canvas, 0, 0).y;
  for (std::size_t i = plot.series.size(); i-- > 0;) {
    const Series& series = plot.series[i];
    const std::string path = path_of(canvas, series, false);
    if (path.empty()) continue;
    areas += fmt::format(
        "<path d=\"{}V{:.1f}H{:.1f}Z\" class=\"series\" fill=\"{}\"><title>{}</title></path>\n",
        path, bottom, to_pixel(canvas, series.x.front(), 0).x, color_of(plot, i),
        escape_markup(series.name));
  }
  if (areas.empty()) return areas;
  // What is higher than the limits of y is cut. Plots of one page share a name only with the same
  // area.
  const std::string name =
      fmt::format("cut-{}-{}-{}-{}", canvas.left, canvas.top, canvas.width, canvas.height);
  return fmt::format(
      "<clipPath id=\"{0}\"><rect x=\"{1}\" y=\"{2}\" width=\"{3}\" height=\"{4}\"/></clipPath>\n"
      "<g clip-path=\"url(#{0})\">\n{5}</g>\n",
      name, canvas.left, canvas.top, canvas.width, canvas.height, areas);
}

// Under the lines: shaded spans; along the lower border: marks.
std::string decorations_of(const Canvas& canvas, const Plot& plot) {
  std::string svg, ticks;
  const double bottom = canvas.top + canvas.height;
  const auto pixel_of = [&](double x) {
    return to_pixel(canvas, std::clamp(x, canvas.x.low, canvas.x.high), 0).x;
  };
  for (const Limits& band : plot.bands) {
    const double left = pixel_of(band.low);
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\" fill=\"#d62728\" "
        "fill-opacity=\".22\"/>\n",
        left, canvas.top, std::max(1.0, pixel_of(band.high) - left), canvas.height);
  }
  double last = -1;
  for (const double mark : plot.marks) {
    const double x = pixel_of(mark);
    if (x - last < 0.5) continue;  // closer marks look like one
    ticks += fmt::format("M{:.1f} {:.1f}v-9", x, bottom);
    last = x;
  }
  if (!ticks.empty())
    svg += fmt::format("<path d=\"{}\" stroke=\"{}\" fill=\"none\"/>\n", ticks, kTextColor);
  return svg;
}

}  // namespace

std::string to_svg(const Plot& given) {
  Plot plot = given;
  if (plot.stacked) plot.series = piled_up(std::move(plot.series));
  const double title_height = plot.title.empty() ? 0 : kTitleHeight;
  const Legend legend = make_legend(plot, kTop + title_height);
  const Canvas canvas = make_canvas(plot, kTop + title_height + legend.height);
  const double height = canvas.top + canvas.height + kBottom;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" style=\"max-width:100%;height:auto\" role=\"img\" aria-label=\"{2}\" "
      "font-family=\"system-ui,sans-serif\" font-size=\"13\" fill=\"{3}\" "
      "data-area=\"{4} {5} {6} {7} {8:.9g} {9:.9g} {10:.9g} {11:.9g}\">\n",
      plot.width, height, escape_markup(plot.title.empty() ? plot.y_label : plot.title), kTextColor,
      canvas.left, canvas.top, canvas.width, canvas.height, canvas.x.low, canvas.x.high,
      canvas.y.low, canvas.y.high);
  if (!plot.title.empty())
    svg += fmt::format("<text x=\"{}\" y=\"22\" font-size=\"15\" font-weight=\"600\">{}</text>\n",
                       kLeft, escape_markup(plot.title));
  svg += legend.svg + axes_of(canvas, plot) + decorations_of(canvas, plot);
  const std::string curves = plot.stacked ? areas_of(canvas, plot) : lines_of(canvas, plot);
  svg += curves + event_marks(plot.events, {.left = canvas.left,
                                            .top = canvas.top,
                                            .width = canvas.width,
                                            .height = canvas.height,
                                            .x = canvas.x});
  if (curves.empty())
    svg += text(canvas.left + 0.5 * canvas.width, canvas.top + 0.5 * canvas.height, "middle",
                "no data");
  return svg + "</svg>\n";
}

}  // namespace edvo

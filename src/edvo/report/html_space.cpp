// SPDX-License-Identifier: MIT
#include "edvo/report/html_space.hpp"

#include "edvo/core/clean_text.hpp"
#include "edvo/report/markup.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace edvo {
namespace {

constexpr std::size_t kMostPoints = 1500;  // of a line
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// x right, y up, z ahead [m]; a NaN interrupts the line.
using Points = std::vector<Eigen::Vector3d>;

Points points_of(const SpaceLine& line, double up_sign) {
  const View top{"", "", "", 0, 2, 1};
  const View side{"", "", "", 2, 1, up_sign};
  const Timeline whole;
  const Timeline& timeline = line.interrupted_by != nullptr ? *line.interrupted_by : whole;
  const bool is_interrupted = line.interrupted_by != nullptr;
  const Series from_above = line_of(line.trajectory, top, timeline, is_interrupted);
  const Series from_side = line_of(line.trajectory, side, timeline, is_interrupted);
  const std::size_t step = from_above.x.size() / kMostPoints + 1;
  Points points;
  for (std::size_t i = 0; i < from_above.x.size(); ++i) {
    const bool is_gap = std::isnan(from_above.x[i]);
    if (is_gap || i % step == 0 || i + 1 == from_above.x.size())
      points.emplace_back(from_above.x[i], from_side.y[i], from_above.y[i]);
  }
  return points;
}

// As a string of JSON that ends no element of the page.
std::string json_text(const std::string& text) {
  std::string quoted = nlohmann::json(clean_text(text)).dump();
  for (std::size_t at = quoted.find('<'); at != std::string::npos; at = quoted.find('<', at))
    quoted.replace(at, 1, "\\u003c");
  return quoted;
}

std::string json_of(const SpaceLine& line, const Points& points) {
  std::string json;
  for (const Eigen::Vector3d& point : points) {
    if (!json.empty()) json += ',';
    json += point.hasNaN() ? std::string("null")
                           : fmt::format("[{:.3f},{:.3f},{:.3f}]", point.x(), point.y(), point.z());
  }
  return fmt::format("{{\"name\":{},\"color\":{},\"dots\":{},\"points\":[{}]}}",
                     json_text(line.name), json_text(line.color), line.is_dots, json);
}

// As the script shows it first.
Series seen_obliquely(const SpaceLine& line, const Points& points) {
  constexpr double kYaw = -0.6, kPitch = 0.5;  // [rad]
  Series series{.name = line.name, .x = {}, .y = {}, .color = line.color};
  if (line.is_dots) series.thickness = 4;
  for (const Eigen::Vector3d& p : points) {
    const double ahead = std::cos(kYaw) * p.z() - std::sin(kYaw) * p.x();
    series.x.push_back(std::cos(kYaw) * p.x() + std::sin(kYaw) * p.z());
    series.y.push_back(std::cos(kPitch) * p.y() + std::sin(kPitch) * ahead);
    if (!line.is_dots) continue;
    series.x.push_back(kNaN);
    series.y.push_back(kNaN);
  }
  return series;
}

}  // namespace

std::string space_card(const std::vector<SpaceLine>& lines, double up_sign,
                       const std::string& caption) {
  Plot plot{.x_label = "[m]", .y_label = "[m]", .equal_axes = true, .width = 1180, .height = 480};
  std::string json;
  for (const SpaceLine& line : lines) {
    const Points points = points_of(line, up_sign);
    if (points.empty()) continue;
    json += (json.empty() ? "" : ",") + json_of(line, points);
    plot.series.push_back(seen_obliquely(line, points));
  }
  if (json.empty()) return "";
  return fmt::format(
      "<section class=\"card wide\" id=\"space\" data-sign=\"{}\"><h2>In space</h2><p "
      "class=\"soft\">{}<span "
      "class=\"how\" hidden> Drag to turn, shift and drag to move, click and turn the wheel to "
      "zoom, double-click to reset.</span></p>\n{}<script type=\"application/json\">[{}]</script>"
      "</section>\n",
      up_sign, escape_markup(caption), to_svg(plot), json);
}

}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/report/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>

namespace edvo {
namespace {

using testing::HasSubstr;
using testing::Not;

Plot two_lines() {
  return {.title = "Error",
          .x_label = "time [s]",
          .y_label = "error [m]",
          .series = {{.name = "ours", .x = {0, 1, 2}, .y = {0, 2, 1}},
                     {.name = "theirs", .x = {0, 1, 2}, .y = {1, 1, 3}, .color = "#123456"}}};
}

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(Plot, NamesItsAxesAndItsLines) {
  const std::string svg = to_svg(two_lines());
  for (const char* part : {"<svg ", "</svg>", "Error", "time [s]", "error [m]", "ours", "theirs",
                           "#123456", "#0072b2"})
    EXPECT_THAT(svg, HasSubstr(part));
}

TEST(Plot, NeverWritesANumberThatIsNotOne) {
  Plot plot = two_lines();
  plot.series[0].y = {0, std::nan(""), std::numeric_limits<double>::infinity()};
  plot.series[1] = {.name = "empty", .x = {}, .y = {}};
  const std::string svg = to_svg(plot);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(Plot, InterruptsALineAtMissingValues) {
  Plot plot = two_lines();
  plot.series = {{.name = "a", .x = {0, 1, 2, 3, 4}, .y = {0, 1, std::nan(""), 3, 0}}};
  const std::string svg = to_svg(plot);
  const auto line = svg.substr(svg.find("stroke-width=\"1.6\"") - 120, 120);
  EXPECT_EQ(count(line, "M"), 2) << line;
}

TEST(Plot, SaysSoWhenThereIsNothingToDraw) {
  EXPECT_THAT(to_svg(Plot{.title = "t", .x_label = "x", .y_label = "y", .series = {}}),
              HasSubstr("no data"));
}

TEST(Plot, EscapesWhatWouldBeMarkup) {
  Plot plot = two_lines();
  plot.title = "a<b & \"c\"";
  EXPECT_THAT(to_svg(plot), HasSubstr("a&lt;b &amp; &quot;c&quot;"));
}

TEST(Plot, StaysSmallForLongSeries) {
  Plot plot = two_lines();
  plot.series.resize(1);
  plot.series[0].x.clear();
  plot.series[0].y.clear();
  for (int i = 0; i < 100000; ++i) {
    plot.series[0].x.push_back(i);
    plot.series[0].y.push_back(std::sin(i * 1e-3));
  }
  EXPECT_LT(to_svg(plot).size(), 60'000u);
}

TEST(Plot, GivesMapsOneScale) {
  Plot plot = two_lines();
  plot.equal_axes = true;
  plot.series = {{.name = "square", .x = {0, 1, 1, 0}, .y = {0, 0, 1, 1}}};
  const std::string svg = to_svg(plot);
  std::smatch match;
  const std::regex path(R"re(<path d="M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)L)re");
  ASSERT_TRUE(std::regex_search(svg, match, path));
  const double width = std::stod(match[3]) - std::stod(match[1]);
  const double height = std::stod(match[4]) - std::stod(match[6]);
  EXPECT_NEAR(width, height, 0.2);
}

// The points of the n-th line or area.
std::vector<std::pair<double, double>> points_of(const std::string& svg, int n) {
  std::size_t end = 0;
  for (int i = 0; i <= n; ++i) end = svg.find("\" class=\"series\"", end + 1);
  const std::size_t start = svg.rfind("d=\"", end) + 3;
  const std::string path = svg.substr(start, end - start);
  const std::regex point("[ML]([-0-9.]+) ([-0-9.]+)");
  std::vector<std::pair<double, double>> points;
  for (std::sregex_iterator i(path.begin(), path.end(), point), none; i != none; ++i)
    points.emplace_back(std::stod((*i)[1]), std::stod((*i)[2]));
  return points;
}

TEST(Plot, PilesAreasUpWithTheHighestBehind) {
  Plot plot{.series = {{.name = "low", .x = {0, 1}, .y = {1, 1}},
                       {.name = "high", .x = {0, 1}, .y = {2, std::nan("")}}},
            .stacked = true,
            .y_limits = Limits{0, 4}};
  const std::string svg = to_svg(plot);
  EXPECT_LT(svg.find("<title>high</title>"), svg.find("<title>low</title>"));
  const auto high = points_of(svg, 0), low = points_of(svg, 1);
  const double bottom = low[0].second + (low[0].second - high[0].second) / 2;
  EXPECT_NEAR(bottom - high[0].second, 3 * (bottom - low[0].second), 0.2);
  EXPECT_NEAR(high[1].second, low[1].second, 0.2);  // what is missing adds nothing
}

TEST(Plot, StaysSmallForLongNoise) {
  Plot plot = two_lines();
  plot.series.resize(1);
  plot.series[0].x.clear();
  plot.series[0].y.clear();
  for (int i = 0; i < 100000; ++i) {
    plot.series[0].x.push_back(i);
    plot.series[0].y.push_back(i * 7919 % 1000);
  }
  plot.series[0].y[54321] = 5000;
  const std::string svg = to_svg(plot);
  EXPECT_LT(svg.size(), 60'000u);
  const auto points = points_of(svg, 0);
  const auto highest = std::min_element(points.begin(), points.end(),
                                        [](auto a, auto b) { return a.second < b.second; });
  EXPECT_LT(highest->second, points[0].second - 150) << "a single peak must not be lost";
}

TEST(Plot, ShadesSpansAndTicksMarksInsideItsLimits) {
  Plot plot = two_lines();
  plot.x_limits = Limits{0, 2};
  plot.bands = {{.low = 1, .high = 9}};
  plot.marks = {0.5, 1.5};
  const std::string svg = to_svg(plot);
  EXPECT_EQ(count(svg, "fill-opacity=\".22\""), 1);
  EXPECT_EQ(count(svg, "v-9"), 2);
}

TEST(Plot, CutsPilesThatAreHigherThanItsLimits) {
  const Plot plot{.x_label = "time [s]",
                  .y_label = "time [ms]",
                  .series = {{.name = "a", .x = {0, 1, 2}, .y = {1, 100, 1}}},
                  .stacked = true,
                  .y_limits = Limits{0, 10}};
  const std::string svg = to_svg(plot);
  std::smatch cut;
  ASSERT_TRUE(std::regex_search(
      svg, cut,
      std::regex("data-area=\"(\\S+) (\\S+) (\\S+) (\\S+) [^>]*>[^]*<clipPath id=\"(\\S+)\">"
                 "<rect x=\"\\1\" y=\"\\2\" width=\"\\3\" height=\"\\4\"/>")));
  const std::size_t group = svg.find("clip-path=\"url(#" + cut[5].str() + ")\"");
  ASSERT_NE(group, svg.npos);
  EXPECT_LT(group, svg.find("class=\"series\""));
}

TEST(Plot, MarksEventsWhereTheyAreAndJoinsThoseTooCloseToBeToldApart) {
  Plot plot{
      .x_label = "time [s]", .y_label = "y", .series = {{.name = "a", .x = {0, 100}, .y = {0, 1}}}};
  plot.x_limits = Limits{0, 100};
  plot.events = {{.x = 50, .text = "one", .color = "#111111", .label = {}, .link = "#e1"},
                 {.x = 50.1, .text = "two", .color = "#111111", .label = {}, .link = "#e2"},
                 {.x = 50, .text = "worst", .color = "#222222", .label = "1", .link = "#w1"},
                 {.x = 200, .text = "outside", .color = "#111111", .label = {}, .link = {}}};
  const std::string svg = to_svg(plot);
  EXPECT_THAT(svg, HasSubstr("<title>one\ntwo</title>"));
  EXPECT_THAT(svg, HasSubstr("href=\"#e1\""));
  EXPECT_THAT(svg, HasSubstr("href=\"#w1\""));
  EXPECT_THAT(svg, Not(HasSubstr("#e2")));
  EXPECT_THAT(svg, Not(HasSubstr("outside")));
}

}  // namespace
}  // namespace edvo

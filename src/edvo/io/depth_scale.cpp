// SPDX-License-Identifier: MIT
#include "edvo/io/depth_scale.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>

namespace edvo {
namespace {

constexpr double kNearest = 0.1, kFarthest = 20;  // [m] median of a scene that such cameras see
constexpr double kTypical = 2;                    // [m] indoors
constexpr double kAlike = 0.15;                   // of a scale's logarithm
constexpr int kSaturated = 65535;
// So many of the pixels have the largest value, and so many times more than any other, only where
// it is a limit of the sensor.
constexpr double kClippedShare = 0.1, kClippedTimes = 2;

// Millimetres, TUM, tenths of a millimetre, KITTI, centimetres, Replica, metres. [units/m]
constexpr std::array kUsualScales = {1000.0, 5000.0, 10000.0, 256.0, 100.0, 6553.5, 1.0};

bool is_plausible(double median) {
  return median >= kNearest && median <= kFarthest;
}

// The usual scale that brings the median nearest to a typical one; none if none is plausible.
std::optional<double> likely_scale(double raw_median) {
  std::optional<double> likely;
  const auto oddness = [&](double scale) {
    return std::abs(std::log(raw_median / scale / kTypical));
  };
  for (const double scale : kUsualScales)
    if (is_plausible(raw_median / scale) && (!likely || oddness(scale) < oddness(*likely)))
      likely = scale;
  return likely;
}

// What there is between "none" and "saturated".
struct Spread {
  std::int64_t pixels = 0;  // with depth
  int different = 0;        // values
  int smallest = 0, largest = 0;
  std::int64_t most_frequent = 0;  // pixels of the most frequent value but the largest
};

Spread spread_of(const DepthValues& values) {
  Spread spread;
  for (int value = 1; value < kSaturated; ++value) {
    if (values.counts[value] == 0) continue;
    if (spread.different++ == 0)
      spread.smallest = value;
    else
      spread.most_frequent = std::max(spread.most_frequent, values.counts[spread.largest]);
    spread.largest = value;
    spread.pixels += values.counts[value];
  }
  return spread;
}

std::string warn_of_median(int raw_median, const DepthScale& scale) {
  const std::string seen = fmt::format(
      "median depth is {:.3g} m at {} units per metre ({}), outside {} to {} m",
      raw_median / scale.units_per_metre, scale.units_per_metre, scale.source, kNearest, kFarthest);
  const auto likely = likely_scale(raw_median);
  if (!likely) return seen + ", and no usual scale makes it plausible: are these depth images?";
  return fmt::format("{}; with {} units per metre it would be {:.3g} m: try --depth-scale {}", seen,
                     *likely, raw_median / *likely, *likely);
}

bool is_clipped(const DepthValues& values, const Spread& spread) {
  const auto clipped = static_cast<double>(values.counts[spread.largest]);
  return clipped > kClippedShare * static_cast<double>(spread.pixels) &&
         clipped > kClippedTimes * static_cast<double>(spread.most_frequent);
}

std::string warn_of_clipping(const DepthValues& values, const Spread& spread,
                             const DepthScale& scale) {
  const double metres = spread.largest / scale.units_per_metre;
  return fmt::format(
      "{:.0f} % of the depths are the largest value, {} ({:.3g} m): a limit of the sensor, not "
      "measured? If so, exclude it: --set selection.max_depth={:.3g}",
      100.0 * static_cast<double>(values.counts[spread.largest]) /
          static_cast<double>(spread.pixels),
      spread.largest, metres, 0.99 * metres);
}

std::string warn_of_whole_metres(const Spread& spread, const DepthScale& scale) {
  const std::string advice =
      scale.units_per_metre == 1 ? "" : "; to read them as they are, try --depth-scale 1";
  return fmt::format(
      "depth has only the values {} to {}: whole metres, whose fractions were lost when the images "
      "were written; write millimetres instead{}",
      spread.smallest, spread.largest, advice);
}

}  // namespace

double nearest_usual_scale(double units_per_metre) {
  for (const double usual : kUsualScales)
    if (std::abs(std::log(units_per_metre / usual)) < kAlike) return usual;
  return units_per_metre;
}

void add_image(DepthValues& values, const cv::Mat_<std::uint16_t>& raw) {
  for (int y = 0; y < raw.rows; ++y)
    for (int x = 0; x < raw.cols; ++x) ++values.counts[raw(y, x)];
  ++values.images;
}

std::optional<int> median_value(const DepthValues& values) {
  const std::int64_t half = spread_of(values).pixels / 2;
  std::int64_t below = 0;
  for (int value = 1; value < kSaturated; ++value) {
    below += values.counts[value];
    if (below > half) return value;
  }
  return std::nullopt;
}

DepthFindings check_depth(const DepthValues& values, const DepthScale& scale) {
  DepthFindings findings;
  const Spread spread = spread_of(values);
  const auto metres = [&](int value) { return value / scale.units_per_metre; };
  const std::int64_t saturated = values.counts[kSaturated];
  if (saturated > 0)
    findings.notes.push_back(fmt::format(
        "depth {} is read as none: {:.1f} % of the pixels that are not 0", kSaturated,
        100.0 * static_cast<double>(saturated) / static_cast<double>(saturated + spread.pixels)));
  if (spread.pixels == 0) {
    findings.warnings.push_back(
        fmt::format("no pixel has a depth in the {} depth images looked at: all are 0{}",
                    values.images, saturated > 0 ? " or 65535, which are read as none" : ""));
    return findings;
  }
  if (spread.largest <= kFarthest) {
    findings.warnings.push_back(warn_of_whole_metres(spread, scale));
  } else if (const int median = *median_value(values); !is_plausible(metres(median))) {
    findings.warnings.push_back(warn_of_median(median, scale));
  }
  if (spread.different == 1) {
    findings.warnings.push_back(fmt::format(
        "every pixel with a depth has the same, {} ({:.3g} m), as none that was measured",
        spread.largest, metres(spread.largest)));
  } else if (spread.largest > kFarthest && is_clipped(values, spread)) {
    findings.warnings.push_back(warn_of_clipping(values, spread, scale));
  }
  return findings;
}

}  // namespace edvo

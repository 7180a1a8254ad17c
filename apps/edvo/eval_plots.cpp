// SPDX-License-Identifier: MIT
#include "eval_plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace edvo::app {
namespace {

constexpr std::string_view kTruthColor = "#8c8c8c";

// A longer time without a pose is a gap: a line across it would be invented.
constexpr double kLongGap = 5;        // [median intervals]
constexpr double kShortestGap = 0.2;  // [s]

struct Sample {
  Stamp stamp;
  double x = 0, y = 0;
};

Series interrupted_at_gaps(const std::string& name, const std::vector<Sample>& samples) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < samples.size(); ++i)
    intervals.push_back(seconds_between(samples[i - 1].stamp, samples[i].stamp));
  const double longest = std::max(kLongGap * median(intervals), kShortestGap);
  Series series{.name = name, .x = {}, .y = {}};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0 && intervals[i - 1] > longest) {
      series.x.push_back(std::nan(""));
      series.y.push_back(std::nan(""));
    }
    series.x.push_back(samples[i].x);
    series.y.push_back(samples[i].y);
  }
  return series;
}

// All estimates share one clock, that of their first matched pose.
Stamp first_stamp(std::span<const NamedEvaluation> evaluations) {
  if (evaluations.empty()) return {};
  Stamp first = evaluations.front().evaluation.ate.errors.front().stamp;
  for (const NamedEvaluation& named : evaluations)
    first = std::min(first, named.evaluation.ate.errors.front().stamp);
  return first;
}

Plot rpe_plot(std::span<const NamedEvaluation> evaluations, const std::string& what,
              const std::string& unit, double RpeError::*error) {
  Plot plot{.title = fmt::format("{} error over time, RPE", what),
            .x_label = "time [s]",
            .y_label = {},
            .series = {}};
  const Stamp start = first_stamp(evaluations);
  for (const auto& [name, file, estimate, evaluation] : evaluations) {
    const Delta& delta = evaluation.options.rpe.delta;
    plot.y_label = fmt::format("{} error [{}{}]", what, unit, per_delta(delta));
    std::vector<Sample> samples;
    // Pairs of any two poses belong to no time.
    if (evaluation.rpe && delta.unit != DeltaUnit::kAllPairs)
      for (const RpeError& e : evaluation.rpe->errors)
        samples.push_back({e.from, seconds_between(start, e.from), e.*error});
    std::stable_sort(samples.begin(), samples.end(),
                     [](const Sample& a, const Sample& b) { return a.stamp < b.stamp; });
    plot.series.push_back(interrupted_at_gaps(name, samples));
  }
  return plot;
}

// The two axes to draw, horizontal first, leaving out the one of the smallest extent.
std::array<Eigen::Index, 2> widest_axes(const Trajectory& truth) {
  Eigen::AlignedBox3d box;
  for (const StampedPose& pose : truth) box.extend(pose.world_from_camera.translation);
  Eigen::Index narrowest = 2;
  box.sizes().minCoeff(&narrowest);
  if (narrowest == 0) return {1, 2};
  if (narrowest == 1) return {0, 2};
  return {0, 1};
}

Series path_along(const std::array<Eigen::Index, 2>& axes, const Trajectory& trajectory,
                  const std::string& name) {
  std::vector<Sample> samples;
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d& position = pose.world_from_camera.translation;
    samples.push_back({pose.stamp, position[axes[0]], position[axes[1]]});
  }
  return interrupted_at_gaps(name, samples);
}

// Ground truth is often recorded before and after the images: that part belongs to no estimate.
Trajectory part_in_use(const Trajectory& truth, std::span<const NamedEvaluation> evaluations) {
  std::size_t first = truth.size(), last = 0;
  for (const NamedEvaluation& named : evaluations) {
    first = std::min(first, named.evaluation.matches.front().truth);
    last = std::max(last, named.evaluation.matches.back().truth);
  }
  if (first > last) return {};
  return {truth.begin() + static_cast<std::ptrdiff_t>(first),
          truth.begin() + static_cast<std::ptrdiff_t>(last) + 1};
}

}  // namespace

Plot trajectory_plot(const Trajectory& truth, std::span<const NamedEvaluation> evaluations) {
  constexpr std::string_view kAxes = "xyz";
  const Trajectory shown = part_in_use(truth, evaluations);
  const std::array<Eigen::Index, 2> axes = widest_axes(shown);
  const auto name_of_axis = [&](Eigen::Index axis) {
    return kAxes[static_cast<std::size_t>(axis)];
  };
  Plot plot{.title = fmt::format("Trajectories seen along {}", name_of_axis(3 - axes[0] - axes[1])),
            .x_label = fmt::format("{} [m]", name_of_axis(axes[0])),
            .y_label = fmt::format("{} [m]", name_of_axis(axes[1])),
            .series = {path_along(axes, shown, "ground truth")},
            .equal_axes = true};
  plot.series.front().color = kTruthColor;
  for (const auto& [name, file, estimate, evaluation] : evaluations)
    plot.series.push_back(
        path_along(axes, transformed(evaluation.ate.truth_from_estimate, estimate), name));
  return plot;
}

Plot ate_plot(std::span<const NamedEvaluation> evaluations) {
  Plot plot{.title = "Position error over time, ATE",
            .x_label = "time [s]",
            .y_label = "position error [m]",
            .series = {}};
  const Stamp start = first_stamp(evaluations);
  for (const auto& [name, file, estimate, evaluation] : evaluations) {
    std::vector<Sample> samples;
    for (const auto& [stamp, distance] : evaluation.ate.errors)
      samples.push_back({stamp, seconds_between(start, stamp), distance});
    plot.series.push_back(interrupted_at_gaps(name, samples));
  }
  return plot;
}

Plot rpe_translation_plot(std::span<const NamedEvaluation> evaluations) {
  return rpe_plot(evaluations, "Translation", "m", &RpeError::translation);
}

Plot rpe_rotation_plot(std::span<const NamedEvaluation> evaluations) {
  return rpe_plot(evaluations, "Rotation", "deg", &RpeError::rotation);
}

}  // namespace edvo::app

// SPDX-License-Identifier: MIT
// Time per frame against the number of selected pixels and against the size of the image, on the
// same rendered motion: two tables, and a plot of each in a folder.
//
// growth FOLDER
#include "edvo/eval/statistics.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/report/plot.hpp"
#include "edvo/synth/sequence.hpp"
#include "measure.hpp"
#include "memory.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

namespace {

using namespace edvo;
using benchmarks::cpu_seconds;

constexpr int kFrames = 150;  // enough for a full window of keyframes

// Of the default camera's field of view.
synth::SyntheticSequence sequence_of_size(int width, int height) {
  const double scale = width / 640.0;
  return synth::make_sequence({}, {{.fx = 525 * scale,
                                    .fy = 525 * scale,
                                    .cx = 0.5 * (width - 1),
                                    .cy = 0.5 * (height - 1),
                                    .width = width,
                                    .height = height},
                                   {}});
}

// CPU time [ms]
struct Cost {
  double points = 0;      // of keyframes, mean
  double prepare = 0;     // grey, undistorted, pyramid; median
  double between = 0;     // tracking a frame between keyframes; median
  double keyframe = 0;    // tracking a frame that becomes a keyframe, and making it one; median
  double refinement = 0;  // tracking the frame after it, and refining the window; median
  double mean = 0;        // of all frames, all included
};

// Rendering not counted.
Cost cost_of(const synth::SyntheticSequence& sequence, const Config& config) {
  Odometry odometry(sequence.camera, config);
  std::vector<double> prepare, between, keyframe, refinement;
  double all = 0, points = 0;
  bool after_keyframe = false;
  for (int i = 0; i < kFrames; ++i) {
    const RgbdImage image = synth::make_frame(sequence, i);
    const double begin = cpu_seconds();
    const PreparedImage prepared = odometry.prepare(image);
    const double middle = cpu_seconds();
    const FrameResult report = odometry.process(prepared);
    const double end = cpu_seconds();
    all += 1e3 * (end - begin);
    points += report.points;
    prepare.push_back(1e3 * (middle - begin));
    (report.keyframe_reason ? keyframe
     : after_keyframe       ? refinement
                            : between)
        .push_back(1e3 * (end - middle));
    after_keyframe = report.keyframe_reason.has_value();
  }
  return {.points = points / (kFrames - 1),  // the first has none to be aligned to
          .prepare = median(prepare),
          .between = median(between),
          .keyframe = median(keyframe),
          .refinement = median(refinement),
          .mean = all / kFrames};
}

void print_head(const char* what) {
  fmt::print("| {} | points | prepare | between keyframes | keyframe | frame after it | mean |\n",
             what);
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
}

void print_row(const std::string& name, const Cost& cost) {
  fmt::print("| {} | {:.0f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.2f} |\n", name, cost.points,
             cost.prepare, cost.between, cost.keyframe, cost.refinement, cost.mean);
}

void write_plot(const std::filesystem::path& file, const std::string& x_label,
                const std::vector<double>& x, const std::vector<Cost>& costs) {
  Plot plot{
      .title = "CPU time per frame", .x_label = x_label, .y_label = "time [ms]", .series = {}};
  const auto add = [&](const char* name, double Cost::*value) {
    Series series{.name = name, .x = x, .y = {}};
    for (const Cost& cost : costs) series.y.push_back(cost.*value);
    plot.series.push_back(series);
  };
  add("prepare", &Cost::prepare);
  add("between keyframes", &Cost::between);
  add("keyframe", &Cost::keyframe);
  add("frame after a keyframe", &Cost::refinement);
  add("mean of all", &Cost::mean);
  std::ofstream(file) << to_svg(plot);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "growth FOLDER\n");
    return 2;
  }
  app::keep_freed_memory();
  cv::setNumThreads(1);
  const std::filesystem::path folder = argv[1];

  const synth::SyntheticSequence sequence = sequence_of_size(640, 480);
  std::vector<double> points;
  std::vector<Cost> costs;
  print_head("selection.max_points, 640 x 480");
  for (const int limit : {500, 1000, 2000, 4000, 8000, 12000, 20000}) {
    Config config = preset(Method::kCannyCorner);
    config.selection.max_points = limit;
    costs.push_back(cost_of(sequence, config));
    points.push_back(costs.back().points);
    print_row(std::to_string(limit), costs.back());
  }
  write_plot(folder / "time_by_points.svg", "points of a keyframe", points, costs);

  std::vector<double> megapixels;
  costs.clear();
  fmt::print("\n");
  print_head("size, selection.max_points = 4000");
  for (const int width : {160, 320, 640, 960, 1280}) {
    const int height = width * 3 / 4;
    costs.push_back(cost_of(sequence_of_size(width, height), preset(Method::kCannyCorner)));
    megapixels.push_back(1e-6 * width * height);
    print_row(fmt::format("{} x {}", width, height), costs.back());
  }
  write_plot(folder / "time_by_size.svg", "size of the image [megapixels]", megapixels, costs);
  return 0;
}

// SPDX-License-Identifier: MIT
// Each stage of a frame by itself, on rendered frames, so that no data is needed.
#include "edvo/edge/canny.hpp"
#include "edvo/edge/corners.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/synth/sequence.hpp"
#include "edvo/track/tracker.hpp"

#include <benchmark/benchmark.h>

namespace {

using namespace edvo;

constexpr int kSecondFrame = 3;  // a tenth of a second after the keyframe

cv::Mat_<float> strength_of(const cv::Mat_<std::uint8_t>& edges) {
  cv::Mat_<float> strength;
  edges.convertTo(strength, CV_32F, 1.0 / 255);
  return strength;
}

// Two frames of the demo's room, and what the stages before each benchmark make of them.
struct World {
  Config config = preset(Method::kCannyCorner);
  synth::SyntheticSequence sequence = synth::make_sequence({});
  RgbdImage first_image = synth::make_frame(sequence, 0);
  RgbdImage second_image = synth::make_frame(sequence, kSecondFrame);
  Undistortion undistortion = make_undistortion(sequence.camera);
  Frame first = make_frame(first_image, undistortion, config.frame);
  Frame second = make_frame(second_image, undistortion, config.frame);
  cv::Mat_<std::uint8_t> edges = canny_edges(first.levels[0].gray, config.canny);
  cv::Mat_<float> strength = strength_of(edges);
  std::vector<SelectedPixel> pixels =
      select_pixels(first, edges, undistortion.valid, config.selection);
  Reference reference = make_reference(first, pixels, config.tracking.softness);
};

const World& world() {
  static const World instance;
  return instance;
}

void make_frame_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(make_frame(w.second_image, w.undistortion, w.config.frame));
}
BENCHMARK(make_frame_stage)->Name("frame")->Unit(benchmark::kMillisecond);

void canny_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(canny_edges(w.first.levels[0].gray, w.config.canny));
}
BENCHMARK(canny_stage)->Name("edges: canny")->Unit(benchmark::kMillisecond);

void corners_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state) {
    const auto corners = optimize_corners(w.strength, w.config.corners);
    benchmark::DoNotOptimize(draw_discs(w.strength.size(), corners, w.config.corners.disc_radius));
  }
}
BENCHMARK(corners_stage)->Name("corners")->Unit(benchmark::kMillisecond);

void selection_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        select_pixels(w.first, w.edges, w.undistortion.valid, w.config.selection));
}
BENCHMARK(selection_stage)->Name("selection")->Unit(benchmark::kMillisecond);

void reference_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(make_reference(w.first, w.pixels, w.config.tracking.softness));
}
BENCHMARK(reference_stage)->Name("reference")->Unit(benchmark::kMillisecond);

void tracking_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(track(w.reference, w.second, Alignment{}, w.config.tracking));
}
BENCHMARK(tracking_stage)->Name("tracking")->Unit(benchmark::kMillisecond);

}  // namespace

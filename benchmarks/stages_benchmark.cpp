// SPDX-License-Identifier: MIT
// Each stage of a frame by itself, on rendered frames, so that no data is needed.
#include "edvo/odometry/local_map.hpp"
#include "edvo/synth/sequence.hpp"
#include "edvo/track/tracker.hpp"

#include <benchmark/benchmark.h>

namespace {

using namespace edvo;

constexpr int kSecondFrame = 3;  // a tenth of a second after the keyframe

// Two frames of the demo's room, and what the stages before each benchmark make of them.
struct World {
  Config config = preset(Method::kCannyCorner);
  synth::SyntheticSequence sequence = synth::make_sequence({});
  RgbdImage first_image = synth::make_frame(sequence, 0);
  RgbdImage second_image = synth::make_frame(sequence, kSecondFrame);
  Undistortion undistortion = make_undistortion(sequence.camera);
  Frame first = make_frame(first_image, undistortion, config.frame);
  Frame second = make_frame(second_image, undistortion, config.frame);
  cv::Mat_<std::uint8_t> edges = edge_mask(first, undistortion, nullptr, config);
  cv::Mat_<std::uint8_t> mask = with_corner_discs(edges, config.corners);
  std::vector<SelectedPixel> pixels =
      select_pixels(first, mask, undistortion.valid, config.selection);
  Reference reference = reference_with_surface();

  [[nodiscard]] Reference reference_with_surface() const {
    Reference made = make_reference(first, pixels, {.softness = config.tracking.softness});
    made.surface = make_surface(first.depth, undistortion.camera, config.tracking.surface_cell,
                                config.tracking.depth_noise);
    return made;
  }
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

void edges_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(edge_mask(w.first, w.undistortion, nullptr, w.config));
}
BENCHMARK(edges_stage)->Name("edges: canny")->Unit(benchmark::kMillisecond);

void corners_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state) benchmark::DoNotOptimize(with_corner_discs(w.edges, w.config.corners));
}
BENCHMARK(corners_stage)->Name("corners")->Unit(benchmark::kMillisecond);

void selection_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        select_pixels(w.first, w.mask, w.undistortion.valid, w.config.selection));
}
BENCHMARK(selection_stage)->Name("selection")->Unit(benchmark::kMillisecond);

void reference_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state) benchmark::DoNotOptimize(w.reference_with_surface());
}
BENCHMARK(reference_stage)->Name("reference and surface")->Unit(benchmark::kMillisecond);

void tracking_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(track(w.reference, w.second, Alignment{}, w.config.tracking));
}
BENCHMARK(tracking_stage)->Name("tracking")->Unit(benchmark::kMillisecond);

// The second keyframe, refined against the first: a full window takes several times as long.
void map_stage(benchmark::State& state) {
  const World& w = world();
  const std::vector<SelectedPixel> pixels = select_pixels(
      w.second,
      with_corner_discs(edge_mask(w.second, w.undistortion, nullptr, w.config), w.config.corners),
      w.undistortion.valid, w.config.selection);
  const SE3 first_from_second = inverse(synth::pose_of(w.sequence, 0).world_from_camera) *
                                synth::pose_of(w.sequence, kSecondFrame).world_from_camera;
  LocalMap one;
  one.add(w.first, SE3{}, Alignment{}, w.pixels, w.config);
  for (auto _ : state) {
    state.PauseTiming();
    LocalMap map = one;
    state.ResumeTiming();
    map.add(w.second, first_from_second, Alignment{}, pixels, w.config);
    map.refine(w.sequence.camera.pinhole, w.config.window);
    benchmark::DoNotOptimize(map);
  }
}
BENCHMARK(map_stage)->Name("map: second keyframe")->Unit(benchmark::kMillisecond);

}  // namespace

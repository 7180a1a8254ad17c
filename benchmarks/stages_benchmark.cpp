// SPDX-License-Identifier: MIT
// Each stage of a frame by itself, on rendered frames, so that no data is needed.
#include "world.hpp"

#include <benchmark/benchmark.h>

namespace {

using namespace edvo;
using benchmarks::kSecondFrame;
using benchmarks::World;

const World& world() {
  static const World instance;
  return instance;
}

void make_frame_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state) benchmark::DoNotOptimize(make_frame(w.second_image, w.undistortion));
}
BENCHMARK(make_frame_stage)->Name("frame")->Unit(benchmark::kMillisecond);

void edges_stage(benchmark::State& state) {
  const World& w = world();
  for (auto _ : state)
    benchmark::DoNotOptimize(canny_edges(w.first.levels.front().gray, w.config.canny));
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
    benchmark::DoNotOptimize(align(w.reference, w.second, Alignment{}, w.config.tracking));
}
BENCHMARK(tracking_stage)->Name("tracking")->Unit(benchmark::kMillisecond);

// The second keyframe, refined against the first: a full window takes several times as long.
void map_stage(benchmark::State& state) {
  const World& w = world();
  const std::vector<SelectedPixel> pixels =
      select_pixels(w.second,
                    with_corner_discs(canny_edges(w.second.levels.front().gray, w.config.canny),
                                      w.config.corners),
                    w.undistortion.valid, w.config.selection);
  const SE3 first_from_second = inverse(synth::pose_of(w.sequence, 0).world_from_camera) *
                                synth::pose_of(w.sequence, kSecondFrame).world_from_camera;
  KeyframeWindow one;
  one.add(w.first, SE3{}, Alignment{}, w.pixels, w.config);
  for (auto _ : state) {
    state.PauseTiming();
    KeyframeWindow map = one;
    state.ResumeTiming();
    map.add(w.second, first_from_second, Alignment{}, pixels, w.config);
    map.refine(w.sequence.camera.pinhole, w.config.window);
    benchmark::DoNotOptimize(map);
  }
}
BENCHMARK(map_stage)->Name("map: second keyframe")->Unit(benchmark::kMillisecond);

}  // namespace

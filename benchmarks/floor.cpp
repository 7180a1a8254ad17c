// SPDX-License-Identifier: MIT
// How far each stage is from what it must cost at least: the bytes it has to move and the
// operations it has to do, at the rates of one core of this machine. docs/performance.md says how
// it is counted.
//
// floor [COLOUR.png DEPTH.png]: decodes these (rendered ones otherwise); all else is rendered.
#include "edvo/align/image_shift.hpp"
#include "edvo/eval/statistics.hpp"
#include "edvo/features/canny.hpp"
#include "edvo/io/image_file.hpp"
#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"
#include "measure.hpp"
#include "memory.hpp"
#include "world.hpp"

#include <fmt/core.h>
#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace {

using namespace edvo;
using benchmarks::cpu_seconds;
using benchmarks::keep;
using benchmarks::World;
using simd::Float8;
namespace fs = std::filesystem;

// Median CPU time of a call [s].
template <typename Call>
double seconds_of(Call&& call) {
  constexpr double kBatch = 2e-3, kEnough = 0.5;  // [s] a clock's tick is far shorter than a batch
  constexpr std::size_t kFewest = 9;
  call();
  int calls = 0;
  const double first = cpu_seconds();
  do {
    call();
    ++calls;
  } while (cpu_seconds() - first < kBatch);
  std::vector<double> times;
  for (double sum = 0; sum < kEnough || times.size() < kFewest;) {
    const double begin = cpu_seconds();
    for (int i = 0; i < calls; ++i) call();
    const double spent = cpu_seconds() - begin;
    times.push_back(spent / calls);
    sum += spent;
  }
  return median(times);
}

// Multiplications and additions of floats, as many at a time as the machine can.
constexpr int kSums = 12, kRounds = 4096;
EDVO_CLONES void multiply_and_add(float* numbers, float factor, float term) {
  Float8 sums[kSums];
  for (int s = 0; s < kSums; ++s) sums[s] = simd::Load(numbers + s * simd::kWidth).value;
  for (int round = 0; round < kRounds; ++round)
#pragma GCC unroll 12
    for (int s = 0; s < kSums; ++s) sums[s] = sums[s] * factor + term;
  for (int s = 0; s < kSums; ++s) simd::store(numbers + s * simd::kWidth, sums[s]);
}

struct Rates {
  double bytes = 0;       // read and written [1 / s]
  double operations = 0;  // [1 / s]
};

// Buffers as large as all that a frame reads and writes: in a cache, but not in the nearest.
Rates measure_rates() {
  constexpr std::size_t kSize = 4 << 20;  // [bytes]
  std::vector<char> from(kSize, 1), to(kSize);
  const double copy = seconds_of([&] {
    std::memcpy(to.data(), from.data(), kSize);
    keep(*to.data());
  });
  std::vector<float> numbers(kSums * simd::kWidth, 1.F);
  const double sums = seconds_of([&] {
    multiply_and_add(numbers.data(), 0.999F, 0.001F);
    keep(numbers[0]);
  });
  return {.bytes = 2.0 * kSize / copy, .operations = 2.0 * simd::kWidth * kSums * kRounds / sums};
}

struct Need {
  double bytes = 0, operations = 0;
  double before = 0;  // what is done by others, at their speed [s]
};

void print_row(const char* name, const Need& need, double measured, const Rates& rates) {
  const double floor =
      need.before + std::max(need.bytes / rates.bytes, need.operations / rates.operations);
  fmt::print("| {} | {:.2f} | {:.2f} | {:.3f} | {:.3f} | {:.1f} |\n", name, need.bytes * 1e-6,
             need.operations * 1e-6, 1e3 * floor, 1e3 * measured, measured / floor);
}

std::string read_bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// To inflate a PNG's pixels alone [s]. Without checks: the file has just been decoded.
double inflate_seconds(const fs::path& png, std::size_t out_size) {
  const std::string file = read_bytes(png);
  std::string packed;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    std::size_t size = 0;
    for (std::size_t k = 0; k < 4; ++k) size = size << 8 | static_cast<unsigned char>(file[at + k]);
    if (file.compare(at + 4, 4, "IDAT") == 0) packed += file.substr(at + 8, size);
    at += 12 + size;
  }
  std::vector<char> out(out_size);
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  return seconds_of([&] {
    libdeflate_zlib_decompress(inflater.get(), packed.data(), packed.size(), out.data(), out_size,
                               nullptr);
  });
}

// Operations, counted by hand: a multiplication, addition, division, root or comparison is one.
// Per pixel of the image.
constexpr double kPyramidOperations = 9;     // 5 + 4 per kernel: rows at half, columns at a quarter
constexpr double kUndistortOperations = 11;  // grey from colour 5, between four pixels 6
constexpr double kCannyOperations = 26 + 14 + 4 + 8;  // 7 x 7 blur by rows and columns, two Sobel
                                                      // images, their sum's histogram, thinning
// Two differences, three products of them blurred by 13 x 13 in rows and columns, one root.
constexpr double kCornerOperations = 10 + 3 + 3 * 2 * 19 + 8;
constexpr double kCandidateOperations = 8 + 2 * 25;  // gradient, nearest and farthest of 5 x 5
// Per point and level.
constexpr double kReferenceOperations = 6 + 5 * 8 + 20;  // back-projected, five samples, Jacobian
// Per point and linearization: moved 18, projected 7, sampled 8, loss 10, Jacobian times gain 6,
// products (8 + 36 * 2), gradient 8 * 2.
constexpr double kPhotometricOperations = 18 + 7 + 8 + 10 + 6 + 80 + 16;
// Moved 18, projected 7, sensor's point and its residual 20, loss 10, Jacobian 10, products
// 6 + 21 * 2, gradient 12.
constexpr double kSurfaceOperations = 18 + 7 + 20 + 10 + 10 + 48 + 12;
constexpr double kPointBytes = 11 * sizeof(float) + 4;  // of a reference point, and four pixels
constexpr double kSurfaceBytes = 6 * sizeof(float) + sizeof(float);
// Per pixel of a patch in another keyframe: moved 18, projected 7, sampled with derivatives 14,
// loss 10, Jacobian 20, products of eight unknowns and the inverse depth 9 + 45 * 2, gradient 18.
constexpr double kPatchOperations = 18 + 7 + 14 + 10 + 20 + 99 + 18;

Need alignment_need(const Reference& reference, const AlignResult& result) {
  Need need;
  const auto surface = static_cast<double>(reference.surface.x.size());
  for (const LevelStats& level : result.levels) {
    need.bytes += level.iterations * (level.points * kPointBytes + surface * kSurfaceBytes);
    need.operations +=
        level.iterations * (level.points * kPhotometricOperations + surface * kSurfaceOperations);
  }
  return need;
}

// Points of the newest keyframe in all others and theirs in it, in every iteration, and the
// elimination of all inverse depths.
Need window_need(const WindowOptions& options) {
  const double keyframes = options.keyframes + options.fixed_keyframes, points = options.points;
  const double unknowns = 8.0 * options.keyframes;
  const double pairs = 2 * (keyframes - 1);
  return {.bytes = options.iterations * pairs * points * (sizeof(WindowPoint) + 4 * kPatchSize),
          .operations = options.iterations * (pairs * points * kPatchSize * kPatchOperations +
                                              keyframes * points * unknowns * (unknowns + 1))};
}

KeyframeWindow full_map(const World& w, int step) {
  KeyframeWindow map;
  const int count = w.config.window.keyframes + w.config.window.fixed_keyframes;
  for (int k = 0; k + 1 < count; ++k) {
    const int i = k * step;
    const Frame frame = make_frame(synth::make_frame(w.sequence, i), w.undistortion);
    map.add(frame, synth::pose_of(w.sequence, i).world_from_camera, {},
            select_pixels(frame, w.mask_of(frame), w.undistortion.valid, w.config.selection),
            w.config);
    map.refine(w.undistortion.camera, w.config.window);
  }
  return map;
}

void print_decoding(int argc, char** argv, const World& w, const Rates& rates) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("edvo_floor_{}", std::clock());
  fs::path colour = argc > 2 ? argv[1] : folder / "colour.png";
  fs::path depth = argc > 2 ? argv[2] : folder / "depth.png";
  if (argc <= 2) {
    fs::create_directories(folder);
    write_png(colour, w.first_image.bgr);
    cv::Mat raw;
    w.first_image.depth.convertTo(raw, CV_16U, 5000);
    write_png(depth, raw);
  }
  const cv::Mat bgr = read_colour(colour);
  const auto pixels = static_cast<double>(bgr.total());
  const auto rows = static_cast<std::size_t>(bgr.rows);
  print_row("read and decode colour",
            {.bytes = 6 * pixels, .before = inflate_seconds(colour, 3 * bgr.total() + rows)},
            seconds_of([&] { keep(read_colour(colour)); }), rates);
  print_row("read and decode depth, to metres",
            {.bytes = (2 + 4) * pixels, .before = inflate_seconds(depth, 2 * bgr.total() + rows)},
            seconds_of([&] { keep(depth_to_metres(read_depth_raw(depth), 5000)); }), rates);
  fs::remove_all(folder);
}

void print_images(const World& w, const Rates& rates) {
  const auto pixels = static_cast<double>(w.first.depth.size().area());
  const Undistortion distorted = make_undistortion(
      {w.undistortion.camera, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}});  // as TUM's freiburg1
  print_row("grey and undistorted",
            {.bytes = (3 + 1 + 1 + 6 + 1) * pixels, .operations = kUndistortOperations * pixels},
            seconds_of([&] { keep(make_frame(w.second_image, distorted, 1)); }), rates);
  print_row("pyramid, 6 levels",
            {.bytes = 5.0 / 3 * pixels, .operations = 4.0 / 3 * kPyramidOperations * pixels},
            seconds_of([&] {
              cv::Mat level = w.first.levels.front().gray, half;
              for (int l = 1; l < kUsualLevels; ++l) {
                cv::pyrDown(level, half);
                level = half.clone();
              }
            }),
            rates);
}

void print_tracking(const World& w, const Rates& rates) {
  PhaseCorrelation correlation;
  correlation.set_reference(w.second.levels[4].gray);
  const cv::Mat_<std::uint8_t>& small = w.first.levels[4].gray;
  const auto count = static_cast<double>(small.total());
  // Two real transforms, 2.5 n log2 n each; window 1, product 3, its magnitude and division 4 each.
  print_row("turn between two images, 40 x 30",
            {.bytes = 6 * sizeof(float) * count,
             .operations = count * (2 * 2.5 * std::log2(count) + 1 + 3 + 4)},
            seconds_of([&] { keep(correlation.shift_to(small)); }), rates);

  AlignScratch scratch;
  AlignOptions options = w.config.tracking;
  constexpr int kStep = 16;  // [px] as MotionPredictor has it, and these levels
  options.finest_level = 3;
  options.coarsest_level = 5;
  Reference coarse = make_reference(w.first, grid_pixels(w.first, kStep, w.config.selection),
                                    {.finest_level = options.finest_level});
  coarse.surface =
      make_surface(w.first.depth, w.undistortion.camera, 2 * kStep, options.depth_noise);
  print_row("coarse alignment",
            alignment_need(coarse, align(coarse, w.second, {}, options, scratch)),
            seconds_of([&] { keep(align(coarse, w.second, {}, options, scratch)); }), rates);
  print_row(
      "alignment",
      alignment_need(w.reference, align(w.reference, w.second, {}, w.config.tracking, scratch)),
      seconds_of([&] { keep(align(w.reference, w.second, {}, w.config.tracking, scratch)); }),
      rates);
}

void print_keyframe(const World& w, const Rates& rates) {
  const auto pixels = static_cast<double>(w.first.depth.size().area());
  print_row("canny", {.bytes = 2 * pixels, .operations = kCannyOperations * pixels},
            seconds_of([&] { keep(canny_edges(w.first.levels.front().gray, w.config.canny)); }),
            rates);
  print_row("corners and discs", {.bytes = 2 * pixels, .operations = kCornerOperations * pixels},
            seconds_of([&] { keep(with_corner_discs(w.edges, w.config.corners)); }), rates);
  const double candidates = cv::countNonZero(w.mask);
  print_row(
      "selection",
      {.bytes = (1 + 1 + 1 + 4) * pixels, .operations = pixels + candidates * kCandidateOperations},
      seconds_of(
          [&] { keep(select_pixels(w.first, w.mask, w.undistortion.valid, w.config.selection)); }),
      rates);
  double points = 0;
  for (const ReferenceLevel& level : w.reference.levels) points += static_cast<double>(level.count);
  print_row("reference and surface",
            {.bytes = points * kPointBytes, .operations = points * kReferenceOperations},
            seconds_of([&] { keep(w.reference_with_surface()); }), rates);

  constexpr int kStep = 5;  // frames between keyframes
  const KeyframeWindow map = full_map(w, kStep);
  const int last = kStep * (w.config.window.keyframes + w.config.window.fixed_keyframes - 1);
  const Frame frame = make_frame(synth::make_frame(w.sequence, last), w.undistortion);
  const SE3 pose = synth::pose_of(w.sequence, last).world_from_camera;
  const std::vector<SelectedPixel> selected =
      select_pixels(frame, w.mask_of(frame), w.undistortion.valid, w.config.selection);
  const double copy = seconds_of([&] { keep(KeyframeWindow(map)); });
  const double all = seconds_of([&] {
    KeyframeWindow one_more = map;
    one_more.add(frame, pose, {}, selected, w.config);
    one_more.refine(w.undistortion.camera, w.config.window);
  });
  print_row("window of 12 keyframes", window_need(w.config.window), all - copy, rates);
}

}  // namespace

int main(int argc, char** argv) {
  app::keep_freed_memory();
  cv::setNumThreads(1);
  const Rates rates = measure_rates();
  const World w;
  fmt::print("one core: copies {:.1f} GB/s, {:.1f} Gop/s\n\n", rates.bytes * 1e-9,
             rates.operations * 1e-9);
  fmt::print("| stage | MB | Mop | floor [ms] | measured [ms] | times |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- |\n");
  print_decoding(argc, argv, w, rates);
  print_images(w, rates);
  print_tracking(w, rates);
  print_keyframe(w, rates);
  return 0;
}

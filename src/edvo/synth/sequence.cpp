// SPDX-License-Identifier: MIT
#include "edvo/synth/sequence.hpp"

#include "edvo/core/error.hpp"
#include "edvo/synth/parallel.hpp"
#include "edvo/synth/random.hpp"
#include "edvo/synth/rays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

namespace edvo::synth {
namespace {

constexpr std::int64_t kFirstSecond = 1'300'000'000;  // stamps look like recorded ones [s]
constexpr int kPosesPerFrame = 4;

Stamp stamp_at(double seconds) {
  const Stamp since_start = stamp_from_seconds(seconds);
  return {.nanoseconds = kFirstSecond * 1'000'000'000 + since_start.nanoseconds,
          .decimals = since_start.decimals};
}

double time_of(const SequenceOptions& options, int number) {
  return number / options.rate;
}

void check(const Camera& camera) {
  const bool finite = std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
                      std::isfinite(camera.cx) && std::isfinite(camera.cy);
  if (!finite || camera.fx <= 0 || camera.fy == 0 || camera.width < 2 || camera.height < 2)
    throw Error(
        ErrorCode::kCalibration,
        fmt::format("synthetic camera: needs fx > 0, fy not 0 and at least 2x2 pixels, got "
                    "fx {}, fy {}, cx {}, cy {}, {}x{}",
                    camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height));
}

// Refuses the first number that is out of its range; NaN is out of every range.
struct RangeCheck {
  template <typename Field>
  void operator()(const char* name, const Field& field, const Range& range, const char*) const {
    if constexpr (std::is_same_v<Field, int> || std::is_same_v<Field, double>) {
      if (!(field >= range.lowest && field <= range.highest))
        throw Error(ErrorCode::kConfig,
                    fmt::format("synthetic sequence: {} = {} is out of range, allowed: {} to {}",
                                name, field, range.lowest, range.highest));
    }
  }
};

// Of rounds: far enough for all frames, where no length is asked for [m].
double walk_length(const SequenceOptions& options) {
  constexpr double kFastest = 1;  // [m/s]
  return options.path_length > 0 ? options.path_length
                                 : kFastest * time_of(options, options.frames);
}

// The frames that arrive. The first always does: it defines the start.
std::vector<int> kept_frames(const SequenceOptions& options) {
  Random random{static_cast<std::uint64_t>(options.seed), 3};
  std::vector<int> kept;
  for (int number = 0; number < options.frames; ++number) {
    const bool dropped = random.uniform() < options.dropped_share;
    if (!dropped || number == 0) kept.push_back(number);
  }
  return kept;
}

Render render_at_once(const SyntheticSequence& sequence, double seconds) {
  return render(sequence.scene, seconds, pose_at(sequence.path, seconds), sequence.rays,
                sequence.threads);
}

// A few rows after the other, by the camera's pose at the time of each few; the middle one's is
// that of the picture.
Render render_by_rows(const SyntheticSequence& sequence, double seconds) {
  constexpr int kRows = 4;
  const int width = sequence.rays.cols - 1, height = sequence.rays.rows - 1;
  Render whole{.bgr = cv::Mat_<cv::Vec3f>(height, width),
               .depth = cv::Mat_<float>(height, width),
               .incidence = cv::Mat_<float>(height, width)};
  for_each_block((height + kRows - 1) / kRows, sequence.threads, [&](int block) {
    const cv::Range rows(block * kRows, std::min(height, (block + 1) * kRows));
    const double share = 0.5 * (rows.start + rows.end) / height - 0.5;
    const double then = seconds + share * sequence.options.readout_time;
    const Render part = render(sequence.scene, then, pose_at(sequence.path, then),
                               sequence.rays.rowRange(rows.start, rows.end + 1), 1);
    part.bgr.copyTo(whole.bgr.rowRange(rows));
    part.depth.copyTo(whole.depth.rowRange(rows));
    part.incidence.copyTo(whole.incidence.rowRange(rows));
  });
  return whole;
}

Render render_at(const SyntheticSequence& sequence, double seconds) {
  return sequence.options.readout_time == 0 ? render_at_once(sequence, seconds)
                                            : render_by_rows(sequence, seconds);
}

// The mean of pictures taken while the shutter is open; depth is of the middle of that time.
void blur_motion(const SyntheticSequence& sequence, double seconds, Render& image) {
  constexpr int kPictures = 5;
  const double open = sequence.options.exposure_time;
  cv::Mat_<cv::Vec3f> sum = image.bgr.clone();
  for (int i = 0; i < kPictures; ++i) {
    if (i == kPictures / 2) continue;  // that one is given
    const double offset = open * ((i + 0.5) / kPictures - 0.5);
    sum += render_at(sequence, seconds + offset).bgr;
  }
  image.bgr = sum * (1.0 / kPictures);
}

// Towards the mean of the two colours of each surface.
void flatten_patterns(Scene& scene, double contrast) {
  for (Material& material : scene.materials) {
    const Eigen::Vector3f middle = 0.5F * (material.dark + material.bright);
    material.dark = middle + static_cast<float>(contrast) * (material.dark - middle);
    material.bright = middle + static_cast<float>(contrast) * (material.bright - middle);
  }
}

}  // namespace

SyntheticSequence make_sequence(const SequenceOptions& options, const DistortedCamera& camera,
                                const Trajectory& recorded) {
  check(camera.pinhole);
  visit_fields(options, RangeCheck{});
  visit_fields(options.sensor, RangeCheck{});
  const auto seed = static_cast<std::uint64_t>(options.seed);
  SyntheticSequence sequence{.options = options,
                             .camera = camera,
                             .scene = make_scene(options.scene, seed),
                             .path = {},
                             .rays = make_rays(camera),
                             .kept = {}};
  sequence.path = make_path(options.path, sequence.scene.stage, seed);
  if (!recorded.empty())
    sequence.path.recorded = fit_into(sequence.scene, without_jitter(recorded));
  else if (options.path == PathName::kRounds)
    sequence.path.recorded = make_rounds(sequence.scene, walk_length(options), seed);
  if (const Trajectory& motion = sequence.path.recorded; !motion.empty()) {
    const double duration = seconds_between(motion.front().stamp, motion.back().stamp);
    const auto frames = static_cast<int>(std::min(duration * options.rate, 1e9)) + 1;
    const bool is_whole = recorded.empty() && options.path_length > 0;
    sequence.options.frames = is_whole ? frames : std::min(options.frames, frames);
  }
  sequence.kept = kept_frames(sequence.options);
  const double middle = 0.5 * time_of(sequence.options, sequence.options.frames - 1);  // [s]
  add_moving_thing(sequence.scene, options.moving, options.moving_share,
                   {.camera = camera.pinhole,
                    .world_from_camera = pose_at(sequence.path, middle),
                    .seconds = middle},
                   seed);
  if (options.texture < 1) flatten_patterns(sequence.scene, options.texture);
  sequence.scene.shadows = options.shadows;
  sequence.scene.lamp_swing = static_cast<float>(options.lamp_swing);
  return sequence;
}

StampedPose pose_of(const SyntheticSequence& sequence, int index) {
  const double seconds = time_of(sequence.options, sequence.kept[static_cast<std::size_t>(index)]);
  return {.stamp = stamp_at(seconds), .world_from_camera = pose_at(sequence.path, seconds)};
}

RgbdImage make_frame(const SyntheticSequence& sequence, int index) {
  const SequenceOptions& options = sequence.options;
  const int number = sequence.kept[static_cast<std::size_t>(index)];
  const double seconds = time_of(options, number);
  Render exact = render_at(sequence, seconds);
  if (options.exposure_time > 0) blur_motion(sequence, seconds, exact);
  // The camera that measures a Kinect's depth has a rolling shutter as well; others' have none.
  const double delay = depth_delay(options.sensor);
  const bool is_global = options.readout_time != 0 && options.sensor.kind != SensorKind::kKinect1;
  if (delay > 0 || is_global) {
    const Render before = render_at_once(sequence, seconds - delay);
    exact.depth = before.depth;
    exact.incidence = before.incidence;
  }
  RgbdImage image = sense(exact, options.sensor, sequence.camera.pinhole.fx, seconds,
                          static_cast<std::uint64_t>(options.seed),
                          static_cast<std::uint64_t>(number), sequence.threads);
  image.stamp = stamp_at(seconds);
  return image;
}

Trajectory ground_truth(const SyntheticSequence& sequence) {
  const SequenceOptions& options = sequence.options;
  Trajectory truth;
  for (int i = 0; i <= (options.frames - 1) * kPosesPerFrame; ++i) {
    const double seconds = time_of(options, i / kPosesPerFrame) +
                           (i % kPosesPerFrame) / (options.rate * kPosesPerFrame);
    truth.push_back(
        {.stamp = stamp_at(seconds), .world_from_camera = pose_at(sequence.path, seconds)});
  }
  return truth;
}

}  // namespace edvo::synth

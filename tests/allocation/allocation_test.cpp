// SPDX-License-Identifier: MIT
// What tracking takes from the heap. A program of its own, because its malloc counts.
#include "allocation/counted_malloc.hpp"
#include "edvo/odometry/local_map.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/track/turn.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <new>

namespace edvo {
namespace {

using test::allocations;

const synth::SyntheticSequence& sequence() {
  static const synth::SyntheticSequence instance = test::make_sequence({}, test::kQvgaCamera);
  return instance;
}

// Allocations of a call.
template <typename Call>
std::int64_t taken_by(Call&& call) {
  const std::int64_t before = allocations();
  call();
  return allocations() - before;
}

// Of every frame but keyframes, the frames after them (which refine them) and those at which the
// trajectory, that grows with the sequence, doubles its room.
std::int64_t taken_between_keyframes(const Config& config, int frames) {
  constexpr int kWarm = 3;  // frames
  Odometry odometry({test::kQvgaCamera, {}}, config);
  std::int64_t taken = 0;
  int counted = 0;
  bool after_keyframe = true;
  for (int i = 0; i < frames; ++i) {
    const PreparedImage image = odometry.prepare(synth::make_frame(sequence(), i));
    FrameReport report;
    const std::int64_t of_this = taken_by([&] { report = odometry.process_prepared(image); });
    EXPECT_NE(report.status, FrameStatus::kLost) << i;
    const bool doubles = std::has_single_bit(static_cast<unsigned>(i));
    if (i >= kWarm && !after_keyframe && !report.keyframe && !doubles) {
      EXPECT_EQ(of_this, 0) << "frame " << i;
      taken += of_this;
      ++counted;
    }
    after_keyframe = report.keyframe.has_value();
  }
  EXPECT_GE(counted, frames / 3);
  return taken;
}

TEST(Allocation, IsCountedThroughEveryDoor) {
  EXPECT_EQ(taken_by([] {}), 0);
  EXPECT_EQ(taken_by([] { ::operator delete(::operator new(8)); }), 1);
  EXPECT_GE(taken_by([] { cv::Mat_<float>(100, 100); }), 1);
}

TEST(Allocation, TrackingWithRoomToWorkTakesNothing) {
  const Config config = preset(Method::kCannyCorner);
  const Undistortion undistortion = make_undistortion({test::kQvgaCamera, {}});
  const Frame key = make_frame(synth::make_frame(sequence(), 0), undistortion, config.frame);
  const Frame current = make_frame(synth::make_frame(sequence(), 2), undistortion, config.frame);
  Reference reference = make_reference(
      key,
      select_pixels(
          key, with_corner_discs(edge_mask(key, undistortion, nullptr, config), config.corners),
          undistortion.valid, config.selection),
      {});
  reference.surface = make_surface(key.depth, undistortion.camera, config.tracking.surface_cell,
                                   config.tracking.depth_noise);
  TrackScratch scratch;
  const auto align = [&] {
    const TrackResult result = track(reference, current, {}, config.tracking, scratch);
    EXPECT_EQ(result.status, TrackStatus::kTracked);
  };
  EXPECT_GT(taken_by(align), 0);  // the first time
  EXPECT_EQ(taken_by(align), 0);
  EXPECT_EQ(taken_by([&] { (void)coarse_cost(reference, current, {}, config.tracking, scratch); }),
            0);
}

TEST(Allocation, CorrelationTakesNothingAfterTwoImages) {
  cv::Mat_<std::uint8_t> image(30, 40);
  cv::randu(image, 0, 256);
  PhaseCorrelation correlation;
  for (int i = 0; i < 2; ++i) correlation.shift_to(image);
  EXPECT_EQ(taken_by([&] { correlation.shift_to(image); }), 0);
}

TEST(Allocation, FramesBetweenKeyframesTakeNothing) {
  EXPECT_EQ(taken_between_keyframes(preset(Method::kCannyCorner), 24), 0);
}

TEST(Allocation, FramesLookedAtTwiceTakeNothing) {
  Config config = preset(Method::kCannyCorner);
  config.coarse.second_look = 0;  // always
  EXPECT_EQ(taken_between_keyframes(config, 16), 0);
}

}  // namespace
}  // namespace edvo

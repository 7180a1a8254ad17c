// SPDX-License-Identifier: MIT
// What tracking takes from the heap. A program of its own, because its malloc counts.
#include "allocation/counted_malloc.hpp"
#include "edvo/align/image_shift.hpp"
#include "edvo/features/corners.hpp"
#include "edvo/odometry/moving_object_guard.hpp"
#include "edvo/odometry/odometry.hpp"
#include "support/rendered_sequence.hpp"
#include "support/synthetic_plane.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <new>

namespace edvo {
namespace {

using test::allocations;

constexpr int kFrames = 18;

// Frame i of a camera that slides along a wall, which it sees at an angle: constant depth is none.
RgbdImage image(int i) {
  static const SE3 oblique = exp((Vector6d() << 0, 0, 0, 0.05, 0.08, 0).finished());
  return test::render_plane({.distance = 2.0}, test::kSmallCamera,
                            oblique * SE3{.translation = {0.004 * i, 0.002 * i, 0}},
                            stamp_from_seconds(i / 30.0));
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
  Odometry odometry({test::kSmallCamera, {}}, config);
  std::int64_t taken = 0;
  int counted = 0;
  bool after_keyframe = true;
  for (int i = 0; i < frames; ++i) {
    const PreparedImage prepared = odometry.prepare(image(i));
    FrameResult report;
    const std::int64_t of_this = taken_by([&] { report = odometry.process(prepared); });
    EXPECT_NE(report.status, FrameStatus::kLost) << i;
    const bool doubles = std::has_single_bit(static_cast<unsigned>(i));
    if (i >= kWarm && !after_keyframe && !report.keyframe_reason && !doubles) {
      EXPECT_EQ(of_this, 0) << "frame " << i;
      taken += of_this;
      ++counted;
    }
    after_keyframe = report.keyframe_reason.has_value();
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
  const Undistortion undistortion = make_undistortion({test::kSmallCamera, {}});
  const Frame key = make_frame(image(0), undistortion);
  const Frame current = make_frame(image(2), undistortion);
  Reference reference = make_reference(
      key,
      select_pixels(
          key,
          with_corner_discs(canny_edges(key.levels.front().gray, config.canny), config.corners),
          undistortion.valid, config.selection),
      {});
  reference.surface = make_surface(key.depth, undistortion.camera, config.tracking.surface_cell,
                                   config.tracking.depth_noise);
  AlignScratch scratch;
  const auto align_once = [&] {
    const AlignResult result = align(reference, current, {}, config.tracking, scratch);
    EXPECT_EQ(result.status, AlignStatus::kTracked);
  };
  EXPECT_GT(taken_by(align_once), 0);  // the first time
  EXPECT_EQ(taken_by(align_once), 0);
  EXPECT_EQ(taken_by([&] { (void)coarse_cost(reference, current, {}, config.tracking, scratch); }),
            0);
}

TEST(Allocation, CorrelationTakesNothingAfterTwoImages) {
  cv::Mat_<std::uint8_t> noise(30, 40);
  cv::randu(noise, 0, 256);
  PhaseCorrelation correlation;
  const auto correlate = [&] {
    (void)correlation.shift_to(noise);
    correlation.set_reference(noise);
  };
  for (int i = 0; i < 2; ++i) correlate();
  EXPECT_EQ(taken_by(correlate), 0);
}

TEST(Allocation, FramesBetweenKeyframesTakeNothing) {
  EXPECT_EQ(taken_between_keyframes(preset(Method::kCannyCorner), kFrames), 0);
}

TEST(Allocation, TheMovingObjectGuardTakesNothing) {
  const Config config = preset(Method::kCannyCorner);
  const auto sequence = test::make_sequence({.frames = 2, .sensor = {}}, test::kQvgaCamera);
  const Undistortion undistortion = make_undistortion(sequence.camera);
  const Frame key = make_frame(synth::make_frame(sequence, 0), undistortion);
  const Frame frame = make_frame(synth::make_frame(sequence, 1), undistortion);
  const Reference reference = make_reference(key, grid_pixels(key, 5, config.selection), {});
  const MovingObjectGuard guard(config.tracking);
  AlignScratch scratch;
  const AlignResult first = align(reference, frame, {}, config.tracking, scratch);
  const auto look_again = [&] {
    TrackingState state{.usual_sigma = 0, .moving_object_frames = 5};  // looks again for sure
    (void)guard.check(first, reference, frame, SE3{}, {}, state, scratch);
    EXPECT_NE(state.moving_object_frames, 5);
  };
  look_again();
  EXPECT_EQ(taken_by(look_again), 0);
}

}  // namespace
}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/slam/slam.hpp"

#include "edvo/eval/evaluate.hpp"
#include "support/matchers.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace edvo {
namespace {

struct World {
  synth::SyntheticSequence sequence;
  std::vector<RgbdImage> images;
};

// To and fro around the middle of a room: each place is seen again and again.
const World& orbit() {
  static const World kWorld = [] {
    World world{.sequence = test::make_sequence({.scene = synth::SceneName::kOffice,
                                                 .path = synth::PathName::kOrbit,
                                                 .seed = 1,
                                                 .frames = 90,
                                                 .rate = 6},
                                                test::kQvgaCamera),
                .images = {}};
    for (int i = 0; i < synth::frame_count(world.sequence); ++i)
      world.images.push_back(synth::make_frame(world.sequence, i));
    return world;
  }();
  return kWorld;
}

Stamp tenth(int i) {
  return stamp_from_seconds(i / 10.0, 6);
}

struct Taken {
  std::vector<RgbdImage> images;
  Trajectory truth;
};

std::vector<RgbdImage> another_room(synth::SceneName scene) {
  const synth::SyntheticSequence sequence = test::make_sequence(
      {.scene = scene, .path = synth::PathName::kOrbit, .frames = 10}, test::kQvgaCamera);
  std::vector<RgbdImage> images;
  for (int i = 0; i < synth::frame_count(sequence); ++i)
    images.push_back(synth::make_frame(sequence, i));
  return images;
}

// Some frames in a room, some in two others, to which the camera is carried covered, and some in
// the first room again: too late for the odometry, which can go back to the segment before only.
Taken carried_away_and_back() {
  Taken taken;
  const auto take = [&taken](const RgbdImage& image) {
    taken.images.push_back(image);
    taken.images.back().stamp = tenth(static_cast<int>(taken.images.size()));
  };
  const auto take_frame = [&](int i) {
    take(orbit().images[static_cast<std::size_t>(i)]);
    taken.truth.push_back(
        {.stamp = taken.images.back().stamp,
         .world_from_camera = synth::pose_of(orbit().sequence, i).world_from_camera});
  };
  const auto cover = [&] {
    RgbdImage black = orbit().images.front();
    black.bgr = cv::Mat_<cv::Vec3b>(black.bgr.size(), cv::Vec3b::all(0));
    black.depth = cv::Mat_<float>(black.depth.size(), std::numeric_limits<float>::quiet_NaN());
    for (int i = 0; i < 4; ++i) take(black);
  };
  for (int i = 0; i < 30; ++i) take_frame(i);
  cover();
  for (const auto scene : {synth::SceneName::kLivingRoom, synth::SceneName::kBoxes}) {
    for (const RgbdImage& image : another_room(scene)) take(image);
    cover();
  }
  for (int i = 12; i >= 0; --i) take_frame(i);
  return taken;
}

template <typename Tracker>
Tracker track(const std::vector<RgbdImage>& images, int threads = 1) {
  Tracker tracker({.pinhole = test::kQvgaCamera}, preset(Method::kCannyCorner));
  for (const RgbdImage& image : images) (void)tracker.process(image);
  tracker.finish(threads);
  return tracker;
}

std::set<int> segments_of(const Trajectory& trajectory) {
  std::set<int> segments;
  for (const StampedPose& pose : trajectory) segments.insert(pose.segment);
  return segments;
}

TEST(Slam, JoinsTheSegmentsOfOneRoomAndNotThoseOfOthers) {
  const Taken taken = carried_away_and_back();
  ASSERT_EQ(segments_of(track<Odometry>(taken.images).trajectory()), (std::set<int>{0, 1, 2, 3}));
  const Slam slam = track<Slam>(taken.images);
  EXPECT_EQ(segments_of(slam.trajectory()), (std::set<int>{0, 1, 2}));
  EXPECT_LT(evaluate(taken.truth, slam.trajectory()).ate.distance.rmse, 0.01);
  for (const LinkReport& link : slam.links())
    if (slam.map()[link.from].segment != slam.map()[link.to].segment) {
      EXPECT_NE(link.status, LinkStatus::kAccepted) << link.from << " to " << link.to;
    }
}

TEST(Slam, AcceptsNoWrongLinkAndDoesNoHarmOnAPathToAndFro) {
  const World& world = orbit();
  const Slam slam = track<Slam>(world.images);
  const auto truth_of = [&](std::int64_t id) {
    int index = 0;
    while (synth::pose_of(world.sequence, index).stamp != slam.map()[id].stamp) ++index;
    return synth::pose_of(world.sequence, index).world_from_camera;
  };
  EXPECT_FALSE(slam.links().empty());
  for (const LinkReport& link : slam.links()) {
    if (link.status != LinkStatus::kAccepted) continue;
    EXPECT_THAT(link.from_pose_to,
                test::NearPose(inverse(truth_of(link.from)) * truth_of(link.to), 0.05));
  }
  const Trajectory truth = synth::ground_truth(world.sequence);
  const auto ate = [&](const Trajectory& t) { return evaluate(truth, t).ate.distance.rmse; };
  EXPECT_LT(ate(slam.trajectory()), 1.03 * ate(track<Odometry>(world.images).trajectory()));
}

TEST(Slam, SameBitsWithAnyNumberOfThreads) {
  const std::vector<RgbdImage> images = carried_away_and_back().images;
  const Trajectory a = track<Slam>(images, 1).trajectory(), b = track<Slam>(images, 3).trajectory();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].world_from_camera.translation, b[i].world_from_camera.translation);
    EXPECT_EQ(a[i].world_from_camera.rotation.coeffs(), b[i].world_from_camera.rotation.coeffs());
  }
}

// Where the odometry begins anew, it is found among keyframes of three segments before.
TEST(Slam, FindsAKidnappedCameraWithinTenFramesWhileImagesCome) {
  const Taken taken = carried_away_and_back();
  const SE3 first = taken.truth.front().world_from_camera;
  Slam slam({.pinhole = test::kQvgaCamera}, preset(Method::kCannyCorner));
  int frames = 0, found_after = -1;
  for (const RgbdImage& image : taken.images) {
    const FrameResult result = slam.process(image);
    const MapFrame frame = slam.map_frame(result.segment);
    if (result.segment == 1 || result.segment == 2) {
      EXPECT_EQ(frame.segment, result.segment) << "another room was taken for the first";
    }
    if (result.segment != 3 || result.status == FrameStatus::kLost) continue;
    ++frames;
    if (frame.segment != 0) continue;
    if (found_after < 0) found_after = frames;
    const auto truth =
        std::find_if(taken.truth.begin(), taken.truth.end(),
                     [&](const StampedPose& pose) { return pose.stamp == image.stamp; });
    const SE3 error = inverse(inverse(first) * truth->world_from_camera) *
                      (frame.map_from_odometry * result.world_from_camera);
    EXPECT_LT(error.translation.norm(), 0.05);
    EXPECT_LT(rotation_angle(error), 0.035);
  }
  EXPECT_GT(found_after, 0);
  EXPECT_LE(found_after, 10);
}

TEST(Slam, AnEmptyRunHasNothing) {
  Slam slam({.pinhole = test::kQvgaCamera}, preset(Method::kCannyCorner));
  slam.finish();
  EXPECT_TRUE(slam.trajectory().empty());
  EXPECT_TRUE(slam.links().empty());
}

}  // namespace
}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/saved_map/slam_in_map.hpp"

#include "edvo/core/error.hpp"
#include "edvo/eval/evaluate.hpp"
#include "edvo/io/file.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/saved_map/map_views.hpp"
#include "support/error_matcher.hpp"
#include "support/matchers.hpp"
#include "support/rendered_sequence.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

// A camera on its way through a room; seed: of motion and noise, not of the room.
struct Visit {
  std::vector<RgbdImage> images;
  Trajectory truth;
};

Visit visit(synth::SceneName scene, synth::PathName path, double start, int frames) {
  synth::SyntheticSequence sequence = test::make_sequence(
      {.scene = scene, .path = path, .seed = 1, .frames = 200, .rate = 6, .sensor = {}},
      test::kQvgaCamera);
  Visit made;
  const int first = static_cast<int>(start * 6);
  for (int i = first; i < first + frames; ++i) {
    made.images.push_back(synth::make_frame(sequence, i));
    made.truth.push_back(synth::pose_of(sequence, i));
  }
  return made;
}

const Visit& first_visit() {
  static const Visit kVisit = visit(synth::SceneName::kOffice, synth::PathName::kOrbit, 0, 60);
  return kVisit;
}

const Visit& second_visit() {
  static const Visit kVisit = visit(synth::SceneName::kOffice, synth::PathName::kDemo, 4, 40);
  return kVisit;
}

const Visit& elsewhere() {
  static const Visit kVisit = visit(synth::SceneName::kLivingRoom, synth::PathName::kOrbit, 0, 30);
  return kVisit;
}

SlamInMap track(const Visit& visit, std::optional<SavedMap> map = {}, bool extend = false,
                int threads = 1) {
  const Config config = preset(Method::kCannyCorner);
  SlamInMap slam({.pinhole = test::kQvgaCamera}, config,
                 {.loops = {}, .links = {}, .keep_colour = true}, nullptr,
                 {.camera = test::kQvgaCamera,
                  .depth_scale = 0,
                  .method = "canny+corner",
                  .config = to_toml(config),
                  .made_by = "test"},
                 std::move(map), extend);
  for (const RgbdImage& image : visit.images) (void)slam.process(image);
  slam.finish(threads);
  return slam;
}

const SavedMap& first_map() {
  static const SavedMap kMap = track(first_visit()).saved_map();
  return kMap;
}

const SavedMap& second_map() {
  static const SavedMap kMap = track(second_visit()).saved_map();
  return kMap;
}

MergeOptions merge_options(int threads = 1) {
  return {.tracking = preset(Method::kCannyCorner).tracking,
          .loops = {},
          .links = {},
          .window = preset(Method::kCannyCorner).window,
          .threads = threads};
}

// Largest distance of poses from where they truly are in the first visit's frame.
double largest_error(const Trajectory& trajectory, const Trajectory& truth) {
  const SE3 map_from_world = inverse(first_visit().truth.front().world_from_camera);
  double largest = 0;
  for (const StampedPose& pose : trajectory)
    for (const StampedPose& real : truth)
      if (real.stamp == pose.stamp)
        largest = std::max(largest, ((map_from_world * real.world_from_camera).translation -
                                     pose.world_from_camera.translation)
                                        .norm());
  return largest;
}

TEST(SlamInMap, AnotherPathIsFoundInTheMapOfAnEarlierOne) {
  const SlamInMap slam = track(second_visit(), first_map());
  ASSERT_TRUE(slam.localization());
  EXPECT_EQ(slam.localization()->segments, std::vector<int>{0});
  EXPECT_EQ(slam.trajectory().size(), second_visit().images.size());
  EXPECT_LT(largest_error(slam.trajectory(), second_visit().truth), 0.03);
}

TEST(SlamInMap, AnotherRoomIsNotFoundAndStaysWhereItWas) {
  const SlamInMap slam = track(elsewhere(), first_map());
  EXPECT_TRUE(slam.localization()->segments.empty());
  const Trajectory alone = track(elsewhere()).trajectory(), now = slam.trajectory();
  ASSERT_EQ(now.size(), alone.size());
  for (std::size_t i = 0; i < now.size(); ++i)
    EXPECT_EQ(now[i].world_from_camera.translation, alone[i].world_from_camera.translation);
}

TEST(SlamInMap, ExtendsTheMapAndLeavesItInItsFrame) {
  const SavedMap map = track(second_visit(), first_map(), true).saved_map();
  const std::size_t first = first_map().keyframes.size();
  EXPECT_EQ(map.keyframes.size(), first + second_map().keyframes.size());
  EXPECT_EQ(segments_of(map), std::vector<int>{0});
  EXPECT_GT(map.links.size(), first_map().links.size() + second_map().links.size());
  for (std::size_t i = 0; i < first; ++i)
    EXPECT_THAT(map.keyframes[i].world_from_camera,
                test::NearPose(first_map().keyframes[i].world_from_camera, 0.02));
}

TEST(SlamInMap, SameBitsWithAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  for (const int threads : {1, 3})
    save_map(folder.path() / std::to_string(threads),
             track(second_visit(), first_map(), true, threads).saved_map());
  EXPECT_EQ(read_file(folder.path() / "1"), read_file(folder.path() / "3"));
}

TEST(SlamInMap, RefusesTheMapOfAnotherCamera) {
  SavedMap map = first_map();
  map.origin.camera.fx += 2;
  EXPECT_TRUE(test::fails_with(ErrorCode::kMap, {"another camera"},
                               [&] { (void)track(second_visit(), map); }));
}

TEST(MergeMaps, OrderChangesLittle) {
  const MergedMaps a = merge_maps(first_map(), second_map(), merge_options());
  const MergedMaps b = merge_maps(second_map(), first_map(), merge_options());
  ASSERT_EQ(a.joined, std::vector<int>{0});
  ASSERT_EQ(b.joined, std::vector<int>{0});
  Trajectory truth = first_visit().truth;
  truth.insert(truth.end(), second_visit().truth.begin(), second_visit().truth.end());
  // Both visits have the same stamps where they overlap: those of the first are moved away.
  const auto ate = [&](const MergedMaps& merged) {
    Trajectory estimate, real;
    for (std::size_t i = 0; i < merged.map.keyframes.size(); ++i) {
      const bool is_second = static_cast<KeyframeId>(i) >= merged.first_of_second;
      const bool is_of_first_visit = is_second == (&merged == &b);
      const MapKeyframe& key = merged.map.keyframes[i];
      for (const StampedPose& pose :
           is_of_first_visit ? first_visit().truth : second_visit().truth) {
        if (pose.stamp != key.stamp) continue;
        Stamp stamp = pose.stamp;
        if (is_of_first_visit) stamp.nanoseconds += 1'000'000'000'000;
        estimate.push_back({.stamp = stamp, .world_from_camera = key.world_from_camera});
        real.push_back({.stamp = stamp, .world_from_camera = pose.world_from_camera});
      }
    }
    const auto by_stamp = [](const StampedPose& p, const StampedPose& q) {
      return p.stamp < q.stamp;
    };
    std::sort(estimate.begin(), estimate.end(), by_stamp);
    std::sort(real.begin(), real.end(), by_stamp);
    return evaluate(real, estimate).ate.distance.rmse;
  };
  const double ate_a = ate(a), ate_b = ate(b);
  RecordProperty("ate_mm", std::to_string(1000 * ate_a) + ", " + std::to_string(1000 * ate_b));
  EXPECT_LT(ate_a, 0.02);
  constexpr double kNothing = 0.0001;  // [m]
  EXPECT_NEAR(ate_a, ate_b, std::max(kNothing, 0.05 * ate_a));
}

TEST(MergeMaps, JoinsNothingThatDoesNotOverlap) {
  const MergedMaps merged =
      merge_maps(first_map(), track(elsewhere()).saved_map(), merge_options());
  EXPECT_TRUE(merged.joined.empty());
  EXPECT_EQ(segments_of(merged.map), (std::vector<int>{0, 1}));
}

TEST(MapViews, PointsLieInTheRoomWithItsColours) {
  const std::vector<ColoredPoint> points = colored_points(first_map(), 0);
  ASSERT_GT(points.size(), 1000u);
  EXPECT_TRUE(std::any_of(points.begin(), points.end(), [](const ColoredPoint& point) {
    return std::abs(point.rgb[0] - point.rgb[2]) > 50;
  }));
  EXPECT_EQ(depth_views(first_map(), 0).size(), first_map().views.size());
  EXPECT_TRUE(depth_views(first_map(), 7).empty());
}

}  // namespace
}  // namespace edvo

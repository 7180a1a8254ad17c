// SPDX-License-Identifier: MIT
#include "logic/tracking.hpp"

#include "edvo/core/error.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "support/rendered_sequence.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

namespace edvo::ros {
namespace {

using ::testing::HasSubstr;

ImageMessage colour_message(const RgbdImage& image, std::int64_t stamp_ns) {
  ImageMessage message{.stamp_ns = stamp_ns,
                       .encoding = "bgr8",
                       .width = image.bgr.cols,
                       .height = image.bgr.rows,
                       .step = image.bgr.cols * 3};
  message.data.assign(image.bgr.datastart, image.bgr.dataend);
  return message;
}

ImageMessage depth_message(const RgbdImage& image, std::int64_t stamp_ns) {
  ImageMessage message{.stamp_ns = stamp_ns,
                       .encoding = "16UC1",
                       .width = image.depth.cols,
                       .height = image.depth.rows,
                       .step = image.depth.cols * 2};
  for (const float z : image.depth) {
    const auto units = static_cast<std::uint16_t>(z > 0 ? std::lround(1000 * z) : 0);
    message.data.push_back(static_cast<std::uint8_t>(units & 255));
    message.data.push_back(static_cast<std::uint8_t>(units >> 8));
  }
  return message;
}

struct World {
  synth::SyntheticSequence sequence = test::make_sequence({.frames = 60}, test::kQvgaCamera);
  std::vector<TrackingOutput> outputs;

  // Depth comes 5 ms after colour, and before the next colour image.
  void play(Tracking& tracking, int first, int count) {
    for (int i = first; i < first + count; ++i) {
      const RgbdImage image = synth::make_frame(sequence, i);
      const std::int64_t stamp = image.stamp.nanoseconds;
      EXPECT_FALSE(tracking.add_colour(colour_message(image, stamp)));
      if (auto output = tracking.add_depth(depth_message(image, stamp + 5'000'000)))
        outputs.push_back(std::move(*output));
    }
  }
};

TEST(RosTracking, FollowsTheCameraInTheAxesOfRep103) {
  World world;
  Tracking tracking({});
  tracking.set_camera({test::kQvgaCamera, {}});
  world.play(tracking, 0, 30);
  ASSERT_EQ(world.outputs.size(), 30u);
  EXPECT_LT(log(world.outputs.front().odom_from_base).norm(), 1e-12);

  const SE3 truth = inverse(synth::pose_of(world.sequence, 0).world_from_camera) *
                    synth::pose_of(world.sequence, 29).world_from_camera;
  const TrackingOutput& last = world.outputs.back();
  EXPECT_TRUE(last.has_pose);
  const Eigen::Vector3d moved = last.odom_from_base.translation;
  EXPECT_NEAR(moved.x(), truth.translation.z(), 0.01);   // ahead
  EXPECT_NEAR(moved.y(), -truth.translation.x(), 0.01);  // to the left
  EXPECT_NEAR(moved.z(), -truth.translation.y(), 0.01);  // up
  EXPECT_GT(truth.translation.norm(), 0.05);
  EXPECT_LT(log(last.map_from_odom).norm(), 1e-12);
}

TEST(RosTracking, CovarianceIsSymmetricPositiveAndGrows) {
  World world;
  Tracking tracking({});
  tracking.set_camera({test::kQvgaCamera, {}});
  world.play(tracking, 0, 60);
  const auto size = [](const TrackingOutput& output) {
    return output.covariance.topLeftCorner<3, 3>().trace();
  };
  for (const TrackingOutput& output : world.outputs) {
    EXPECT_LT((output.covariance - output.covariance.transpose()).norm(),
              1e-9 * output.covariance.norm());
    EXPECT_GT(output.covariance.ldlt().vectorD().minCoeff(), 0);
  }
  EXPECT_GT(size(world.outputs.back()), size(world.outputs[1]));
}

TEST(RosTracking, PairsByTimeAndCountsWhatHasNoPartner) {
  World world;
  Tracking tracking({.sync_tolerance = 0.01, .queue = 3});
  tracking.set_camera({test::kQvgaCamera, {}});
  const RgbdImage image = synth::make_frame(world.sequence, 0);
  constexpr std::int64_t kPeriod = 33'333'333;
  EXPECT_FALSE(tracking.add_colour(colour_message(image, 0)));  // its depth was dropped
  EXPECT_FALSE(tracking.add_colour(colour_message(image, kPeriod)));
  EXPECT_FALSE(tracking.add_depth(depth_message(image, kPeriod - 12'000'000)));  // too far
  const auto output = tracking.add_depth(depth_message(image, kPeriod + 4'000'000));
  ASSERT_TRUE(output);
  EXPECT_EQ(output->stamp_ns, kPeriod);
  EXPECT_EQ(tracking.status().unpaired, 2);
  for (int i = 2; i < 8; ++i) EXPECT_FALSE(tracking.add_colour(colour_message(image, i * kPeriod)));
  EXPECT_EQ(tracking.status().unpaired, 5);
}

TEST(RosTracking, OneLostImageShiftsNoLaterPair) {
  World world;
  for (const std::int64_t period : {33'333'333, 16'666'667, 11'111'111}) {
    for (const std::int64_t late : {-3'000'000, 0, 3'000'000}) {  // depth's stamp after colour's
      Tracking tracking({});
      tracking.set_camera({test::kQvgaCamera, {}});
      int pairs = 0;
      for (int i = 0; i < 12; ++i) {
        const RgbdImage image = synth::make_frame(world.sequence, i);
        const std::int64_t stamp = i * period;
        if (i != 4) {
          const auto early = tracking.add_colour(colour_message(image, stamp));
          EXPECT_TRUE(!early || early->stamp_ns < stamp) << "with the depth of another image";
        }
        const auto output = tracking.add_depth(depth_message(image, stamp + late));
        pairs += output ? 1 : 0;
        if (output && i > 1) {
          EXPECT_EQ(output->stamp_ns, stamp);
        }
      }
      EXPECT_GE(pairs, 10) << period << " " << late;
      EXPECT_LE(tracking.status().unpaired, 2) << period << " " << late;
    }
  }
}

TEST(RosTracking, AClockThatJumpsBackBeginsAnew) {
  World world;
  Tracking tracking({});
  tracking.set_camera({test::kQvgaCamera, {}});
  constexpr std::int64_t kLater = 100'000'000'000;
  for (int i = 0; i < 5; ++i) {
    const RgbdImage image = synth::make_frame(world.sequence, 10 + i);
    const std::int64_t stamp = kLater + image.stamp.nanoseconds;
    (void)tracking.add_colour(colour_message(image, stamp));
    EXPECT_TRUE(tracking.add_depth(depth_message(image, stamp)));
  }
  world.play(tracking, 0, 5);
  ASSERT_EQ(world.outputs.size(), 5U);
  EXPECT_EQ(world.outputs.front().result.status, FrameStatus::kFirst);
  EXPECT_EQ(tracking.status().refused, 0);
  EXPECT_EQ(tracking.status().restarts, 1);
  EXPECT_NEAR(tracking.status().last_jump, 100, 1);
}

TEST(RosTracking, APairThatCannotBeUsedStopsNothing) {
  World world;
  Tracking tracking({});
  tracking.set_camera({test::kQvgaCamera, {}});
  world.play(tracking, 0, 2);
  const RgbdImage image = synth::make_frame(world.sequence, 2);
  ImageMessage colour = colour_message(image, image.stamp.nanoseconds);
  colour.encoding = "yuv422";
  EXPECT_FALSE(tracking.add_colour(colour));
  EXPECT_FALSE(tracking.add_depth(depth_message(image, image.stamp.nanoseconds)));
  EXPECT_EQ(tracking.status().refused, 1);
  EXPECT_THAT(tracking.status().last_problem, HasSubstr("yuv422"));
  world.play(tracking, 3, 2);
  EXPECT_EQ(tracking.status().tracked, 4);
}

TEST(RosTracking, LosesTheCameraInTheDarkAndFindsItAgain) {
  World world;
  Tracking tracking({});
  tracking.set_camera({test::kQvgaCamera, {}});
  world.play(tracking, 0, 10);
  RgbdImage dark = synth::make_frame(world.sequence, 10);
  dark.bgr.setTo(cv::Scalar::all(0));
  EXPECT_FALSE(tracking.add_colour(colour_message(dark, dark.stamp.nanoseconds)));
  const auto lost = tracking.add_depth(depth_message(dark, dark.stamp.nanoseconds));
  ASSERT_TRUE(lost);
  EXPECT_FALSE(lost->has_pose);
  EXPECT_EQ(tracking.status().lost, 1);
  world.play(tracking, 11, 3);
  EXPECT_TRUE(world.outputs.back().has_pose);
}

TEST(RosTracking, NothingIsTrackedBeforeTheCameraIsKnownAndAfterReset) {
  World world;
  Tracking tracking({});
  world.play(tracking, 0, 2);
  EXPECT_TRUE(world.outputs.empty());
  tracking.set_camera({test::kQvgaCamera, {}});
  world.play(tracking, 2, 2);
  EXPECT_EQ(world.outputs.size(), 2u);
  tracking.reset();
  EXPECT_FALSE(tracking.has_camera());
  tracking.set_camera({test::kQvgaCamera, {}});
  world.play(tracking, 0, 1);  // time may begin anew, as in a bag that is played again
  EXPECT_EQ(world.outputs.back().result.status, FrameStatus::kFirst);
}

TEST(RosTracking, SavesAMapThatTheLibraryLoads) {
  World world;
  const test::TemporaryFolder folder;
  Tracking tracking({});
  EXPECT_THROW(tracking.save_map(folder.path() / "none.map"), Error);
  tracking.set_camera({test::kQvgaCamera, {}});
  world.play(tracking, 0, 20);
  tracking.save_map(folder.path() / "room.map");
  const SavedMap map = load_map(folder.path() / "room.map");
  EXPECT_FALSE(map.keyframes.empty());
  EXPECT_EQ(map.origin.camera.width, test::kQvgaCamera.width);
}

// Against a tracker that saves nothing: its pose after the save is where odom has to go on.
TEST(RosTracking, OdomGoesOnWhereItWasAfterAMapIsSaved) {
  World plain, saved;
  const test::TemporaryFolder folder;
  for (World* const world : {&plain, &saved}) {
    Tracking tracking({});
    tracking.set_camera({test::kQvgaCamera, {}});
    world->play(tracking, 0, 10);
    if (world == &saved) {
      tracking.save_map(folder.path() / "room.map");
      tracking.save_map(folder.path() / "again.map");
    }
    world->play(tracking, 10, 1);
  }
  const SE3 expected = plain.outputs.back().odom_from_base;
  EXPECT_LT(log(inverse(expected) * saved.outputs.back().odom_from_base).norm(), 2e-5);
  // What moved is the map, by more than that.
  EXPECT_GT(log(saved.outputs.back().map_from_odom).norm(), 1e-4);
}

TEST(RosTracking, RefusesOptionsWithoutSense) {
  EXPECT_THROW(Tracking({.units_per_metre = 0}), Error);
  EXPECT_THROW(Tracking({.queue = 0}), Error);
  EXPECT_THROW(Tracking({.method = Method::kOrigin}), Error);
}

TEST(RosImages, EncodingsStepsAndByteOrderAreRead) {
  const ImageMessage rgb{
      .encoding = "rgb8", .width = 1, .height = 2, .step = 4, .data = {1, 2, 3, 0, 4, 5, 6, 0}};
  const cv::Mat_<cv::Vec3b> bgr = to_bgr(rgb);
  EXPECT_EQ(bgr(0, 0), cv::Vec3b(3, 2, 1));
  EXPECT_EQ(bgr(1, 0), cv::Vec3b(6, 5, 4));

  ImageMessage units{.encoding = "16UC1",
                     .width = 3,
                     .height = 1,
                     .step = 6,
                     .is_bigendian = true,
                     .data = {0x03, 0xe8, 0, 0, 0xff, 0xff}};
  const cv::Mat_<float> depth = to_metres(units, 1000);
  EXPECT_FLOAT_EQ(depth(0, 0), 1.0f);
  EXPECT_TRUE(std::isnan(depth(0, 1)) && std::isnan(depth(0, 2)));
  units.data.pop_back();
  EXPECT_THROW((void)to_metres(units, 1000), Error);

  const std::array<float, 2> metres = {1.5f, -1.0f};
  ImageMessage floats{.encoding = "32FC1", .width = 2, .height = 1, .step = 8};
  floats.data.resize(8);
  std::memcpy(floats.data.data(), metres.data(), 8);
  EXPECT_FLOAT_EQ(to_metres(floats, 1000)(0, 0), 1.5f);
  EXPECT_TRUE(std::isnan(to_metres(floats, 1000)(0, 1)));
}

TEST(RosImages, CameraInfoBecomesACamera) {
  const std::array<double, 9> k = {500, 0, 320, 0, 501, 240, 0, 0, 1};
  const std::vector<double> d = {0.1, -0.2, 0.001, 0.002, 0.05};
  const DistortedCamera camera = to_camera(640, 480, k, "plumb_bob", d);
  EXPECT_EQ(camera.pinhole.fy, 501);
  EXPECT_EQ(camera.distortion[4], 0.05);
  EXPECT_EQ(to_camera(640, 480, k, "equidistant", {}).lens, LensModel::kEquidistant);
  EXPECT_THROW((void)to_camera(640, 480, k, "unheard_of", d), Error);
  EXPECT_THROW((void)to_camera(640, 480, std::array<double, 9>{}, "", {}), Error);
}

}  // namespace
}  // namespace edvo::ros

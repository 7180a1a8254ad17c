// SPDX-License-Identifier: MIT
#include "edvo/io/image_poses.hpp"

#include "edvo/io/camera_choice.hpp"
#include "support/error_matcher.hpp"
#include "support/small_sequence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/core.h>

namespace edvo {
namespace {

using test::fails_with;
using test::TemporaryFolder;
using test::write_colour;
using test::write_depth;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

// A quarter turn about z, then x metres along x.
std::string matrix(double x, const char* separator = "\n") {
  return fmt::format("0 -1 0 {}{}1 0 0 0{}0 0 1 0{}0 0 0 1\n", x, separator, separator, separator);
}

std::vector<double> positions(const Trajectory& trajectory) {
  std::vector<double> x;
  for (const StampedPose& pose : trajectory) x.push_back(pose.world_from_camera.translation.x());
  return x;
}

TEST(ImagePoses, OfSevenScenesLieBesideTheImages) {
  const TemporaryFolder folder;
  for (int i = 0; i < 3; ++i) {
    const std::string name = fmt::format("seq-01/frame-{:06}", i);
    write_colour(folder.path() / (name + ".color.png"), i);
    write_depth(folder.path() / (name + ".depth.png"), 1000);
    folder.write(name + ".pose.txt", i == 1 ? "-inf -inf -inf -inf\n-inf -inf -inf -inf\n"
                                              "-inf -inf -inf -inf\n-inf -inf -inf -inf\n"
                                            : matrix(0.5 * i));
  }
  const Dataset dataset = open_dataset(folder.path());
  ASSERT_THAT(positions(dataset.poses), ElementsAre(0, 1));  // the pose marked invalid is left out
  EXPECT_EQ(dataset.poses[1].stamp, dataset.frames[2].stamp);
  EXPECT_NEAR(dataset.poses[1].world_from_camera.rotation.z(), std::sqrt(0.5), 1e-12);
  EXPECT_THAT(dataset.warnings, testing::Contains(HasSubstr("1 poses are no rigid motion")));
}

TEST(ImagePoses, OfScanNetHaveAFolderAndColourIsShrunkToDepth) {
  const TemporaryFolder folder;
  for (int i = 0; i < 11; ++i) {
    write_colour(folder.path() / fmt::format("color/{}.png", i), i, {17, 12});
    write_depth(folder.path() / fmt::format("depth/{}.png", i), 1000);
    folder.write(fmt::format("pose/{}.txt", i), matrix(i));
  }
  folder.write("intrinsic/intrinsic_depth.txt", "50 0 3.5 0\n0 50 2.5 0\n0 0 1 0\n0 0 0 1\n");
  const Dataset dataset = open_dataset(folder.path());
  EXPECT_EQ(dataset.layout, "ScanNet");
  EXPECT_THAT(positions(dataset.poses), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  const RgbdImage image = read_frame(dataset, 0);
  EXPECT_EQ(image.bgr.size(), image.depth.size());
  EXPECT_EQ(choose_camera(dataset).camera.pinhole.cx, 3.5);
}

TEST(ImagePoses, CameraOf3dMatchLiesBesideItsSequences) {
  const TemporaryFolder folder;
  write_colour(folder.path() / "seq-01/frame-000000.color.png", 0);
  write_depth(folder.path() / "seq-01/frame-000000.depth.png", 1000);
  folder.write("camera-intrinsics.txt", "58.5 0 3.5\n0 58.5 2.5\n0 0 1\n");
  EXPECT_EQ(choose_camera(open_dataset(folder.path() / "seq-01")).camera.pinhole.fx, 58.5);
}

TEST(ImagePoses, OfReplicaAreLinesAndDepthHasItsScale) {
  const TemporaryFolder folder;
  std::string lines;
  for (int i = 0; i < 4; ++i) {
    write_colour(folder.path() / fmt::format("room0/results/frame{:06}.jpg", i), i);
    write_depth(folder.path() / fmt::format("room0/results/depth{:06}.png", i), 6553);
    lines += matrix(i, " ");
  }
  folder.write("room0/traj.txt", lines);
  folder.write("cam_params.json",
               fmt::format(R"({{"camera": {{"w": {}, "h": {}, "fx": 60, "fy": 60, "cx": 3.5,
                            "cy": 2.5, "scale": 6553.5}}}})",
                           test::kSmallWidth, test::kSmallHeight));
  const Dataset dataset = open_dataset(folder.path() / "room0");
  EXPECT_EQ(dataset.depth_scale.units_per_metre, 6553.5);
  EXPECT_THAT(positions(dataset.poses), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(choose_camera(dataset).camera.pinhole.fx, 60);
}

TEST(ImagePoses, AFileOfOtherNumbersIsSaidAndTheImagesAreReadAllTheSame) {
  const TemporaryFolder folder;
  write_colour(folder.path() / "frame-0.color.png", 0);
  write_depth(folder.path() / "frame-0.depth.png", 1000);
  folder.write("frame-0.pose.txt", "1 2 3");
  const Dataset dataset = open_dataset(folder.path());
  EXPECT_TRUE(dataset.poses.empty());
  EXPECT_THAT(dataset.warnings,
              testing::Contains(testing::HasSubstr("expected a 4 x 4 matrix, got 3 numbers")));
}

}  // namespace
}  // namespace edvo

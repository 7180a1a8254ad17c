// SPDX-License-Identifier: MIT
#include "edvo/io/camera_choice.hpp"

#include "edvo/io/camera_preset.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace edvo {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string preset_name(const char* name) {
  const auto preset = camera_preset(name);
  return preset ? preset->name : "";
}

Dataset dataset_in(const std::filesystem::path& root, const std::string& name) {
  Dataset dataset;
  dataset.name = name;
  dataset.source = dataset.root = root;
  dataset.image_size = {640, 480};
  return dataset;
}

TEST(CameraPreset, IsKnownByTheNamesThatPeopleUse) {
  for (const char* const name : {"rgbd_dataset_freiburg1_xyz", "fr1", "fr1_desk", "tum-FR1-room"})
    EXPECT_EQ(preset_name(name), "TUM freiburg1") << name;
  for (const char* const name : {"rgbd_dataset_freiburg2_desk", "fr2", "tum_fr2_coke"})
    EXPECT_EQ(preset_name(name), "TUM freiburg2") << name;
  for (const char* const name : {"rgbd_dataset_freiburg3_long_office_household", "fr3_office"})
    EXPECT_EQ(preset_name(name), "TUM freiburg3") << name;
  for (const char* const name :
       {"living_room_traj0_frei_png", "living_room_traj2n_frei_png", "office_traj1_frei_png",
        "traj0_frei_png", "icl", "ICL-NUIM", "lr_kt0", "of_kt3", "livingroom_kt1"})
    EXPECT_EQ(preset_name(name), "ICL-NUIM") << name;
}

TEST(CameraPreset, IsNotReadIntoOtherNames) {
  for (const char* const name :
       {"", "desk", "fr4", "fr10_x", "bfr1", "particle", "bicycle", "my_office", "living_room",
        "office0", "proof_kt1", "vehicle_fr3nch", "fr1day"})
    EXPECT_EQ(preset_name(name), "") << name;
}

TEST(CameraPreset, HasThePublishedNumbers) {
  const auto fr1 = camera_preset("fr1");
  EXPECT_EQ(fr1->camera.pinhole.fx, 517.306408);
  EXPECT_EQ(fr1->camera.distortion[4], 1.163314);
  EXPECT_EQ(fr1->depth_scale, 5000);
  EXPECT_FALSE(is_distorted(camera_preset("fr3")->camera));
  EXPECT_EQ(camera_preset("icl")->camera.pinhole.fy, -480);
}

TEST(CameraChoice, PrefersTheGivenFileThenTheFoldersThenThePreset) {
  const test::TemporaryFolder folder;
  const Dataset dataset = dataset_in(folder.path(), "fr2_desk");
  EXPECT_EQ(choose_camera(dataset).camera.pinhole.fx, 520.908620);
  EXPECT_THAT(choose_camera(dataset).source, HasSubstr("TUM freiburg2, 'fr2' in the name"));

  folder.write("calibration.txt", "600 600 320 240\n");
  EXPECT_EQ(choose_camera(dataset).camera.pinhole.fx, 600);
  EXPECT_THAT(choose_camera(dataset).source, HasSubstr("calibration.txt, which is in the folder"));

  const auto given = folder.write("own", "700 700 320 240\n");
  EXPECT_EQ(choose_camera(dataset, {.file = given}).camera.pinhole.fx, 700);
  EXPECT_THAT(choose_camera(dataset, {.file = given}).source, HasSubstr("own, as given"));
}

TEST(CameraChoice, DistortionThatNoLensHasIsWarnedOf) {
  DistortedCamera camera = camera_preset("fr1")->camera;
  EXPECT_THAT(check_intrinsics(camera), IsEmpty());
  camera.distortion = {10, 10, 1, 1, 1};
  EXPECT_THAT(check_intrinsics(camera), ElementsAre(HasSubstr("which no lens does")));
}

TEST(CameraChoice, FindsTheFilesThatRecordersWriteBesideTheFolders) {
  for (const char* const name : {"camera.txt", "intrinsic.txt", "intrinsic/camera.txt",
                                 "intrinsic/intrinsic.txt", "intrinsic/intrinsics.txt"}) {
    const test::TemporaryFolder folder;
    folder.write(name, "600 600 320 240\n");
    EXPECT_EQ(choose_camera(dataset_in(folder.path(), "some")).camera.pinhole.fx, 600) << name;
  }
}

TEST(CameraChoice, KnowsIclNuimByItsGroundTruth) {
  const test::TemporaryFolder folder;
  Dataset dataset = dataset_in(folder.path(), "mine");
  dataset.ground_truth = folder.path() / "livingRoom0.gt.freiburg";
  EXPECT_THAT(choose_camera(dataset).source, HasSubstr("ICL-NUIM, by its file livingRoom0"));
}

TEST(CameraChoice, KnowsALinkByTheNameOfItsTarget) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "rgbd_dataset_freiburg3_x");
  std::filesystem::create_symlink("rgbd_dataset_freiburg3_x", folder.path() / "latest");
  EXPECT_EQ(choose_camera(dataset_in(folder.path() / "latest", "latest")).camera.pinhole.fx, 535.4);
}

TEST(CameraChoice, AnUnknownCameraIsAnErrorThatTellsWhatToDo) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(test::fails_with(ErrorCode::kCalibration,
                               {"not known", "--camera FILE", "fx fy cx cy", "camera.toml", "fr1"},
                               [&] { (void)choose_camera(dataset_in(folder.path(), "mine")); }));
}

TEST(CameraChoice, APresetForImagesOfAnotherSizeIsNotTaken) {
  const test::TemporaryFolder folder;
  Dataset dataset = dataset_in(folder.path(), "fr1_half");
  dataset.image_size = {320, 240};
  EXPECT_TRUE(test::fails_with(ErrorCode::kCalibration,
                               {"TUM freiburg1", "640 x 480", "320 x 240", "--camera"},
                               [&] { (void)choose_camera(dataset); }));
}

TEST(CameraChoice, IntrinsicsOfAnotherSizeAreScaledOnRequest) {
  const test::TemporaryFolder folder;
  Dataset dataset = dataset_in(folder.path(), "fr1_half");
  dataset.image_size = {320, 240};
  const ChosenCamera chosen = choose_camera(dataset, {.size = {640, 480}});
  const Camera& half = chosen.camera.pinhole;
  EXPECT_DOUBLE_EQ(half.fx, 517.306408 / 2);
  EXPECT_DOUBLE_EQ(half.fy, 516.469215 / 2);
  EXPECT_DOUBLE_EQ(half.cx, (318.643040 + 0.5) / 2 - 0.5);
  EXPECT_DOUBLE_EQ(half.cy, (255.313989 + 0.5) / 2 - 0.5);
  EXPECT_EQ(cv::Size(half.width, half.height), dataset.image_size);
  EXPECT_EQ(chosen.camera.distortion[4], 1.163314);
  EXPECT_THAT(chosen.source, HasSubstr("scaled from 640 x 480 px to 320 x 240 px"));
  EXPECT_THAT(chosen.warnings, IsEmpty());
}

// A corner of the image looks at the same ray, whatever its size.
TEST(CameraChoice, ResizingKeepsTheRaysOfTheBorders) {
  const DistortedCamera camera{.pinhole = {517, 516, 318.6, 255.3, 640, 480}};
  const Camera from = camera.pinhole, to = resized(camera, {213, 160}).pinhole;
  EXPECT_NEAR((-0.5 - to.cx) / to.fx, (-0.5 - from.cx) / from.fx, 1e-12);
  EXPECT_NEAR((212.5 - to.cx) / to.fx, (639.5 - from.cx) / from.fx, 1e-12);
  EXPECT_NEAR((-0.5 - to.cy) / to.fy, (-0.5 - from.cy) / from.fy, 1e-12);
  EXPECT_NEAR((159.5 - to.cy) / to.fy, (479.5 - from.cy) / from.fy, 1e-12);
}

TEST(CameraChoice, ScalingToAnotherShapeIsWarnedOf) {
  const test::TemporaryFolder folder;
  Dataset dataset = dataset_in(folder.path(), "mine");
  folder.write("calibration.txt", "600 600 639.5 359.5\n");
  EXPECT_THAT(choose_camera(dataset, {.size = {1280, 720}}).warnings,
              Contains(HasSubstr("another shape")));
}

TEST(CameraChoice, IntrinsicsOfImagesOfAnotherSizeAreWarnedOf) {
  const auto warnings = [](const Camera& pinhole) {
    return check_intrinsics({.pinhole = pinhole});
  };
  EXPECT_THAT(warnings({517, 516, 318.6, 255.3, 640, 480}), IsEmpty());
  EXPECT_THAT(warnings({481.2, -480, 319.5, 239.5, 640, 480}), IsEmpty());
  // Half the size and twice the size.
  EXPECT_THAT(warnings({258.6, 258.2, 159.1, 127.4, 640, 480}),
              Contains(HasSubstr("about 319 x 256 px")));
  EXPECT_THAT(warnings({1034, 1032, 637.8, 511.1, 640, 480}),
              Contains(AllOf(HasSubstr("off the middle"), HasSubstr("--camera-size"))));
  // 640 / 2 / tan(10 degrees) and / tan(70 degrees).
  EXPECT_THAT(warnings({1815, 1815, 319.5, 239.5, 640, 480}), ElementsAre(HasSubstr("20 degrees")));
  EXPECT_THAT(warnings({116.5, 116.5, 319.5, 239.5, 640, 480}),
              ElementsAre(HasSubstr("140 degrees")));
}

TEST(CameraChoice, WideFisheyesAreNotWarnedOf) {
  EXPECT_THAT(check_intrinsics(
                  {.pinhole = {250, 250, 319.5, 239.5, 640, 480}, .lens = LensModel::kEquidistant}),
              IsEmpty());
}

}  // namespace
}  // namespace edvo

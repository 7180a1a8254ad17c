// SPDX-License-Identifier: MIT
#include "edvo/io/camera_file.hpp"

#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

namespace edvo {
namespace {

using test::fails_with;
using test::TemporaryFolder;
using testing::ElementsAre;

const cv::Size kVga{640, 480};

DistortedCamera read(const std::string& text, cv::Size size = kVga) {
  const TemporaryFolder folder;
  return read_camera(folder.write("camera", text), size);
}

testing::AssertionResult refuses(std::initializer_list<std::string> parts, const std::string& text,
                                 cv::Size size = kVga) {
  return fails_with(ErrorCode::kCalibration, parts, [&] { (void)read(text, size); });
}

// The camera that the examples below all describe.
void expect_example(const DistortedCamera& camera) {
  EXPECT_EQ(camera.pinhole.fx, 517.3);
  EXPECT_EQ(camera.pinhole.fy, 516.5);
  EXPECT_EQ(camera.pinhole.cx, 318.6);
  EXPECT_EQ(camera.pinhole.cy, 255.3);
  EXPECT_EQ(camera.pinhole.width, 640);
  EXPECT_EQ(camera.pinhole.height, 480);
  EXPECT_THAT(distortion_coefficients(camera), ElementsAre(0.26, -0.95, -0.005, 0.002, 1.16));
}

constexpr const char* kToml =
    "# a comment\nfx = 517.3\nfy = 516.5\ncx = 318.6\ncy = 255.3\n"
    "distortion = [0.26, -0.95, -0.005, 0.002, 1.16]\n";

constexpr const char* kOpenCv =
    "%YAML:1.0\n---\ncalibration_time: \"Mon 01 Jan 2024\"\nimage_width: 640\nimage_height: 480\n"
    "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 5.1730000000000001e+02, 0., 3.186e+02, 0.,\n       516.5, 255.3, 0., 0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n"
    "   data: [ 0.26, -0.95, -0.005, 0.002, 1.16 ]\n";

constexpr const char* kRos =
    "image_width: 640\nimage_height: 480\ncamera_name: kinect\ncamera_matrix:\n  rows: 3\n"
    "  cols: 3\n  data: [517.3, 0, 318.6, 0, 516.5, 255.3, 0, 0, 1]\n"
    "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n"
    "  data: [0.26, -0.95, -0.005, 0.002, 1.16]\nrectification_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";

constexpr const char* kRosEcho =
    "header:\n  seq: 1\n  frame_id: \"cam\"\nheight: 480\nwidth: 640\n"
    "distortion_model: \"plumb_bob\"\nD: [0.26, -0.95, -0.005, 0.002, 1.16]\n"
    "K: [517.3, 0.0, 318.6, 0.0, 516.5, 255.3, 0.0, 0.0, 1.0]\n---\nheader:\n  seq: 2\n";

constexpr const char* kKalibr =
    "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n"
    "  distortion_coeffs: [0.26, -0.95, -0.005, 0.002]\n  distortion_model: radtan\n"
    "  intrinsics: [517.3, 516.5, 318.6, 255.3]\n  resolution: [640, 480]\n  rostopic: /cam0\n"
    "cam1:\n  camera_model: omni\n";

TEST(CameraFile, ReadsEveryFormatByItsContent) {
  expect_example(read(kToml));
  expect_example(read(kOpenCv));
  expect_example(read(kRos));
  expect_example(read(kRosEcho));
  expect_example(read("517.3 516.5 318.6 255.3 0.26 -0.95 -0.005 0.002 1.16\n"));
  expect_example(read("# fx fy cx cy\r\n517.3, +516.5, 318.6, 255.3\r\n.26 -.95 -5e-3 2e-3 1.16"));
  expect_example(read("\xef\xbb\xbf" + std::string(kToml)));
  expect_example(
      read("%YAML:1.0\n\nCamera.type: \"PinHole\"\nCamera.fx: 517.3\nCamera.fy: 516.5\n"
           "Camera.cx: 318.6\nCamera.cy: 255.3\nCamera.k1: 0.26\nCamera.k2: -0.95\n"
           "Camera.p1: -0.005\nCamera.p2: 0.002\nCamera.k3: 1.16\nCamera.width: 640\n"
           "Camera.height: 480\nDepthMapFactor: 5000.0\n"));
}

TEST(CameraFile, ReadsTheFirstCameraOfAKalibrChain) {
  const DistortedCamera camera = read(kKalibr);
  EXPECT_EQ(camera.pinhole.fx, 517.3);
  EXPECT_EQ(camera.pinhole.cy, 255.3);
  EXPECT_THAT(distortion_coefficients(camera), ElementsAre(0.26, -0.95, -0.005, 0.002, 0));
}

TEST(CameraFile, ReadsAMatrixOfNumbers) {
  const DistortedCamera camera = read("585 0 320\n0 586 240\n0 0 1\n");
  EXPECT_EQ(camera.pinhole.fx, 585);
  EXPECT_EQ(camera.pinhole.fy, 586);
  EXPECT_EQ(camera.pinhole.cx, 320);
  EXPECT_EQ(camera.pinhole.cy, 240);
}

TEST(CameraFile, ReadsSixNumbersWithTheSizeOfTheImagesLast) {
  const DistortedCamera camera = read("605.9 604.9 318.2 236.5 640 480\n");
  EXPECT_EQ(camera.pinhole.fy, 604.9);
  EXPECT_EQ(camera.pinhole.cy, 236.5);
  EXPECT_FALSE(is_distorted(camera));
  EXPECT_EQ(read("605.9 604.9 318.2 236.5 640 480", {}).pinhole.width, 640);
  EXPECT_TRUE(refuses({"320 x 240"}, "262.5 262.5 159.5 119.5 320 240\n"));
  EXPECT_TRUE(refuses({"0.1 x 0.2", "no size"}, "605.9 604.9 318.2 236.5 0.1 0.2\n"));
}

TEST(CameraFile, ReadsTheDistortionOfJson) {
  const std::string start = R"({"fx": 517.3, "fy": 516.5, "ppx": 318.6, "ppy": 255.3, )";
  const std::string coeffs = R"("coeffs": [0.26, -0.95, -0.005, 0.002, 1.16])";
  expect_example(read(start + coeffs + R"(, "model": "Brown Conrady"})"));
  expect_example(read(start + coeffs + R"(, "model": "distortion.brown_conrady"})"));
  expect_example(read(start + coeffs + "}"));
  expect_example(
      read(start + R"("k1": 0.26, "k2": -0.95, "p1": -0.005, "p2": 0.002, "k3": 1.16})"));
  EXPECT_TRUE(refuses({"model", "Inverse Brown Conrady", "brown_conrady"},
                      start + coeffs + R"(, "model": "Inverse Brown Conrady"})"));
  EXPECT_TRUE(refuses({"coeffs", "array"}, start + R"("coeffs": 1})"));
  EXPECT_FALSE(is_distorted(
      read(start + R"("coeffs": [0, 0, 0, 0, 0], "model": "Inverse Brown Conrady"})")));
}

TEST(CameraFile, ANegativeFyIsKept) {
  EXPECT_EQ(read("481.2 -480 319.5 239.5").pinhole.fy, -480);
}

TEST(CameraFile, TomlGivesTheSameCameraBack) {
  const DistortedCamera camera{.pinhole = {517.306408, -480.1 / 3, 1.0 / 3, 239.5, 640, 480},
                               .distortion = {0.1 + 0.2, 1e-17, -0.953104, 0, 1e5}};
  const DistortedCamera back = read(camera_to_toml(camera), {});
  EXPECT_EQ(back.pinhole.fx, camera.pinhole.fx);
  EXPECT_EQ(back.pinhole.fy, camera.pinhole.fy);
  EXPECT_EQ(back.pinhole.cx, camera.pinhole.cx);
  EXPECT_EQ(back.pinhole.cy, camera.pinhole.cy);
  EXPECT_EQ(back.pinhole.width, 640);
  EXPECT_EQ(back.pinhole.height, 480);
  EXPECT_EQ(back.distortion, camera.distortion);
}

TEST(CameraFile, AnotherImageSizeIsRefusedWithBoth) {
  EXPECT_TRUE(refuses({"640 x 480", "320 x 240"}, kOpenCv, {320, 240}));
  EXPECT_TRUE(refuses({"640 x 480", "320 x 240"}, kKalibr, {320, 240}));
}

std::optional<StatedDepthScale> depth_scale_of(const std::string& text) {
  const TemporaryFolder folder;
  return stated_depth_scale(folder.write("camera", text));
}

TEST(CameraFile, MayStateTheDepthScale) {
  const auto states = [](const std::string& text, double units, const std::string& key) {
    const auto stated = depth_scale_of(text);
    ASSERT_TRUE(stated) << text;
    EXPECT_EQ(stated->units_per_metre, units);
    EXPECT_EQ(stated->key, key);
  };
  const std::string orb_slam = "fx: 517.3\nfy: 516.5\ncx: 318.6\ncy: 255.3\n";
  states("%YAML:1.0\n" + orb_slam + "DepthMapFactor: 1000.0\n", 1000, "DepthMapFactor");
  states("%YAML:1.0\n" + orb_slam + "RGBD.DepthMapFactor: 5208.\n", 5208, "RGBD.DepthMapFactor");
  states(std::string(kRos) + "depth_scale: 6553.5\n", 6553.5, "depth_scale");
  states(std::string(kKalibr) + "depth_scale: 1000\n", 1000, "depth_scale");
  states(std::string(kToml) + "depth_scale = 256\n", 256, "depth_scale");
  expect_example(read(std::string(kToml) + "depth_scale = 256\n"));
}

TEST(CameraFile, NiceSlamStatesTheDepthScaleAsScale) {
  const auto stated = depth_scale_of(
      "{\"camera\": {\"w\": 1200, \"h\": 680, \"fx\": 600.0, \"fy\": 600.0, \"cx\": 599.5,"
      " \"cy\": 339.5, \"scale\": 6553.5}}");
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->units_per_metre, 6553.5);
}

TEST(CameraFile, NeedNotStateTheDepthScale) {
  EXPECT_FALSE(depth_scale_of(kToml));
  EXPECT_FALSE(depth_scale_of(kOpenCv));
  EXPECT_FALSE(depth_scale_of("517 517 320 240\n"));
  EXPECT_FALSE(depth_scale_of("not a camera\n"));
}

TEST(CameraFile, ADepthScaleThatIsNoneIsRefused) {
  for (const char* const bad : {"0", "-1000", "nan", "inf"})
    EXPECT_TRUE(fails_with(ErrorCode::kCalibration, {"depth_scale = ", "units per metre"}, [&] {
      (void)depth_scale_of(std::string(kToml) + "depth_scale = " + bad + "\n");
    }));
}

TEST(CameraFile, ASizeThatIsNoneIsRefusedInEveryFormat) {
  for (const char* const size :
       {"[-1e300, .nan]", "[640.5, 480]", "[0, 480]", "[.inf, .inf]", "[1e300, 1e300]"})
    EXPECT_TRUE(refuses({"is no size in pixels"},
                        "cam0:\n  intrinsics: [517.3, 516.5, 318.6, 255.3]\n  resolution: " +
                            std::string(size) + "\n",
                        {}))
        << size;
  EXPECT_TRUE(refuses({"is no size in pixels"},
                      "K: [517.3, 0, 318.6, 0, 516.5, 255.3, 0, 0, 1]\nwidth: .nan\nheight: -1\n",
                      {}));
}

TEST(CameraFile, SomeoneMustSayTheImageSize) {
  EXPECT_EQ(read(kOpenCv, {}).pinhole.width, 640);
  EXPECT_TRUE(refuses({"size of the images"}, kToml, {}));
}

TEST(CameraFile, OtherModelsAreRefusedByName) {
  EXPECT_TRUE(refuses({"camera model 'omni'"},
                      "cam0:\n  camera_model: omni\n  intrinsics: [1, 517, 517, 320, 240]\n"));
  EXPECT_TRUE(refuses({"distortion model 'fov'", "radtan", "equidistant"},
                      "cam0:\n  camera_model: pinhole\n  distortion_model: fov\n"
                      "  intrinsics: [517, 517, 320, 240]\n"));
  EXPECT_TRUE(refuses({"distortion model 'thin_prism'", "plumb_bob"},
                      "distortion_model: thin_prism\nK: [517, 0, 320, 0, 517, 240, 0, 0, 1]\n"));
  EXPECT_TRUE(refuses({"camera type 'Sphere'"}, "Camera.type: Sphere\nCamera.fx: 517\n"));
  EXPECT_TRUE(refuses({"camera:5: distortion_model must be one of plumb_bob"},
                      "fx = 517\nfy = 517\ncx = 320\ncy = 240\ndistortion_model = \"fov\"\n"));
}

constexpr const char* kMatrix = "K: [517, 0, 320, 0, 517, 240, 0, 0, 1]\n";

TEST(CameraFile, ReadsTheRationalPolynomialOfEightCoefficients) {
  const auto is_rational = [](const std::string& text) {
    const DistortedCamera camera = read(text);
    EXPECT_EQ(distortion_model(camera), "rational_polynomial") << text;
    EXPECT_THAT(distortion_coefficients(camera),
                ElementsAre(0.5, -2.6, 0.0005, -0.0002, 1.5, 0.4, -2.4, 1.4))
        << text;
  };
  const std::string eight = "[0.5, -2.6, 0.0005, -0.0002, 1.5, 0.4, -2.4, 1.4]\n";
  is_rational(kMatrix + ("distortion_model: rational_polynomial\nD: " + eight));
  is_rational(kMatrix + ("distortion_coefficients: " + eight));
  is_rational("fx = 517\nfy = 517\ncx = 320\ncy = 240\ndistortion = " + eight);
  is_rational("517 517 320 240 0.5 -2.6 0.0005 -0.0002 1.5 0.4 -2.4 1.4\n");
  is_rational(camera_to_toml(read(kMatrix + ("D: " + eight))));
}

TEST(CameraFile, ReadsEquidistantLensesOfEveryFormat) {
  const auto is_equidistant = [](const std::string& text) {
    const DistortedCamera camera = read(text);
    EXPECT_EQ(camera.pinhole.fx, 517) << text;
    EXPECT_EQ(distortion_model(camera), "equidistant") << text;
    EXPECT_THAT(distortion_coefficients(camera), ElementsAre(-0.02, 0.01, -0.003, 0.5)) << text;
  };
  const std::string four = "[-0.02, 0.01, -0.003, 0.5]\n";
  const std::string ros = kMatrix + ("distortion_model: equidistant\nD: " + four);
  is_equidistant(ros);
  is_equidistant(kMatrix + ("distortion_model: fisheye\nD: " + four));
  is_equidistant(kMatrix + ("fisheye_model: 1\ndistortion_coefficients: " + four));
  is_equidistant(
      "cam0:\n  camera_model: pinhole\n  distortion_model: equidistant\n"
      "  intrinsics: [517, 517, 320, 240]\n  distortion_coeffs: " +
      four);
  const std::string orb_slam =
      "Camera1.fx: 517\nCamera1.fy: 517\nCamera1.cx: 320\nCamera1.cy: 240\nCamera1.k1: -0.02\n"
      "Camera1.k2: 0.01\nCamera1.k3: -0.003\nCamera1.k4: 0.5\n";
  is_equidistant("%YAML:1.0\nCamera.type: \"KannalaBrandt8\"\n" + orb_slam);
  is_equidistant(
      "fx = 517\nfy = 517\ncx = 320\ncy = 240\n"
      "distortion_model = \"equidistant\"\ndistortion = " +
      four);
  is_equidistant(camera_to_toml(read(ros)));
}

TEST(CameraFile, MoreCoefficientsThanTheModelHasMustBeZero) {
  const std::string matrix = kMatrix;
  EXPECT_EQ(read(matrix + "D: [0.1, 0, 0, 0, 0.5, 0, 0, 0, 0, 0, 0, 0]\n").distortion[4], 0.5);
  EXPECT_TRUE(refuses({"k1 k2 p1 p2"}, matrix + "D: [0.1, 0, 0, 0, 0, 0, 0, 0, 0.1, 0, 0, 0]\n"));
  EXPECT_TRUE(refuses({"k1 k2 p1 p2"}, matrix + "D: [0.1]\n"));
}

TEST(CameraFile, AnEquidistantLensOfEightCoefficientsIsReadByItsFirstFourAndWarnedOf) {
  const TemporaryFolder folder;
  const std::string lens = kMatrix + std::string("distortion_model: equidistant\n");
  const auto eight = folder.write("eight", lens + "D: [0.5, -2.6, 0.01, 0.02, 1.5, 0.4, -2, 1]\n");
  EXPECT_THAT(distortion_coefficients(read_camera(eight, kVga)),
              ElementsAre(0.5, -2.6, 0.01, 0.02));
  const auto warning = camera_file_warning(eight);
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning, testing::HasSubstr("rational_polynomial"));
  const auto zeros = folder.write("zeros", lens + "D: [0.5, -2.6, 0.01, 0.02, 0]\n");
  EXPECT_FALSE(camera_file_warning(zeros));
}

TEST(CameraFile, NumbersThatCannotBeRightAreRefusedByName) {
  EXPECT_TRUE(refuses({"fx = 0"}, "0 517 320 240"));
  EXPECT_TRUE(refuses({"fx = -517"}, "-517 517 320 240"));
  EXPECT_TRUE(refuses({"fy = 0"}, "517 0 320 240"));
  EXPECT_TRUE(refuses({"fx = 0.8", "focal length in pixels"}, "0.8 0.8 0.5 0.5"));
  EXPECT_TRUE(refuses({"fx = nan"}, "nan 517 320 240"));
  EXPECT_TRUE(refuses({"fy = inf"}, "517 inf 320 240"));
  EXPECT_TRUE(refuses({"cx = 1200", "640 x 480"}, "517 517 1200 240"));
  EXPECT_TRUE(refuses({"cy = -400"}, "517 517 320 -400"));
  EXPECT_TRUE(refuses({"distortion coefficient = nan"}, "517 517 320 240 0 nan 0 0"));
  EXPECT_TRUE(refuses({"fx = nan"}, "K: [.nan, 0, 320, 0, 517, 240, 0, 0, 1]\n"));
}

TEST(CameraFile, AMatrixOfAnotherFormIsRefused) {
  EXPECT_TRUE(refuses({"has 4 numbers"}, "K: [517, 517, 320, 240]\n"));
  EXPECT_TRUE(refuses({"not of the form"}, "K: [517, 3, 320, 0, 517, 240, 0, 0, 1]\n"));
  EXPECT_TRUE(refuses({"4, 6, 8, 9, 12 or 16 numbers, got 3"}, "517 320 240"));
}

TEST(CameraFile, TomlErrorsNameLineAndKey) {
  EXPECT_TRUE(refuses({"fy is missing"}, "fx = 517.3\ncx = 1\ncy = 1\n"));
  EXPECT_TRUE(refuses({"camera:2: ", "'fz'"}, "fx = 517\nfz = 1\nfy = 517\ncx = 320\ncy = 240\n"));
  EXPECT_TRUE(refuses({"camera:1: fx must be a number"}, "fx = \"517\"\nfy = 517\n"));
  EXPECT_TRUE(refuses({"camera:2: "}, "fx = 517\nfy = = 3\n"));
  EXPECT_TRUE(refuses({"width = 640.5"}, std::string(kToml) + "width = 640.5\nheight = 480\n"));
  EXPECT_TRUE(refuses({"distortion must be"}, "fx=517\nfy=517\ncx=320\ncy=240\ndistortion=1\n"));
}

TEST(CameraFile, WhatIsNoCalibrationIsRefused) {
  EXPECT_TRUE(refuses({"empty"}, ""));
  EXPECT_TRUE(refuses({"empty"}, "# nothing\n\n"));
  EXPECT_TRUE(refuses({"XML"}, "<?xml version=\"1.0\"?>\n<opencv_storage>\n"));
  EXPECT_TRUE(refuses({"no camera found"}, "hello\n"));
  EXPECT_TRUE(refuses({"no camera found"}, "a: 1\n"));
  EXPECT_TRUE(refuses({"no camera found"}, std::string("\0\x01\x02", 3)));
  EXPECT_TRUE(refuses({"camera:2"}, "K: [1, 2\nD: ]\n"));
  EXPECT_TRUE(refuses({"camera"}, std::string(100'000, '[')));
  EXPECT_TRUE(refuses({"line 2", "list of numbers"}, "width: 640\nK: 3\n"));
  EXPECT_TRUE(refuses({"camera:1"}, "K: [a, 0, 320, 0, 517, 240, 0, 0, 1]\n"));
  EXPECT_TRUE(refuses({"Camera.fy is missing"}, "Camera.fx: 517\n"));
  EXPECT_TRUE(fails_with(ErrorCode::kCalibration, {"/nowhere/camera.toml: no such file"},
                         [] { (void)read_camera("/nowhere/camera.toml", kVga); }));
}

}  // namespace
}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/align/image_shift.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

TEST(Turn, IsFoundFromAShiftThatGradientsDoNotTell) {
  const Camera camera{.fx = 32, .fy = 32, .cx = 19.5, .cy = 14.5, .width = 40, .height = 30};
  cv::Mat_<std::uint8_t> wide(60, 80);
  cv::RNG random(3);
  random.fill(wide, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat_<std::uint8_t> before = wide(cv::Rect(20, 15, 40, 30));
  const cv::Mat_<std::uint8_t> now = wide(cv::Rect(20 - 9, 15 + 5, 40, 30));  // all moves (9, -5)
  PhaseCorrelation correlation;
  correlation.set_reference(before);
  const SE3 turn = rotation_from_image_shift(correlation.shift_to(now), camera);
  const Eigen::Vector3d moved = turn * Eigen::Vector3d(0, 0, 1);
  EXPECT_NEAR(moved.x() / moved.z() * camera.fx, 9, 1);
  EXPECT_NEAR(moved.y() / moved.z() * camera.fy, -5, 1);
}

TEST(Turn, IsNoneBetweenBlankImages) {
  const cv::Mat_<std::uint8_t> blank(30, 40, std::uint8_t{90});
  PhaseCorrelation correlation;
  correlation.set_reference(blank);
  EXPECT_LT(cv::norm(correlation.shift_to(blank)), 1e-6);
}

TEST(Turn, ShiftsAreThoseOfOpenCv) {
  cv::Mat_<std::uint8_t> scene(120, 160);
  cv::RNG random(5);
  random.fill(scene, cv::RNG::UNIFORM, 0, 256);
  for (const cv::Size size : {cv::Size(40, 30), cv::Size(62, 46)}) {
    PhaseCorrelation correlation;
    cv::Mat before, window;
    cv::createHanningWindow(window, size, CV_32F);
    for (int i = 0; i < 4; ++i) {
      const cv::Mat_<std::uint8_t> image = scene(cv::Rect({20 + 3 * i, 30 - 2 * i * i}, size));
      cv::Mat now;
      image.convertTo(now, CV_32F);
      const cv::Point2d shift = correlation.shift_to(image);
      const cv::Point2d expected =
          i == 0 ? cv::Point2d() : cv::phaseCorrelate(before, now.clone(), window);
      EXPECT_LT(cv::norm(shift - expected), 1e-4) << size << ' ' << i;
      image.convertTo(before, CV_32F);
      correlation.set_reference(image);
    }
  }
}

TEST(Turn, AnImageThatWasOnlyAskedAboutChangesNothing) {
  cv::Mat_<std::uint8_t> scene(120, 160);
  cv::RNG random(5);
  random.fill(scene, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat_<std::uint8_t> now = scene(cv::Rect(26, 33, 40, 30));
  PhaseCorrelation correlation;
  correlation.set_reference(scene(cv::Rect(20, 30, 40, 30)));
  const cv::Point2d shift = correlation.shift_to(now);
  (void)correlation.shift_to(cv::Mat_<std::uint8_t>(30, 40, std::uint8_t{0}));
  EXPECT_EQ(correlation.shift_to(now), shift);
}

TEST(Turn, ShiftsAreRightInImagesOfOddSize) {  // where OpenCV's are half a pixel off
  cv::Mat_<std::uint8_t> scene(120, 160);
  cv::RNG random(5);
  random.fill(scene, cv::RNG::UNIFORM, 0, 256);
  PhaseCorrelation correlation;
  correlation.set_reference(scene(cv::Rect(20, 30, 75, 45)));
  const cv::Point2d shift = correlation.shift_to(scene(cv::Rect(17, 32, 75, 45)));
  EXPECT_LT(cv::norm(shift - cv::Point2d(3, -2)), 0.3);
}

}  // namespace
}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/align/local_correlation.hpp"

#include "support/matchers.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::kVgaCamera;
using test::motion;
using test::plane_frame;

const SE3 kMoved = motion(0.1, 0.02, -0.15, 0.01, -0.01, 0.02);

double fit(const Frame& key, const Frame& frame, const Alignment& alignment) {
  AlignScratch scratch;
  return local_correlation(make_reference(key, test::grid_pixels(key, 7), {}), frame, 0, alignment,
                           scratch);
}

TEST(LocalCorrelation, OfTheTrueMotionIsNearlyOneAndOfAnotherMuchLess) {
  EXPECT_GT(fit(plane_frame({}), plane_frame(kMoved), {.cur_from_ref = inverse(kMoved)}), 0.95);
  const SE3 off = motion(0.2, 0.2, 0, 0, 0, 0) * inverse(kMoved);
  EXPECT_LT(fit(plane_frame({}), plane_frame(kMoved), {.cur_from_ref = off}), 0.4);
}

TEST(LocalCorrelation, DoesNotDependOnContrastAndBrightness) {
  RgbdImage image = test::render_plane(test::kPlane, kVgaCamera, kMoved);
  image.bgr.convertTo(image.bgr, -1, 0.5, 20);
  const Frame dull = make_frame(image, make_undistortion({kVgaCamera, {}}));
  const Alignment right{.cur_from_ref = inverse(kMoved)};
  EXPECT_NEAR(fit(plane_frame({}), dull, right), fit(plane_frame({}), plane_frame(kMoved), right),
              0.03);
}

// One half is bright and one is dark: all points at once correlate by any motion.
TEST(LocalCorrelation, IsNotRaisedByAPartThatIsBrighter) {
  const SE3 off = motion(0.2, 0.2, 0, 0, 0, 0);
  const auto seen = [](const SE3& pose, double brighter) {
    RgbdImage image = test::render_plane(test::kPlane, kVgaCamera, pose);
    image.bgr.convertTo(image.bgr, -1, 0.4);
    image.bgr.colRange(0, image.bgr.cols / 2) += cv::Scalar::all(brighter);
    return make_frame(image, make_undistortion({kVgaCamera, {}}));
  };
  EXPECT_NEAR(fit(seen({}, 120), seen(off, 120), {}), fit(seen({}, 0), seen(off, 0), {}), 0.1);
}

TEST(LocalCorrelation, IsOneWhereNothingHasTexture) {
  RgbdImage image = test::render_plane(test::kPlane, kVgaCamera, {});
  image.bgr.setTo(cv::Scalar::all(128));
  const Frame flat = make_frame(image, make_undistortion({kVgaCamera, {}}));
  EXPECT_EQ(fit(flat, flat, {}), 1);
}

}  // namespace
}  // namespace edvo

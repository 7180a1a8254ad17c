// SPDX-License-Identifier: MIT
#include "edvo/odometry/loss_test.hpp"

#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace edvo {
namespace {

const TrackingState kState{.stamp = stamp_from_seconds(1.0), .usual_sigma = 8};
const Stamp kNow = stamp_from_seconds(1.033);

AlignResult result(double sigma, double correlation) {
  AlignResult all;
  all.status = AlignStatus::kTracked;
  all.overlap = all.inlier_ratio = 1;
  all.sigma = sigma;
  all.correlation = correlation;
  return all;
}

LossCause cause_of(const AlignResult& all) {
  return loss_cause(all, {}, kState, kNow);
}

TEST(LossCause, IsNoneForAFrameThatFitsAsUsual) {
  EXPECT_EQ(cause_of(result(9, 0.95)), LossCause::kNone);
}

TEST(LossCause, GrownResidualsOfImagesThatCorrelateAreNoLoss) {
  EXPECT_EQ(cause_of(result(40, 0.97)), LossCause::kNone);  // the first motion after a long rest
  EXPECT_EQ(cause_of(result(9, 0.6)), LossCause::kNone);    // noise as strong as always
}

TEST(LossCause, GrownResidualsOfImagesThatDoNotCorrelateAreALoss) {
  EXPECT_EQ(cause_of(result(24, 0.6)), LossCause::kResiduals);
  EXPECT_EQ(cause_of(result(40, 0.85)), LossCause::kResiduals);
}

TEST(LossCause, NamesWhatIsTooSmall) {
  AlignResult all = result(8, 0.95);
  all.overlap = 0.1;
  EXPECT_EQ(cause_of(all), LossCause::kOverlap);
  all = result(8, 0.95);
  all.inlier_ratio = 0.1;
  EXPECT_EQ(cause_of(all), LossCause::kOutliers);
  EXPECT_EQ(cause_of(result(8, 0.1)), LossCause::kUnlike);
  EXPECT_EQ(cause_of(result(8, std::numeric_limits<double>::quiet_NaN())), LossCause::kUnlike);
}

TEST(LossCause, AMotionFasterThanAnyCameraIsALoss) {
  AlignResult all = result(8, 0.95);
  all.alignment.cur_from_ref.translation.x() = 0.5;  // in 33 ms
  EXPECT_EQ(cause_of(all), LossCause::kTooFast);
  EXPECT_EQ(loss_cause(all, {}, kState, stamp_from_seconds(1.2)), LossCause::kNone);
}

TEST(IsUnlike, AsksForLittleWhereOnlyPartsAreHiddenAndForMoreWhereNothingCorrelates) {
  EXPECT_FALSE(is_unlike(result(40, 0.95), 0.2, kState));  // what is not hidden correlates
  EXPECT_TRUE(is_unlike(result(40, 0.8), 0.2, kState));
  EXPECT_FALSE(is_unlike(result(40, 0.8), 0.4, kState));
  EXPECT_TRUE(is_unlike(result(40, 0.6), 0.4, kState));
  EXPECT_FALSE(is_unlike(result(40, 0.6), 0.6, kState));
}

TEST(IsUnlike, AsksForMoreOfTheFirstMotionOfASegment) {
  const TrackingState first{.stamp = stamp_from_seconds(1.0)};
  EXPECT_FALSE(is_unlike(result(18, 0.85), 0.7, first));
  EXPECT_FALSE(is_unlike(result(25, 0.93), 0.7, first));
  EXPECT_TRUE(is_unlike(result(25, 0.85), 0.7, first));
  EXPECT_FALSE(is_unlike(result(25, 0.85), 0.7, kState));
}

TEST(LocalFit, IsAskedForOnlyWhereResidualsAreLarge) {
  const Frame key = test::plane_frame({}), far = test::plane_frame(test::motion(3, 0, 0, 0, 0, 0));
  const Reference reference = make_reference(key, test::grid_pixels(key, 7), {});
  AlignScratch scratch;
  EXPECT_EQ(local_fit(result(8, 0.9), reference, far, {}, scratch), 1);
  EXPECT_LT(local_fit(result(30, 0.9), reference, far, {}, scratch), 0.5);
}

TEST(ImageFault, NamesWhatAnImageLacks) {
  const Frame whole = test::plane_frame({});
  const SelectOptions options{.min_gradient = 0};
  EXPECT_EQ(image_fault(whole, options), LossCause::kNone);
  Frame deep = whole;
  deep.depth = cv::Mat_<float>(whole.depth.size(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(image_fault(deep, options), LossCause::kNoDepth);
  Frame blank = whole;
  blank.levels.front().gray =
      cv::Mat_<std::uint8_t>(whole.levels.front().gray.size(), std::uint8_t{90});
  EXPECT_EQ(image_fault(blank, {}), LossCause::kNoTexture);
}

}  // namespace
}  // namespace edvo

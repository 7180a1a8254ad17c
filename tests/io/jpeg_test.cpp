// SPDX-License-Identifier: MIT
#include "edvo/io/jpeg.hpp"

#include "edvo/io/image_file.hpp"
#include "edvo/io/output_file.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace edvo {
namespace {

cv::Mat_<cv::Vec3b> decoded(const std::string& bytes) {
  const test::TemporaryFolder folder;
  write_whole(folder.path() / "image.jpg", bytes);
  return read_colour(folder.path() / "image.jpg");
}

TEST(EncodeJpeg, KeepsTheColoursOfASmoothImage) {
  cv::Mat_<cv::Vec3b> image(48, 64);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image(y, x) = {static_cast<uchar>(2 * x), static_cast<uchar>(3 * y), 90};
  const cv::Mat_<cv::Vec3b> back = decoded(encode_jpeg(image, 90));
  ASSERT_EQ(back.size(), image.size());
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(back(y, x)[c], image(y, x)[c], 12) << x << ' ' << y;
}

TEST(EncodeJpeg, TakesAPartOfALargerGrayImage) {
  cv::Mat_<uchar> image(40, 40, uchar{0});
  cv::Mat part = image(cv::Rect(8, 8, 24, 16));
  part.setTo(200);
  const cv::Mat_<cv::Vec3b> back = decoded(encode_jpeg(part, 90));
  ASSERT_EQ(back.size(), cv::Size(24, 16));
  EXPECT_NEAR(back(15, 23)[0], 200, 3);
}

TEST(EncodeJpeg, RefusesOtherImages) {
  EXPECT_TRUE(test::fails_with(ErrorCode::kInternal, {"8 bit"},
                               [] { (void)encode_jpeg(cv::Mat(4, 4, CV_32F), 90); }));
  EXPECT_TRUE(test::fails_with(ErrorCode::kInternal, {"8 bit"}, [] { (void)encode_jpeg({}, 90); }));
}

}  // namespace
}  // namespace edvo

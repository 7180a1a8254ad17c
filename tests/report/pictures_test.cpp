// SPDX-License-Identifier: MIT
#include "edvo/report/pictures.hpp"

#include "edvo/io/image_file.hpp"
#include "edvo/io/output_file.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;

const cv::Mat kImage(48, 64, CV_8UC3, cv::Scalar(10, 20, 30));

FrameResult tracked(std::int64_t index, double rms) {
  return {.index = index, .status = FrameStatus::kTracked, .rms = rms};
}

FrameResult lost(std::int64_t index) {
  return {.index = index, .status = FrameStatus::kLost};
}

TEST(PictureCandidates, KeepTheLargestResidualOfARunOfAnyLengthInBoundedMemory) {
  PictureCandidates pictures;
  constexpr std::int64_t kFrames = 5000;
  for (std::int64_t i = 0; i < kFrames; ++i)
    pictures.offer(tracked(i, i == 1234 ? 9.0 : 4.0), kImage);
  EXPECT_THAT(pictures.frames(), Contains(1234));
  EXPECT_LE(pictures.frames().size(), 70u);
  EXPECT_GE(pictures.frames().size(), 30u);
}

TEST(PictureCandidates, KeepTheFirstFramesOfTheLongestLosses) {
  PictureCandidates pictures;
  std::int64_t index = 0;
  for (std::int64_t length = 1; length <= 9; ++length) {
    for (std::int64_t i = 0; i < length; ++i) pictures.offer(lost(index++), kImage);
    pictures.offer(tracked(index++, 4), kImage);
  }
  // The loss of nine frames begins 9 + 1 before the end, that of five after 2 + 3 + 4 + 5 frames.
  EXPECT_THAT(pictures.frames(), Contains(index - 10));
  EXPECT_THAT(pictures.frames(), Contains(14));
  EXPECT_THAT(pictures.frames(), Not(Contains(0)));
}

TEST(PictureCandidates, AreSmallJpegs) {
  PictureCandidates pictures;
  pictures.offer(tracked(7, 4), cv::Mat(480, 640, CV_8UC3, cv::Scalar(40, 80, 160)));
  const std::string jpeg = pictures.jpeg_of(7);
  EXPECT_LT(jpeg.size(), 20'000u);
  const test::TemporaryFolder folder;
  write_whole(folder.path() / "7.jpg", jpeg);
  const cv::Mat_<cv::Vec3b> image = read_colour(folder.path() / "7.jpg");
  EXPECT_EQ(image.size(), cv::Size(320, 240));
  EXPECT_NEAR(image(100, 100)[2], 160, 4);
}

TEST(PictureCandidates, PassOverFramesWithoutAnImage) {
  PictureCandidates pictures;
  pictures.offer(tracked(0, 4), {});
  pictures.offer(lost(1), {});
  EXPECT_THAT(pictures.frames(), IsEmpty());
  EXPECT_THAT(pictures.jpeg_of(0), IsEmpty());
}

}  // namespace
}  // namespace edvo

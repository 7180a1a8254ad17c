// SPDX-License-Identifier: MIT
// Reading of a whole real sequence (TUM fr1/xyz; colour as JPEG, depth as 16-bit PNG).
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/dataset.hpp"
#include "edvo/source/folder_source.hpp"
#include "edvo/source/prefetch.hpp"
#include "support/shared_data.hpp"

#include <gtest/gtest.h>
#include <cmath>

namespace edvo {
namespace {

std::filesystem::path sequence() {
  return test::shared_data() / "tum/rgbd_dataset_freiburg1_xyz";
}

TEST(RealSequence, AssociatesAsTheTumToolDoes) {
  EDVO_REQUIRE_SHARED(sequence());
  const Dataset dataset = open_dataset(sequence());
  EXPECT_EQ(dataset.colour_count, 798U);
  EXPECT_EQ(dataset.depth_count, 798U);
  ASSERT_EQ(dataset.frames.size(), 792U);
  EXPECT_EQ(to_string(dataset.frames.front().stamp), "1305031102.175304");
  EXPECT_EQ(to_string(dataset.frames.front().depth_stamp), "1305031102.160407");
  EXPECT_EQ(dataset.image_size, cv::Size(640, 480));
  EXPECT_EQ(dataset.depth_scale.units_per_metre, 5000);
  EXPECT_TRUE(dataset.ground_truth);
  EXPECT_TRUE(dataset.warnings.empty());
  EXPECT_EQ(choose_camera(dataset).camera.pinhole.fx, 517.306408);
}

TEST(RealSequence, FramesAreTheSameForAnyNumberOfThreads) {
  EDVO_REQUIRE_SHARED(sequence());
  constexpr int kCount = 30;
  FolderSource one(sequence(), {.max_frames = kCount}), other(sequence(), {.max_frames = kCount});
  const auto read = [](const PendingFrame& frame) { return frame.load(); };
  Prefetch alone(read, one, {.threads = 1});
  Prefetch ahead(read, other, {.threads = 3});
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto a = alone.next(), b = ahead.next();
    ASSERT_TRUE(a && b);
    const RgbdImage& first = std::get<RgbdImage>(a->content);
    const RgbdImage& second = std::get<RgbdImage>(b->content);
    EXPECT_EQ(first.stamp, one.dataset().frames[i].stamp);
    EXPECT_EQ(first.stamp, second.stamp);
    EXPECT_EQ(cv::norm(first.bgr, second.bgr, cv::NORM_INF), 0);
    const cv::Mat first_depth = cv::max(first.depth, 0.0F),
                  second_depth = cv::max(second.depth, 0.0F);
    EXPECT_EQ(cv::norm(first_depth, second_depth, cv::NORM_INF), 0);
  }
}

TEST(RealSequence, DepthIsInMetresWithHoles) {
  EDVO_REQUIRE_SHARED(sequence());
  const Dataset dataset = open_dataset(sequence());
  const RgbdImage image = read_frame(dataset, 0);
  int holes = 0;
  double sum = 0;
  for (const float z : image.depth) {
    if (std::isnan(z)) {
      ++holes;
    } else {
      EXPECT_GT(z, 0.3F);
      EXPECT_LT(z, 13.2F);
      sum += static_cast<double>(z);
    }
  }
  EXPECT_GT(holes, 0);
  EXPECT_LT(holes, 640 * 480 / 2);
  EXPECT_NEAR(sum / (640 * 480 - holes), 1.5, 1.0);
}

}  // namespace
}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/source/masked_source.hpp"

#include "edvo/io/image_file.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <cmath>

namespace edvo {
namespace {

using test::fails_with;
using test::TemporaryFolder;

// Two frames of 4 x 3 pixels, 1 m away.
class TwoFrames final : public RgbdSource {
 public:
  TwoFrames() {
    info_.camera.pinhole = {.fx = 4, .fy = 4, .cx = 2, .cy = 1, .width = 4, .height = 3};
  }
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] std::optional<PendingFrame> next() override {
    if (index_ == 2) return std::nullopt;
    return PendingFrame{.index = index_++, .stamp = {}, .load = [] {
                          return RgbdImage{.stamp = {},
                                           .bgr = cv::Mat_<cv::Vec3b>(3, 4, cv::Vec3b(1, 2, 3)),
                                           .depth = cv::Mat_<float>(3, 4, 1.F)};
                        }};
  }

 private:
  SourceInfo info_;
  std::int64_t index_ = 0;
};

TEST(MaskedSource, HidesDepthAndLeavesTheRest) {
  const TemporaryFolder folder;
  cv::Mat_<std::uint8_t> image(3, 4, std::uint8_t{200});
  image(1, 2) = 100;
  write_png(folder.path() / "mask.png", image);
  MaskedSource source(std::make_unique<TwoFrames>(), read_mask(folder.path() / "mask.png", {4, 3}),
                      "mask.png");
  EXPECT_EQ(source.info().notes.back(), "mask.png hides 8.3 % of the image");
  for (int i = 0; i < 2; ++i) {
    const std::optional<PendingFrame> frame = source.next();
    ASSERT_TRUE(frame);
    const RgbdImage loaded = frame->load();
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 4; ++x)
        EXPECT_EQ(std::isnan(loaded.depth(y, x)), y == 1 && x == 2) << x << " " << y;
    EXPECT_EQ(loaded.bgr(1, 2), cv::Vec3b(1, 2, 3));
  }
  EXPECT_FALSE(source.next());
}

TEST(MaskedSource, SaysWhyAMaskIsOfNoUse) {
  const TemporaryFolder folder;
  write_png(folder.path() / "small.png", cv::Mat_<std::uint8_t>(2, 4, std::uint8_t{255}));
  write_png(folder.path() / "black.png", cv::Mat_<std::uint8_t>(3, 4, std::uint8_t{0}));
  const auto read = [&](const char* name) {
    return [file = folder.path() / name] { (void)read_mask(file, {4, 3}); };
  };
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"small.png", "4 x 2 px, the images 4 x 3"},
                         read("small.png")));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"black.png", "hides everything"}, read("black.png")));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"none.png"}, read("none.png")));
}

}  // namespace
}  // namespace edvo

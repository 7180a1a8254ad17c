// SPDX-License-Identifier: MIT
#include "edvo/io/image_file.hpp"

#include "edvo/io/file.hpp"
#include "support/error_matcher.hpp"
#include "support/png_bytes.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <spng.h>
#include <turbojpeg.h>
#include <cmath>
#include <vector>

namespace edvo {
namespace {

using test::fails_with;
using test::TemporaryFolder;

constexpr int kWidth = 5, kHeight = 3;

struct PngLayout {
  spng_color_type colour_type;
  std::uint8_t bit_depth;
  std::uint8_t interlace = SPNG_INTERLACE_NONE;
};

// The PNG formats that write_png() does not write.
std::string encode(const PngLayout& layout, const std::vector<std::uint8_t>& pixels,
                   const spng_plte* palette = nullptr) {
  spng_ctx* const png = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
  spng_ihdr header{};
  header.width = kWidth;
  header.height = kHeight;
  header.bit_depth = layout.bit_depth;
  header.color_type = static_cast<std::uint8_t>(layout.colour_type);
  header.interlace_method = layout.interlace;
  spng_set_ihdr(png, &header);
  if (palette != nullptr) {
    spng_plte copy = *palette;
    spng_set_plte(png, &copy);
  }
  EXPECT_EQ(
      spng_encode_image(png, pixels.data(), pixels.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
  return test::take_png(png);
}

std::string encode_jpeg(const cv::Mat& image, TJPF format) {
  const tjhandle jpeg = tjInitCompress();
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(jpeg, image.data, image.cols, 0, image.rows, format, &buffer, &size,
                        format == TJPF_GRAY ? TJSAMP_GRAY : TJSAMP_444, 95, 0),
            0);
  const std::string bytes(reinterpret_cast<const char*>(buffer), size);
  tjFree(buffer);
  tjDestroy(jpeg);
  return bytes;
}

cv::Mat_<cv::Vec3b> colour_ramp(int width = kWidth, int height = kHeight) {
  cv::Mat_<cv::Vec3b> image(height, width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image(y, x) = cv::Vec3b(static_cast<uchar>(7 * x), static_cast<uchar>(11 * y), 200);
  return image;
}

cv::Mat_<std::uint16_t> depth_ramp(int width = kWidth, int height = kHeight) {
  cv::Mat_<std::uint16_t> image(height, width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image(y, x) = static_cast<std::uint16_t>(257 * x + 4000 * y);
  return image;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(ImageFile, PngColourSurvivesTheRoundTrip) {
  const TemporaryFolder folder;
  write_png(folder.path() / "a.png", colour_ramp());
  EXPECT_TRUE(equal(read_colour(folder.path() / "a.png"), colour_ramp()));
}

TEST(ImageFile, PngDepthSurvivesTheRoundTrip) {
  const TemporaryFolder folder;
  write_png(folder.path() / "a.png", depth_ramp());
  EXPECT_TRUE(equal(read_depth_raw(folder.path() / "a.png"), depth_ramp()));
}

TEST(ImageFile, APartOfAnImageIsWrittenAsItIs) {
  const TemporaryFolder folder;
  const cv::Mat part = depth_ramp(20, 20)(cv::Rect(3, 4, 5, 6));
  write_png(folder.path() / "a.png", part);
  EXPECT_TRUE(equal(read_depth_raw(folder.path() / "a.png"), part));
}

TEST(ImageFile, GrayBecomesThreeEqualChannels) {
  const TemporaryFolder folder;
  write_png(folder.path() / "a.png", cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(77)));
  const cv::Mat expected(kHeight, kWidth, CV_8UC3, cv::Scalar(77, 77, 77));
  EXPECT_TRUE(equal(read_colour(folder.path() / "a.png"), expected));
}

TEST(ImageFile, TransparencyIsIgnored) {
  const TemporaryFolder folder;
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < kWidth * kHeight; ++i) rgba.insert(rgba.end(), {10, 20, 30, 0});
  const cv::Mat expected(kHeight, kWidth, CV_8UC3, cv::Scalar(30, 20, 10));
  const auto file = folder.write("a.png", encode({SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 8}, rgba));
  EXPECT_TRUE(equal(read_colour(file), expected));
}

TEST(ImageFile, PaletteIsLookedUp) {
  const TemporaryFolder folder;
  spng_plte palette{};
  palette.n_entries = 2;
  palette.entries[1] = {10, 20, 30, 255};
  const std::vector<std::uint8_t> ones(kWidth * kHeight, 1);
  const cv::Mat expected(kHeight, kWidth, CV_8UC3, cv::Scalar(30, 20, 10));
  const auto file = folder.write("a.png", encode({SPNG_COLOR_TYPE_INDEXED, 8}, ones, &palette));
  EXPECT_TRUE(equal(read_colour(file), expected));
}

TEST(ImageFile, SixteenBitColourIsShortened) {
  const TemporaryFolder folder;
  std::vector<std::uint8_t> rgb;
  for (int i = 0; i < kWidth * kHeight * 3; ++i) rgb.insert(rgb.end(), {0x12, 0xab});  // 0xab12
  const cv::Mat expected(kHeight, kWidth, CV_8UC3, cv::Scalar(0xab, 0xab, 0xab));
  const auto file = folder.write("a.png", encode({SPNG_COLOR_TYPE_TRUECOLOR, 16}, rgb));
  EXPECT_TRUE(equal(read_colour(file), expected));
}

TEST(ImageFile, JpegColourIsReadWithinItsLoss) {
  const TemporaryFolder folder;
  const cv::Mat_<cv::Vec3b> image = colour_ramp(32, 24);
  const auto file = folder.write("a.dat", encode_jpeg(image, TJPF_BGR));
  const cv::Mat_<cv::Vec3b> read = read_colour(file);
  ASSERT_EQ(read.size(), image.size());
  EXPECT_LT(cv::norm(read, image, cv::NORM_INF), 12);
}

TEST(ImageFile, GrayJpegBecomesThreeEqualChannels) {
  const TemporaryFolder folder;
  const cv::Mat gray(24, 32, CV_8UC1, cv::Scalar(90));
  const cv::Mat_<cv::Vec3b> read = read_colour(folder.write("a.jpg", encode_jpeg(gray, TJPF_GRAY)));
  EXPECT_EQ(read(10, 10), cv::Vec3b(90, 90, 90));
}

TEST(ImageFile, AnImageCutAnywhereIsAnErrorThatNamesTheFile) {
  const TemporaryFolder folder;
  write_png(folder.path() / "whole.png", depth_ramp(64, 48));
  const std::string depth = read_file(folder.path() / "whole.png");
  write_png(folder.path() / "whole.png", colour_ramp(64, 48));
  const std::string png = read_file(folder.path() / "whole.png");
  const std::string jpeg = encode_jpeg(colour_ramp(64, 48), TJPF_BGR);
  constexpr std::size_t kPngTrailer = 12;  // the IEND chunk, nothing is lost without it
  constexpr std::size_t kJpegTrailer = 2;
  for (std::size_t n = 0; n + kPngTrailer < depth.size(); n += 5)
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"cut.png"}, [&] {
      (void)read_depth_raw(folder.write("cut.png", depth.substr(0, n)));
    })) << n;
  for (std::size_t n = 0; n + kPngTrailer < png.size(); n += 5)
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"cut.png"}, [&] {
      (void)read_colour(folder.write("cut.png", png.substr(0, n)));
    })) << n;
  for (std::size_t n = 0; n + kJpegTrailer < jpeg.size(); n += 5)
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"cut.jpg"}, [&] {
      (void)read_colour(folder.write("cut.jpg", jpeg.substr(0, n)));
    })) << n;
}

TEST(ImageFile, ADamagedByteInAPngIsAnError) {
  const TemporaryFolder folder;
  write_png(folder.path() / "whole.png", depth_ramp(64, 48));
  const std::string whole = read_file(folder.path() / "whole.png");
  for (std::size_t n = 0; n + 12 < whole.size(); n += 3) {
    std::string damaged = whole;
    damaged[n] = static_cast<char>(~damaged[n]);
    const auto file = folder.write("damaged.png", damaged);
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"damaged.png"}, [&] { (void)read_depth_raw(file); }))
        << n;
  }
}

TEST(ImageFile, ADamagedJpegNeverCrashes) {
  const TemporaryFolder folder;
  const std::string whole = encode_jpeg(colour_ramp(64, 48), TJPF_BGR);
  for (std::size_t n = 0; n < whole.size(); n += 3) {
    std::string damaged = whole;
    damaged[n] = static_cast<char>(~damaged[n]);
    const auto file = folder.write("damaged.jpg", damaged);
    const auto error = test::error_of([&] { (void)read_colour(file); });
    if (error) {
      EXPECT_EQ(error->code(), ErrorCode::kInput);
    }
  }
}

TEST(ImageFile, AHeaderThatClaimsAHugeImageIsRefused) {
  const TemporaryFolder folder;
  std::string jpeg = encode_jpeg(colour_ramp(64, 48), TJPF_BGR);
  const std::size_t frame_header = jpeg.find("\xff\xc0");
  ASSERT_NE(frame_header, std::string::npos);
  jpeg.replace(frame_header + 5, 4, "\x7f\xf0\x7f\xf0");  // height, width
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"huge.jpg", "32752 x 32752", "16384"},
                         [&] { (void)read_colour(folder.write("huge.jpg", jpeg)); }));

  const cv::Mat wide(1, kLargestImageSide + 1, CV_8UC1, cv::Scalar(0));
  write_png(folder.path() / "wide.png", wide);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"wide.png"},
                         [&] { (void)read_colour(folder.path() / "wide.png"); }));
}

TEST(ImageFile, DepthOfEightBitsIsRefusedWithItsBitDepth) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "depth.png";
  write_png(file, cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(77)));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"depth.png: 8-bit gray PNG", "16 bits"},
                         [&] { (void)read_depth_raw(file); }));
  write_png(file, colour_ramp());
  EXPECT_TRUE(fails_with(ErrorCode::kInput,
                         {"depth.png: 8-bit RGB PNG", "single channel", "swapped"},
                         [&] { (void)read_depth_raw(file); }));
}

TEST(ImageFile, DepthAsJpegIsRefused) {
  const TemporaryFolder folder;
  const auto file = folder.write("depth.png", encode_jpeg(colour_ramp(), TJPF_BGR));
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"depth.png: not a PNG"}, [&] { (void)read_depth_raw(file); }));
}

TEST(ImageFile, WhatIsNoImageIsSaidToBeNone) {
  const TemporaryFolder folder;
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.png: neither a PNG nor a JPEG"},
                         [&] { (void)read_colour(folder.write("a.png", "hello")); }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"b.png: empty file"},
                         [&] { (void)read_colour(folder.write("b.png", "")); }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"c.png: no such file"},
                         [&] { (void)read_colour(folder.path() / "c.png"); }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"not a regular file"},
                         [&] { (void)read_colour(folder.path()); }));
}

TEST(ImageFile, DepthBecomesMetresAndHolesBecomeNaN) {
  const cv::Mat_<std::uint16_t> raw = (cv::Mat_<std::uint16_t>(1, 4) << 0, 5000, 12345, 65535);
  const cv::Mat_<float> metres = depth_to_metres(raw, 5000);
  EXPECT_TRUE(std::isnan(metres(0, 0)));
  EXPECT_EQ(metres(0, 1), 1.0F);
  EXPECT_EQ(metres(0, 2), 2.469F);
  EXPECT_TRUE(std::isnan(metres(0, 3)));
}

TEST(ImageFile, WritingWhereNothingCanBeWrittenIsAnOutputError) {
  const TemporaryFolder folder;
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"nowhere/a.png", "No such file"},
                         [&] { write_png(folder.path() / "nowhere/a.png", colour_ramp()); }));
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"/dev/full", "No space left"},
                         [] { write_png("/dev/full", colour_ramp()); }));
}

TEST(ImageFile, OnlyPixelsThatAPngHoldsAreWritten) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.png";
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"a.png"}, [&] { write_png(file, cv::Mat()); }));
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"a.png"},
                         [&] { write_png(file, cv::Mat(2, 2, CV_32FC1, cv::Scalar(1))); }));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/io/plain_png.hpp"

#include "edvo/io/image_file.hpp"
#include "support/error_matcher.hpp"
#include "support/png_bytes.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <libdeflate.h>
#include <spng.h>
#include <random>
#include <string>

namespace edvo {
namespace {

using test::fails_with;
using test::TemporaryFolder;

const cv::Size kSizes[] = {{1, 1}, {1, 7}, {7, 1}, {5, 3}, {17, 9}, {64, 33}};
constexpr int kFilters[] = {SPNG_FILTER_CHOICE_NONE,  SPNG_FILTER_CHOICE_SUB,
                            SPNG_FILTER_CHOICE_UP,    SPNG_FILTER_CHOICE_AVG,
                            SPNG_FILTER_CHOICE_PAETH, SPNG_FILTER_CHOICE_ALL};

// In the file's order of channels and the machine's order of bytes.
cv::Mat noise(cv::Size size, int type) {
  std::mt19937 random(1);
  cv::Mat image(size, type);
  for (std::size_t i = 0; i < image.total() * image.elemSize(); ++i)
    image.data[i] = static_cast<uchar>(random());
  return image;
}

std::string encode(const cv::Mat& image, spng_color_type colour_type, int filters) {
  spng_ctx* const png = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
  spng_set_option(png, SPNG_FILTER_CHOICE, filters);
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(image.cols);
  header.height = static_cast<std::uint32_t>(image.rows);
  header.bit_depth = image.depth() == CV_16U ? 16 : 8;
  header.color_type = static_cast<std::uint8_t>(colour_type);
  spng_set_ihdr(png, &header);
  EXPECT_EQ(spng_encode_image(png, image.data, image.total() * image.elemSize(), SPNG_FMT_PNG,
                              SPNG_ENCODE_FINALIZE),
            0);
  return test::take_png(png);
}

std::string chunk(const std::string& type, const std::string& content) {
  const auto word = [](std::size_t value) {
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift & 0xff);
    return bytes;
  };
  const std::string body = type + content;
  return word(content.size()) + body + word(libdeflate_crc32(0, body.data(), body.size()));
}

// A gray image of 2 x 2 px from its rows as they are before compression.
std::string tiny_png(const std::string& rows) {
  libdeflate_compressor* const compressor = libdeflate_alloc_compressor(1);
  std::string deflated(100, '\0');
  deflated.resize(libdeflate_zlib_compress(compressor, rows.data(), rows.size(), deflated.data(),
                                           deflated.size()));
  libdeflate_free_compressor(compressor);
  const std::string header("\0\0\0\2\0\0\0\2\x08\0\0\0\0", 13);
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", deflated) + chunk("IEND", "");
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(PlainPng, ColourHasTheSamePixelsWithEveryFilter) {
  for (const cv::Size size : kSizes)
    for (const int filters : kFilters) {
      const cv::Mat_<cv::Vec3b> rgb = noise(size, CV_8UC3);
      cv::Mat_<cv::Vec3b> bgr(size);
      cv::Mat_<cv::Vec4b> rgba(size);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
          const cv::Vec3b p = rgb(y, x);
          bgr(y, x) = {p[2], p[1], p[0]};
          rgba(y, x) = {p[0], p[1], p[2], static_cast<uchar>(x + y)};
        }
      EXPECT_TRUE(equal(decode_plain_colour(encode(rgb, SPNG_COLOR_TYPE_TRUECOLOR, filters)), bgr));
      EXPECT_TRUE(
          equal(decode_plain_colour(encode(rgba, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, filters)), bgr));
    }
}

TEST(PlainPng, GrayHasTheSamePixelsWithEveryFilter) {
  for (const cv::Size size : kSizes)
    for (const int filters : kFilters) {
      const cv::Mat_<std::uint8_t> gray = noise(size, CV_8UC1);
      cv::Mat_<cv::Vec3b> bgr(size);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) bgr(y, x) = cv::Vec3b::all(gray(y, x));
      EXPECT_TRUE(
          equal(decode_plain_colour(encode(gray, SPNG_COLOR_TYPE_GRAYSCALE, filters)), bgr));
    }
}

TEST(PlainPng, DepthHasTheSamePixelsWithEveryFilter) {
  for (const cv::Size size : kSizes)
    for (const int filters : kFilters) {
      const cv::Mat depth = noise(size, CV_16UC1);
      EXPECT_TRUE(
          equal(decode_plain_depth(encode(depth, SPNG_COLOR_TYPE_GRAYSCALE, filters)), depth));
    }
}

TEST(PlainPng, DamagedFilesAreLeftToTheGeneralReader) {
  const std::string whole =
      encode(noise({9, 7}, CV_16UC1), SPNG_COLOR_TYPE_GRAYSCALE, SPNG_FILTER_CHOICE_ALL);
  ASSERT_FALSE(decode_plain_depth(whole).empty());
  EXPECT_TRUE(decode_plain_depth(whole + "x").empty());
  for (std::size_t n = 0; n < whole.size(); ++n) {
    EXPECT_TRUE(decode_plain_depth(whole.substr(0, n)).empty()) << n;
    std::string damaged = whole;
    damaged[n] = static_cast<char>(~damaged[n]);
    if (n < 8) continue;  // the signature has been read by the caller
    EXPECT_TRUE(decode_plain_depth(damaged).empty()) << n;
  }
}

TEST(PlainPng, RowsThatMakeNoImageAreAnError) {
  const TemporaryFolder folder;
  EXPECT_EQ(decode_plain_colour(tiny_png({0, 1, 2, 2, 3, 4}))(1, 1), cv::Vec3b::all(6));
  for (const std::string& rows :
       {std::string{0, 1, 2, 5, 3, 4}, std::string{0, 1, 2, 0, 3}}) {  // filter 5; too short
    EXPECT_TRUE(decode_plain_colour(tiny_png(rows)).empty());
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.png: truncated or damaged PNG"},
                           [&] { (void)read_colour(folder.write("a.png", tiny_png(rows))); }));
  }
  EXPECT_TRUE(decode_plain_colour(tiny_png({0, 1, 2, 0, 3, 4, 0})).empty());  // too long
}

TEST(PlainPng, OtherFormatsAreLeftToTheGeneralReader) {
  const cv::Mat gray = noise({8, 8}, CV_8UC1), depth = noise({8, 8}, CV_16UC1);
  constexpr int kAll = SPNG_FILTER_CHOICE_ALL;
  EXPECT_TRUE(decode_plain_depth(encode(gray, SPNG_COLOR_TYPE_GRAYSCALE, kAll)).empty());
  EXPECT_TRUE(decode_plain_colour(encode(depth, SPNG_COLOR_TYPE_GRAYSCALE, kAll)).empty());
  EXPECT_TRUE(
      decode_plain_colour(encode(noise({8, 8}, CV_8UC2), SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, kAll))
          .empty());
  std::string commented = tiny_png({0, 1, 2, 0, 3, 4});
  commented.insert(commented.size() - 12, chunk("tEXt", std::string("a\0b", 3)));
  EXPECT_TRUE(decode_plain_colour(commented).empty());
}

}  // namespace
}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/io/image_file.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/plain_png.hpp"
#include "edvo/simd/dispatch.hpp"

#include <fmt/core.h>
#include <spng.h>
#include <turbojpeg.h>
#include <cstdlib>
#include <limits>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string_view>

namespace edvo {
namespace {

using std::filesystem::path;

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kJpegSignature = "\xff\xd8\xff";
constexpr std::size_t kLargestChunk = std::size_t{1} << 24;  // [bytes] of text, profile, ...
constexpr int kFastCompression = 1;                          // of zlib's 1..9

struct SpngDelete {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using SpngContext = std::unique_ptr<spng_ctx, SpngDelete>;

struct TurboJpegDelete {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpegHandle = std::unique_ptr<void, TurboJpegDelete>;

[[noreturn]] void fail(const path& file, std::string_view reason) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}", file.string(), reason));
}

void check_size(const path& file, std::int64_t width, std::int64_t height) {
  if (width < 1 || height < 1 || width > kLargestImageSide || height > kLargestImageSide ||
      width * height > kMostPixels)
    fail(file, fmt::format("image of {} x {} px; sides go from 1 to {} px, areas to {} px", width,
                           height, kLargestImageSide, kMostPixels));
}

std::string_view colour_type_name(std::uint8_t type) {
  switch (type) {
    case SPNG_COLOR_TYPE_GRAYSCALE:
      return "gray";
    case SPNG_COLOR_TYPE_TRUECOLOR:
      return "RGB";
    case SPNG_COLOR_TYPE_INDEXED:
      return "palette";
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
      return "gray + alpha";
    case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA:
      return "RGBA";
    default:
      return "unknown";
  }
}

// A PNG in memory with its header read and its size found acceptable. It borrows bytes.
struct PngReader {
  SpngContext context;
  spng_ihdr header{};
};

PngReader open_png(const path& file, std::string_view bytes) {
  PngReader png{.context = SpngContext(spng_ctx_new(0))};
  if (!png.context) throw std::bad_alloc();
  spng_set_image_limits(png.context.get(), kLargestImageSide, kLargestImageSide);
  spng_set_chunk_limits(png.context.get(), kLargestChunk, kLargestChunk);
  int status = spng_set_png_buffer(png.context.get(), bytes.data(), bytes.size());
  if (status == SPNG_OK) status = spng_get_ihdr(png.context.get(), &png.header);
  if (status != SPNG_OK) fail(file, fmt::format("damaged PNG header, {}", spng_strerror(status)));
  check_size(file, png.header.width, png.header.height);
  return png;
}

void decode_png(const path& file, const PngReader& png, spng_format format, cv::Mat& image) {
  const std::size_t size = image.total() * image.elemSize();
  int status = spng_decode_image(png.context.get(), image.data, size, format, 0);
  // The pixels may be complete before the last checksum has been read.
  if (status == SPNG_OK) status = spng_decode_chunks(png.context.get());
  if (status != SPNG_OK)
    fail(file, fmt::format("truncated or damaged PNG, {}", spng_strerror(status)));
}

cv::Mat_<cv::Vec3b> decode_png_colour(const path& file, std::string_view bytes) {
  if (const cv::Mat_<cv::Vec3b> plain = decode_plain_colour(bytes); !plain.empty()) return plain;
  const PngReader png = open_png(file, bytes);
  cv::Mat_<cv::Vec3b> image(static_cast<int>(png.header.height),
                            static_cast<int>(png.header.width));
  decode_png(file, png, SPNG_FMT_RGB8, image);
  for (cv::Vec3b& pixel : image) std::swap(pixel[0], pixel[2]);  // RGB to BGR
  return image;
}

// Cameras that stream motion JPEG leave harmless stray bytes behind a frame; any other warning of
// the decoder means that it made pixels up.
bool is_harmless(std::string_view warning) {
  return warning.find("extraneous bytes") != std::string_view::npos;
}

cv::Mat_<cv::Vec3b> decode_jpeg(const path& file, std::string_view bytes) {
  const TurboJpegHandle jpeg(tjInitDecompress());
  if (!jpeg) throw std::bad_alloc();
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, subsampling = 0, colour_space = 0;
  if (tjDecompressHeader3(jpeg.get(), data, bytes.size(), &width, &height, &subsampling,
                          &colour_space) != 0)
    fail(file, fmt::format("damaged JPEG header, {}", tjGetErrorStr2(jpeg.get())));
  check_size(file, width, height);

  cv::Mat_<cv::Vec3b> bgr(height, width);
  const int status = tjDecompress2(jpeg.get(), data, bytes.size(), bgr.data, width, 0, height,
                                   TJPF_BGR, TJFLAG_LIMITSCANS);
  if (status != 0) {
    const std::string_view message = tjGetErrorStr2(jpeg.get());
    if (tjGetErrorCode(jpeg.get()) != TJERR_WARNING || !is_harmless(message))
      fail(file, fmt::format("truncated or damaged JPEG, {}", message));
  }
  return bgr;
}

std::string encode_png(const path& file, const cv::Mat& image, spng_color_type colour_type,
                       std::uint8_t bit_depth) {
  const SpngContext png(spng_ctx_new(SPNG_CTX_ENCODER));
  if (!png) throw std::bad_alloc();
  spng_set_option(png.get(), SPNG_ENCODE_TO_BUFFER, 1);
  spng_set_option(png.get(), SPNG_IMG_COMPRESSION_LEVEL, kFastCompression);
  spng_set_option(png.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(image.cols);
  header.height = static_cast<std::uint32_t>(image.rows);
  header.bit_depth = bit_depth;
  header.color_type = static_cast<std::uint8_t>(colour_type);
  int status = spng_set_ihdr(png.get(), &header);
  if (status == SPNG_OK)
    status = spng_encode_image(png.get(), image.data, image.total() * image.elemSize(),
                               SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  std::size_t size = 0;
  std::unique_ptr<void, decltype(&std::free)> buffer(nullptr, &std::free);
  if (status == SPNG_OK) buffer.reset(spng_get_png_buffer(png.get(), &size, &status));
  if (status != SPNG_OK || !buffer)
    throw Error(ErrorCode::kOutput, fmt::format("{}: cannot be encoded as PNG, {}", file.string(),
                                                spng_strerror(status)));
  return {static_cast<const char*>(buffer.get()), size};
}

// One division for all, by NaN where there is no depth: a branch around it would keep the compiler
// from doing several at once.
EDVO_CLONES void row_to_metres(const std::uint16_t* __restrict raw, float* __restrict metres,
                               int width, float units) {
  constexpr std::uint16_t kNoReturn = 0;
  constexpr std::uint16_t kSaturated = std::numeric_limits<std::uint16_t>::max();
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (int x = 0; x < width; ++x) {
    const bool none = (raw[x] == kNoReturn) | (raw[x] == kSaturated);
    metres[x] = static_cast<float>(raw[x]) / (none ? kNone : units);
  }
}

}  // namespace

cv::Mat_<cv::Vec3b> read_colour(const path& file) {
  const std::string bytes = read_file(file);
  if (bytes.empty()) fail(file, "empty file, expected a PNG or JPEG image");
  if (bytes.starts_with(kPngSignature)) return decode_png_colour(file, bytes);
  if (bytes.starts_with(kJpegSignature)) return decode_jpeg(file, bytes);
  fail(file, "neither a PNG nor a JPEG image");
}

cv::Mat_<std::uint16_t> read_depth_raw(const path& file) {
  const std::string bytes = read_file(file);
  if (bytes.empty()) fail(file, "empty file, expected a 16-bit PNG of depth");
  if (!bytes.starts_with(kPngSignature)) fail(file, "not a PNG; depth is read from 16-bit PNG");
  if (const cv::Mat_<std::uint16_t> plain = decode_plain_depth(bytes); !plain.empty()) return plain;
  const PngReader png = open_png(file, bytes);
  if (png.header.bit_depth != 16 || png.header.color_type != SPNG_COLOR_TYPE_GRAYSCALE)
    fail(file, fmt::format("{}-bit {} PNG; depth needs 16 bits and a single channel: {}",
                           png.header.bit_depth, colour_type_name(png.header.color_type),
                           png.header.color_type == SPNG_COLOR_TYPE_GRAYSCALE
                               ? "8 bits have no room for millimetres, write the depth as 16-bit"
                               : "a colour image, or are colour and depth swapped?"));
  cv::Mat raw(static_cast<int>(png.header.height), static_cast<int>(png.header.width), CV_16UC1);
  decode_png(file, png, SPNG_FMT_PNG, raw);
  return raw;
}

cv::Mat_<float> depth_to_metres(const cv::Mat_<std::uint16_t>& raw, double units_per_metre) {
  cv::Mat_<float> metres(raw.size());
  for (int y = 0; y < raw.rows; ++y)
    row_to_metres(raw[y], metres[y], raw.cols, static_cast<float>(units_per_metre));
  return metres;
}

void write_png(const path& file, const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  switch (image.empty() ? -1 : image.type()) {
    case CV_8UC3: {
      cv::Mat rgb;
      cv::cvtColor(whole, rgb, cv::COLOR_BGR2RGB);
      return write_file(file, encode_png(file, rgb, SPNG_COLOR_TYPE_TRUECOLOR, 8));
    }
    case CV_8UC1:
      return write_file(file, encode_png(file, whole, SPNG_COLOR_TYPE_GRAYSCALE, 8));
    case CV_16UC1:
      return write_file(file, encode_png(file, whole, SPNG_COLOR_TYPE_GRAYSCALE, 16));
    default:
      throw Error(ErrorCode::kOutput,
                  fmt::format("{}: a PNG is written from 8-bit BGR, 8-bit gray or 16-bit gray, got "
                              "{} x {} px of OpenCV type {}",
                              file.string(), image.cols, image.rows, image.type()));
  }
}

}  // namespace edvo

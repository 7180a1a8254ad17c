// SPDX-License-Identifier: MIT
#include "edvo/io/plain_png.hpp"

#include "edvo/io/image_file.hpp"
#include "edvo/simd/dispatch.hpp"

#include <libdeflate.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

namespace edvo {
namespace {

using Byte = std::uint8_t;

constexpr std::size_t kSignatureSize = 8, kHeaderSize = 13;  // [bytes]
constexpr std::size_t kChunkFrame = 12;                      // [bytes] length, type, checksum

struct Header {
  std::int64_t width = 0, height = 0;  // [px]
  int pixel_size = 0;                  // [bytes] 1 = gray, 2 = 16-bit gray, 3 = RGB, 4 = RGBA
};

// The filtered rows, each behind the number of its filter.
struct Rows {
  std::unique_ptr<Byte[]> bytes;  // the rows, and where they are compressed behind them
  int width = 0, height = 0;      // [px]
  int pixel_size = 0;             // [bytes]

  std::size_t row_size() const { return static_cast<std::size_t>(width) * pixel_size; }
  std::size_t size() const { return height * (row_size() + 1); }
  Byte* row(int y) const { return bytes.get() + y * (row_size() + 1) + 1; }
};

std::uint32_t big_endian(const char* at) {
  const auto* const b = reinterpret_cast<const Byte*>(at);
  return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 | b[3];
}

struct Chunk {
  std::string_view type, content;
};

// The chunk there, its checksum found right.
std::optional<Chunk> read_chunk(std::string_view png, std::size_t at) {
  if (at + kChunkFrame > png.size()) return std::nullopt;
  const std::size_t size = big_endian(png.data() + at);
  if (size > png.size() - at - kChunkFrame) return std::nullopt;
  const Chunk chunk{.type = png.substr(at + 4, 4), .content = png.substr(at + 8, size)};
  const std::uint32_t checksum = libdeflate_crc32(0, chunk.type.data(), 4 + size);
  if (checksum != big_endian(png.data() + at + 8 + size)) return std::nullopt;
  return chunk;
}

int pixel_size(char bits, char colour_type) {
  if (bits == 8 && colour_type == 0) return 1;
  if (bits == 16 && colour_type == 0) return 2;
  if (bits == 8 && colour_type == 2) return 3;
  if (bits == 8 && colour_type == 6) return 4;
  return 0;
}

std::optional<Header> read_header(std::string_view png) {
  constexpr std::string_view kUsualMethods("\0\0\0", 3);  // deflate, five filters, not interlaced
  const std::optional<Chunk> chunk = read_chunk(png, kSignatureSize);
  if (!chunk || chunk->type != "IHDR" || chunk->content.size() != kHeaderSize ||
      chunk->content.substr(10) != kUsualMethods)
    return std::nullopt;
  const std::string_view header = chunk->content;
  const Header result{.width = big_endian(header.data()),
                      .height = big_endian(header.data() + 4),
                      .pixel_size = pixel_size(header[8], header[9])};
  if (result.pixel_size == 0 || result.width < 1 || result.height < 1 ||
      result.width > kLargestImageSide || result.height > kLargestImageSide ||
      result.width * result.height > kMostPixels)
    return std::nullopt;
  return result;
}

// Copies the pixels' chunks to where there is room for the whole file, and says how many bytes they
// are. Nothing if anything but the file's end follows.
std::optional<std::size_t> join_pixel_chunks(std::string_view png, Byte* out) {
  std::size_t size = 0;
  for (std::size_t at = kSignatureSize + kChunkFrame + kHeaderSize;;) {
    const std::optional<Chunk> chunk = read_chunk(png, at);
    if (!chunk) return std::nullopt;
    at += kChunkFrame + chunk->content.size();
    if (chunk->type == "IEND" && chunk->content.empty() && at == png.size()) return size;
    if (chunk->type != "IDAT") return std::nullopt;
    std::copy(chunk->content.begin(), chunk->content.end(), out + size);
    size += chunk->content.size();
  }
}

bool inflate(const Byte* in, std::size_t in_size, Byte* out, std::size_t out_size) {
  struct Free {
    void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
  };
  const std::unique_ptr<libdeflate_decompressor, Free> inflater(libdeflate_alloc_decompressor());
  if (!inflater) throw std::bad_alloc();
  std::size_t used = 0;
  return libdeflate_zlib_decompress_ex(inflater.get(), in, in_size, out, out_size, &used,
                                       nullptr) == LIBDEFLATE_SUCCESS &&
         used == in_size;
}

// The five filters (PNG specification, section 9) undone in place, a pixel of N bytes. above is the
// row before, zeros for the first. Unrolled, or gcc keeps a pixel in memory.

template <int N>
void undo_left(Byte* row, std::size_t size) {
  std::array<Byte, N> left{};
  for (std::size_t i = 0; i < size; i += N)
#pragma GCC unroll 4
    for (int c = 0; c < N; ++c) row[i + c] = left[c] = static_cast<Byte>(row[i + c] + left[c]);
}

EDVO_CLONES void undo_up(Byte* __restrict row, const Byte* __restrict above, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) row[i] = static_cast<Byte>(row[i] + above[i]);
}

template <int N>
void undo_average(Byte* row, const Byte* above, std::size_t size) {
  std::array<Byte, N> left{};
  for (std::size_t i = 0; i < size; i += N)
#pragma GCC unroll 4
    for (int c = 0; c < N; ++c)
      row[i + c] = left[c] = static_cast<Byte>(row[i + c] + (left[c] + above[i + c]) / 2);
}

// Whichever of left, up and corner is nearest to left + up - corner; in this order.
int paeth(int left, int up, int corner) {
  const int to_left = std::abs(up - corner), to_up = std::abs(left - corner);
  const int to_corner = std::abs(left + up - 2 * corner);
  const int nearer = to_up <= to_corner ? up : corner;
  return to_left <= to_up && to_left <= to_corner ? left : nearer;
}

template <int N>
void undo_paeth(Byte* row, const Byte* above, std::size_t size) {
  std::array<int, N> left{}, corner{};
  for (std::size_t i = 0; i < size; i += N)
#pragma GCC unroll 4
    for (int c = 0; c < N; ++c) {
      const int up = above[i + c];
      left[c] = (row[i + c] + paeth(left[c], up, corner[c])) & 0xff;
      corner[c] = up;
      row[i + c] = static_cast<Byte>(left[c]);
    }
}

// False if a row names a filter that does not exist.
template <int N>
bool undo_filters(const Rows& rows) {
  const std::size_t size = rows.row_size();
  const std::vector<Byte> zeros(size);
  const Byte* above = zeros.data();
  for (int y = 0; y < rows.height; ++y) {
    Byte* const row = rows.row(y);
    switch (row[-1]) {
      case 0:
        break;
      case 1:
        undo_left<N>(row, size);
        break;
      case 2:
        undo_up(row, above, size);
        break;
      case 3:
        undo_average<N>(row, above, size);
        break;
      case 4:
        undo_paeth<N>(row, above, size);
        break;
      default:
        return false;
    }
    above = row;
  }
  return true;
}

bool undo_filters(const Rows& rows) {
  switch (rows.pixel_size) {
    case 1:
      return undo_filters<1>(rows);
    case 2:
      return undo_filters<2>(rows);
    case 3:
      return undo_filters<3>(rows);
    default:
      return undo_filters<4>(rows);
  }
}

std::optional<Rows> decode(std::string_view png, const Header& header) {
  Rows rows{.bytes = {},
            .width = static_cast<int>(header.width),
            .height = static_cast<int>(header.height),
            .pixel_size = header.pixel_size};
  rows.bytes = std::make_unique_for_overwrite<Byte[]>(rows.size() + png.size());
  Byte* const deflated = rows.bytes.get() + rows.size();
  const std::optional<std::size_t> size = join_pixel_chunks(png, deflated);
  if (!size || !inflate(deflated, *size, rows.bytes.get(), rows.size()) || !undo_filters(rows))
    return std::nullopt;
  return rows;
}

EDVO_CLONES void from_big_endian(const Byte* __restrict in, std::uint16_t* __restrict out, int n) {
  for (int i = 0; i < n; ++i) out[i] = static_cast<std::uint16_t>(in[2 * i] << 8 | in[2 * i + 1]);
}

}  // namespace

cv::Mat_<cv::Vec3b> decode_plain_colour(std::string_view png) {
  const std::optional<Header> header = read_header(png);
  if (!header || header->pixel_size == 2) return {};
  const std::optional<Rows> rows = decode(png, *header);
  if (!rows) return {};
  const cv::Mat pixels(rows->height, rows->width, CV_8UC(rows->pixel_size), rows->row(0),
                       rows->row_size() + 1);
  cv::Mat bgr;
  cv::cvtColor(pixels, bgr,
               rows->pixel_size == 1   ? cv::COLOR_GRAY2BGR
               : rows->pixel_size == 3 ? cv::COLOR_RGB2BGR
                                       : cv::COLOR_RGBA2BGR);
  return bgr;
}

cv::Mat_<std::uint16_t> decode_plain_depth(std::string_view png) {
  const std::optional<Header> header = read_header(png);
  if (!header || header->pixel_size != 2) return {};
  const std::optional<Rows> rows = decode(png, *header);
  if (!rows) return {};
  cv::Mat_<std::uint16_t> depth(rows->height, rows->width);
  for (int y = 0; y < depth.rows; ++y) from_big_endian(rows->row(y), depth[y], depth.cols);
  return depth;
}

}  // namespace edvo

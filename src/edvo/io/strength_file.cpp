// SPDX-License-Identifier: MIT
#include "edvo/io/strength_file.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/output_file.hpp"

#include <fmt/core.h>

#include <cstdint>
#include <cstring>
#include <string>

namespace edvo {
namespace {

namespace fs = std::filesystem;

// A file is kMagic, the SHA-256 of all that follows it, width and height as 32-bit numbers, then
// the floats row by row.
constexpr std::string_view kMagic = "edvo edge strength 1\n";
constexpr std::size_t kHashDigits = 64;
using Side = std::int32_t;

std::string floats_of(const cv::Mat_<float>& image) {
  const cv::Mat_<float> whole = image.isContinuous() ? image : image.clone();
  return {reinterpret_cast<const char*>(whole.data), whole.total() * sizeof(float)};
}

void append_side(std::string& bytes, int side) {
  const auto number = static_cast<Side>(side);
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

Side take_side(std::string_view& bytes) {
  Side side = 0;
  std::memcpy(&side, bytes.data(), sizeof side);
  bytes.remove_prefix(sizeof side);
  return side;
}

}  // namespace

void write_strength(const fs::path& path, const cv::Mat_<float>& strength) {
  std::string content;
  append_side(content, strength.cols);
  append_side(content, strength.rows);
  content += floats_of(strength);
  write_whole(path, std::string(kMagic) + sha256(content) + content);
}

std::optional<cv::Mat_<float>> find_strength(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return std::nullopt;
  const std::string bytes = read_file(path);
  const auto damaged = [&path] {
    return Error(ErrorCode::kInput, fmt::format("{}: a damaged edge map", path.string()));
  };
  std::string_view rest = bytes;
  if (rest.size() < kMagic.size() + kHashDigits + 2 * sizeof(Side) || !rest.starts_with(kMagic))
    throw damaged();
  rest.remove_prefix(kMagic.size());
  const std::string_view hash = rest.substr(0, kHashDigits);
  rest.remove_prefix(kHashDigits);
  if (sha256(rest) != hash) throw damaged();
  const Side width = take_side(rest), height = take_side(rest);
  if (width < 1 || height < 1 ||
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * sizeof(float) !=
          rest.size())
    throw damaged();
  cv::Mat_<float> strength(height, width);
  std::memcpy(strength.data, rest.data(), rest.size());
  return strength;
}

void write_npy(const fs::path& path, const cv::Mat_<float>& values) {
  constexpr std::size_t kAlignment = 64;  // [bytes], of the data
  constexpr std::size_t kBeforeHeader = 10;
  std::string header = fmt::format(
      "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}", values.rows, values.cols);
  while ((kBeforeHeader + header.size() + 1) % kAlignment != 0) header += ' ';
  header += '\n';
  std::string bytes = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0};
  bytes += static_cast<char>(header.size() & 0xff);
  bytes += static_cast<char>(header.size() >> 8);
  write_whole(path, bytes + header + floats_of(values));
}

}  // namespace edvo

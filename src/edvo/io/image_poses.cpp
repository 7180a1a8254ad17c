// SPDX-License-Identifier: MIT
#include "edvo/io/image_poses.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/text_list.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <sstream>
#include <string_view>

namespace edvo {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDigits = "0123456789";

[[noreturn]] void fail(const fs::path& file, const std::string& reason) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}", file.string(), reason));
}

bool is_file(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

// The numbers in a text, infinities and NaN among them.
std::vector<double> numbers_in(const std::string& text, const fs::path& file) {
  std::vector<double> numbers;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const char* const begin = word.data() + (word.front() == '+' ? 1 : 0);
    const char* const end = word.data() + word.size();
    const auto [stop, status] = std::from_chars(begin, end, numbers.emplace_back());
    if (stop != end || status != std::errc{})
      fail(file, fmt::format("{} is no number of a pose matrix", printable(word)));
  }
  return numbers;
}

// None if the matrix is no rigid motion. m: 3 or 4 rows of 4.
std::optional<SE3> pose_from(std::span<const double> m) {
  constexpr double kTolerance = 0.02;  // of files with few digits
  Eigen::Matrix3d rotation;
  rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  const Eigen::Vector3d translation(m[3], m[7], m[11]);
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(error < kTolerance) || rotation.determinant() < 0 || !translation.allFinite())
    return std::nullopt;
  return SE3{.rotation = Eigen::Quaterniond(rotation).normalized(), .translation = translation};
}

// "frame-000007.color.png" and "000007.png" begin with the name that a pose has.
std::string name_before(const fs::path& colour, std::string_view word) {
  const std::string stem = colour.stem().string();
  return stem.ends_with(word) ? stem.substr(0, stem.size() - word.size()) : stem;
}

fs::path beside_image(const fs::path& colour) {
  return colour.parent_path() / (name_before(colour, ".color") + ".pose.txt");
}

// A pose file for each image, where `file_of` says.
template <typename FileOf>
ImagePoses read_each(const std::vector<FrameEntry>& frames, FileOf file_of) {
  ImagePoses poses;
  std::size_t missing = 0, invalid = 0;
  for (const FrameEntry& frame : frames) {
    const fs::path file = file_of(frame.colour);
    if (!is_file(file)) {
      ++missing;
      continue;
    }
    const std::vector<double> numbers = numbers_in(read_file(file), file);
    if (numbers.size() != 16 && numbers.size() != 12)
      fail(file, fmt::format("expected a 4 x 4 matrix, got {} numbers", numbers.size()));
    const std::optional<SE3> pose = pose_from(numbers);
    invalid += !pose;
    if (pose) poses.trajectory.push_back({.stamp = frame.stamp, .world_from_camera = *pose});
  }
  if (missing + invalid > 0)
    poses.warnings.push_back(
        fmt::format("{} images have no pose file, {} poses are no rigid motion (marked invalid); "
                    "they are left out of the ground truth",
                    missing, invalid));
  return poses;
}

// The last number in the name of a file.
std::optional<std::size_t> number_of(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::size_t last = stem.find_last_of(kDigits);
  if (last == std::string::npos) return std::nullopt;
  const std::size_t before = stem.find_last_not_of(kDigits, last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  std::size_t number = 0;
  const auto [stop, status] = std::from_chars(stem.data() + first, stem.data() + last + 1, number);
  return status == std::errc{} ? std::optional(number) : std::nullopt;
}

ImagePoses read_lines(const fs::path& file, const std::vector<FrameEntry>& frames) {
  std::vector<std::vector<double>> lines;
  std::istringstream text(read_file(file));
  for (std::string line; std::getline(text, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    lines.push_back(numbers_in(line, file));
    if (lines.back().size() != 16 && lines.back().size() != 12)
      fail(file,
           fmt::format("line {}: expected 16 numbers, got {}", lines.size(), lines.back().size()));
  }
  ImagePoses poses;
  std::size_t missing = 0;
  for (const FrameEntry& frame : frames) {
    const std::optional<std::size_t> number = number_of(frame.colour);
    const auto pose =
        number && *number < lines.size() ? pose_from(lines[*number]) : std::optional<SE3>();
    missing += !pose;
    if (pose) poses.trajectory.push_back({.stamp = frame.stamp, .world_from_camera = *pose});
  }
  if (missing > 0)
    poses.warnings.push_back(fmt::format("{}: {} of {} images have no pose in its {} lines",
                                         file.string(), missing, frames.size(), lines.size()));
  return poses;
}

std::optional<ImagePoses> find_poses(const fs::path& root, const std::vector<FrameEntry>& frames) {
  std::error_code ignored;
  if (is_file(beside_image(frames.front().colour))) {
    ImagePoses poses = read_each(frames, beside_image);
    poses.source = "the .pose.txt files beside the images";
    return poses;
  }
  for (const char* const name : {"pose", "poses"}) {
    const fs::path folder = root / name;
    if (!fs::is_directory(folder, ignored)) continue;
    ImagePoses poses = read_each(frames, [&](const fs::path& colour) {
      return folder / (name_before(colour, ".color") + ".txt");
    });
    poses.source = fmt::format("the files in {}", folder.string());
    return poses;
  }
  for (const fs::path& file : {root / "traj.txt", root.parent_path() / "traj.txt"}) {
    if (!is_file(file)) continue;
    ImagePoses poses = read_lines(file, frames);
    poses.source = file.string();
    return poses;
  }
  return std::nullopt;
}

}  // namespace

std::optional<ImagePoses> read_image_poses(const fs::path& root,
                                           const std::vector<FrameEntry>& frames) {
  std::optional<ImagePoses> poses = frames.empty() ? std::nullopt : find_poses(root, frames);
  if (poses && poses->trajectory.empty()) return std::nullopt;
  return poses;
}

}  // namespace edvo

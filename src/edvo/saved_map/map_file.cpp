// SPDX-License-Identifier: MIT
#include "edvo/saved_map/map_file.hpp"

#include "edvo/io/byte_codec.hpp"
#include "edvo/io/section_file.hpp"
#include "edvo/saved_map/view_bytes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

namespace edvo {
namespace {

constexpr std::uint64_t kMostKeyframes = 1'000'000, kMostLinks = 16'000'000;
constexpr int kLongestSide = 16384;      // [px]
constexpr double kUnitTolerance = 1e-6;  // of a quaternion's length
constexpr SectionFormat kFormat{.magic = "edvo-map",
                                .version = 1,
                                .noun = "map",
                                .damage = ErrorCode::kMap,
                                .largest = std::uint64_t{1} << 30,
                                .largest_of_all = std::uint64_t{1} << 34};

// Sections, in this order; one kView for each keyframe whose images are kept.
constexpr std::string_view kHead = "HEAD", kPoses = "POSE", kSteps = "STEP", kLinks = "LINK",
                           kView = "VIEW", kEnd = "END ";

void append_text(std::string& bytes, const std::string& text) {
  append_number(bytes, std::uint64_t{text.size()});
  bytes += text;
}

std::string take_text(ByteReader& reader) {
  return std::string(reader.bytes(reader.number<std::uint64_t>()));
}

void append_pose(std::string& bytes, const SE3& pose) {
  for (const double value : pose.translation) append_number(bytes, value);
  for (const double value : pose.rotation.coeffs()) append_number(bytes, value);
}

SE3 take_pose(ByteReader& reader) {
  SE3 pose;
  for (double& value : pose.translation) value = reader.number<double>();
  for (double& value : pose.rotation.coeffs()) value = reader.number<double>();
  return pose;
}

void append_matrix(std::string& bytes, const Matrix6d& matrix) {
  for (const double value : matrix.reshaped()) append_number(bytes, value);
}

Matrix6d take_matrix(ByteReader& reader) {
  Matrix6d matrix;
  for (double& value : matrix.reshaped()) value = reader.number<double>();
  return matrix;
}

bool is_valid(const SE3& pose) {
  return is_finite(pose) && std::abs(pose.rotation.norm() - 1) < kUnitTolerance;
}

bool is_valid(const Camera& camera) {
  const auto is_focal = [](double f) { return std::isfinite(f) && f != 0; };
  return is_focal(camera.fx) && is_focal(camera.fy) && std::isfinite(camera.cx) &&
         std::isfinite(camera.cy) && camera.width >= 1 && camera.height >= 1 &&
         camera.width <= kLongestSide && camera.height <= kLongestSide;
}

std::string head_bytes(const SavedMap& map) {
  const Camera& camera = map.origin.camera;
  std::string bytes;
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy})
    append_number(bytes, value);
  append_number(bytes, std::int32_t{camera.width});
  append_number(bytes, std::int32_t{camera.height});
  append_number(bytes, map.origin.depth_scale);
  for (const std::string* text : {&map.origin.method, &map.origin.config, &map.origin.made_by})
    append_text(bytes, *text);
  append_number(bytes, std::uint64_t{map.views.size()});
  return bytes;
}

std::string pose_bytes(const SavedMap& map) {
  std::string bytes;
  append_number(bytes, std::uint64_t{map.keyframes.size()});
  for (const MapKeyframe& key : map.keyframes) {
    append_number(bytes, key.stamp.nanoseconds);
    append_number(bytes, std::int32_t{key.stamp.decimals});
    append_number(bytes, std::int32_t{key.segment});
    append_pose(bytes, key.world_from_camera);
  }
  return bytes;
}

std::string step_bytes(const SavedMap& map) {
  std::string bytes;
  append_number(bytes, std::uint64_t{map.steps.size()});
  for (const OdometryStep& step : map.steps) {
    append_number(bytes, step.from);
    append_number(bytes, step.to);
    append_matrix(bytes, step.information);
  }
  return bytes;
}

std::string link_bytes(const SavedMap& map) {
  std::string bytes;
  append_number(bytes, std::uint64_t{map.links.size()});
  for (const MapLink& link : map.links) {
    append_number(bytes, link.from);
    append_number(bytes, link.to);
    append_pose(bytes, link.from_pose_to);
    append_matrix(bytes, link.information);
  }
  return bytes;
}

// Reads a map section by section; what is not as it should be is an error that names the section.
class MapReader {
 public:
  explicit MapReader(const std::filesystem::path& path) : file_(path, kFormat) {}

  SavedMap read() {
    const std::uint64_t views = read_head();
    read_poses();
    read_steps();
    read_links();
    for (std::uint64_t i = 0; i < views; ++i) read_view();
    (void)section(kEnd);
    return std::move(map_);
  }

 private:
  Section section(std::string_view name) {
    Section found = file_.next();
    if (found.name != name) throw file_.damaged(found.name, "is out of place");
    return found;
  }

  void require(bool holds, std::string_view name) const {
    if (!holds) throw file_.damaged(name, "holds values that no map has");
  }

  // Elements of a list, each of so many bytes, of which the section has no more and no less.
  std::uint64_t count(ByteReader& reader, std::uint64_t most, std::size_t bytes_each,
                      std::string_view name) const {
    const auto number = reader.number<std::uint64_t>();
    require(reader.ok() && number <= most && reader.left() == number * bytes_each, name);
    return number;
  }

  // How many views there are.
  std::uint64_t read_head() {
    const std::string bytes = section(kHead).content;
    ByteReader reader(bytes);
    MapOrigin& origin = map_.origin;
    for (double* value :
         {&origin.camera.fx, &origin.camera.fy, &origin.camera.cx, &origin.camera.cy})
      *value = reader.number<double>();
    origin.camera.width = reader.number<std::int32_t>();
    origin.camera.height = reader.number<std::int32_t>();
    origin.depth_scale = reader.number<double>();
    for (std::string* text : {&origin.method, &origin.config, &origin.made_by})
      *text = take_text(reader);
    const auto views = reader.number<std::uint64_t>();
    require(reader.ok() && reader.left() == 0 && is_valid(origin.camera) &&
                std::isfinite(origin.depth_scale) && origin.depth_scale >= 0 &&
                views <= kMostKeyframes,
            kHead);
    return views;
  }

  void read_poses() {
    constexpr std::size_t kBytes = 8 + 4 + 4 + 7 * 8;
    const std::string bytes = section(kPoses).content;
    ByteReader reader(bytes);
    const std::uint64_t number = count(reader, kMostKeyframes, kBytes, kPoses);
    map_.keyframes.resize(number);
    for (std::size_t i = 0; i < number; ++i) {
      MapKeyframe& key = map_.keyframes[i];
      key.id = static_cast<KeyframeId>(i);
      key.stamp.nanoseconds = reader.number<std::int64_t>();
      key.stamp.decimals = reader.number<std::int32_t>();
      key.segment = reader.number<std::int32_t>();
      key.world_from_camera = take_pose(reader);
      require(key.stamp.decimals >= 0 && key.stamp.decimals <= 9 && key.segment >= 0 &&
                  key.segment < static_cast<int>(number) && is_valid(key.world_from_camera),
              kPoses);
    }
  }

  [[nodiscard]] bool is_pair(KeyframeId from, KeyframeId to) const {
    const auto number = static_cast<KeyframeId>(map_.keyframes.size());
    return from >= 0 && to >= 0 && from < number && to < number && from != to;
  }

  void read_steps() {
    constexpr std::size_t kBytes = 2 * 8 + 36 * 8;
    const std::string bytes = section(kSteps).content;
    ByteReader reader(bytes);
    map_.steps.resize(count(reader, kMostLinks, kBytes, kSteps));
    for (OdometryStep& step : map_.steps) {
      step.from = reader.number<std::int64_t>();
      step.to = reader.number<std::int64_t>();
      step.information = take_matrix(reader);
      require(is_pair(step.from, step.to) && step.information.allFinite(), kSteps);
    }
  }

  void read_links() {
    constexpr std::size_t kBytes = 2 * 8 + 7 * 8 + 36 * 8;
    const std::string bytes = section(kLinks).content;
    ByteReader reader(bytes);
    map_.links.resize(count(reader, kMostLinks, kBytes, kLinks));
    for (MapLink& link : map_.links) {
      link.from = reader.number<std::int64_t>();
      link.to = reader.number<std::int64_t>();
      link.from_pose_to = take_pose(reader);
      link.information = take_matrix(reader);
      require(is_pair(link.from, link.to) && is_valid(link.from_pose_to) &&
                  link.information.allFinite(),
              kLinks);
    }
  }

  void read_view() {
    const Section found = section(kView);
    std::optional<Place> view = decode_view(found.content, map_.origin.camera);
    require(view && view->id >= 0 && view->id < static_cast<KeyframeId>(map_.keyframes.size()) &&
                (map_.views.empty() || view->id > map_.views.back().id),
            kView);
    view->stamp = map_.keyframes[static_cast<std::size_t>(view->id)].stamp;
    map_.views.push_back(std::move(*view));
  }

  SectionReader file_;
  SavedMap map_;
};

}  // namespace

void require_map_or_nothing(const std::filesystem::path& path) {
  if (!would_be_lost(path)) return;
  std::string magic(kFormat.magic.size(), '\0');
  std::ifstream(path, std::ios::binary).read(magic.data(), std::ssize(magic));
  if (magic != kFormat.magic)
    throw Error(ErrorCode::kOutput,
                fmt::format("{}: is no map of edvo, and is not replaced by one; give another file",
                            path.string()));
}

void save_map(const std::filesystem::path& path, const SavedMap& map) {
  require_map_or_nothing(path);
  SectionWriter file(path, kFormat);
  file.add(kHead, head_bytes(map));
  file.add(kPoses, pose_bytes(map));
  file.add(kSteps, step_bytes(map));
  file.add(kLinks, link_bytes(map));
  for (const Place& view : map.views) file.add(kView, encode_view(view));
  file.finish();
}

SavedMap load_map(const std::filesystem::path& path) {
  return MapReader(path).read();
}

}  // namespace edvo

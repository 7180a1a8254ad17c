// SPDX-License-Identifier: MIT
// Map files: as they are; as sections with the right checksums, so that what comes after these is
// reached; and the bytes of a keyframe's images alone.
#include "edvo/core/error.hpp"
#include "edvo/io/byte_codec.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/saved_map/view_bytes.hpp"
#include "fuzz/memory_file.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <cmath>

using namespace edvo;

namespace {

void append_checksum(std::string& bytes, std::size_t from) {
  append_number(bytes, libdeflate_crc32(0, bytes.data() + from, bytes.size() - from));
}

// Content as deflate stores what it does not compress.
void append_section(std::string& file, std::string_view name, std::string_view content) {
  std::string stored(1, '\1');
  const auto size = static_cast<std::uint32_t>(content.size());
  append_number(stored, size | (~size << 16));
  stored += content;
  std::size_t start = file.size();
  file += name;
  append_number(file, std::uint64_t{content.size()});
  append_number(file, std::uint64_t{stored.size()});
  append_checksum(file, start);
  start = file.size();
  file += stored;
  append_checksum(file, start);
}

// Each section but the last has its length in two bytes before it.
std::string sections_of(std::string_view bytes) {
  std::string file = "edvo-map";
  append_number(file, std::uint32_t{1});
  append_checksum(file, 0);
  std::size_t section = 0;
  while (!bytes.empty()) {
    constexpr std::string_view kNames[] = {"HEAD", "POSE", "STEP", "LINK", "VIEW"};
    std::size_t size = 0;
    for (std::size_t i = 0; i < 2 && !bytes.empty(); ++i, bytes.remove_prefix(1))
      size |= static_cast<std::size_t>(static_cast<unsigned char>(bytes.front())) << (8 * i);
    const std::string_view content = bytes.substr(0, size);
    append_section(file, kNames[std::min(section++, std::size(kNames) - 1)], content);
    bytes.remove_prefix(content.size());
  }
  append_section(file, "END ", {});
  return file;
}

void check(const SavedMap& map) {
  for (const MapKeyframe& key : map.keyframes) fuzz::require(is_finite(key.world_from_camera));
  const Camera& camera = map.origin.camera;
  for (const Place& view : map.views) {
    fuzz::require(view.gray.cols == camera.width && view.gray.rows == camera.height);
    for (const Eigen::Vector3f& point : view.points) {
      const Eigen::Vector2d pixel = project(camera, point.cast<double>());
      fuzz::require(std::lround(pixel.x()) >= 0 && std::lround(pixel.x()) < camera.width &&
                    std::lround(pixel.y()) >= 0 && std::lround(pixel.y()) < camera.height);
    }
  }
}

void read(const std::string& path) {
  try {
    check(load_map(path));
  } catch (const Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::MemoryFile file;
  const std::string_view text = fuzz::text_of(data, size);
  file.write(text);
  read(file.path());
  file.write(sections_of(text));
  read(file.path());
  const Camera camera{.fx = 8, .fy = -8.5, .cx = 4, .cy = 3, .width = 9, .height = 7};
  if (const auto view = decode_view(text, camera)) fuzz::require(encode_view(*view) == text);
  return 0;
}

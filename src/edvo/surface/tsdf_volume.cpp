// SPDX-License-Identifier: MIT
#include "edvo/surface/tsdf_volume.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/parallel.hpp"
#include "edvo/core/random.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace edvo {
namespace {

// A camera's measurement along the ray through a point.
struct Sample {
  float depth = 0;  // [m]
  cv::Vec3b rgb;
};

// By the inverse depths around, which are linear on a plane. None on a jump: what is there is not
// known to a pixel.
std::optional<Sample> sample_at(const DepthView& view, const Eigen::Vector2d& pixel) {
  constexpr float kJump = 0.05F;  // of the depth
  const int x = static_cast<int>(std::floor(pixel.x())),
            y = static_cast<int>(std::floor(pixel.y()));
  if (x < 0 || y < 0 || x + 1 >= view.depth.cols || y + 1 >= view.depth.rows) return std::nullopt;
  const float depths[4] = {view.depth(y, x), view.depth(y, x + 1), view.depth(y + 1, x),
                           view.depth(y + 1, x + 1)};
  const auto [nearest, farthest] = std::minmax_element(std::begin(depths), std::end(depths));
  for (const float z : depths)
    if (!(z > 0)) return std::nullopt;
  if (*farthest - *nearest > kJump * *nearest) return std::nullopt;
  const auto fx = static_cast<float>(pixel.x() - x), fy = static_cast<float>(pixel.y() - y);
  const float inverse = (1 - fy) * ((1 - fx) / depths[0] + fx / depths[1]) +
                        fy * ((1 - fx) / depths[2] + fx / depths[3]);
  return Sample{.depth = 1 / inverse, .rgb = view.rgb(y + (fy > 0.5F), x + (fx > 0.5F))};
}

void add(Voxel& voxel, float distance, float weight, const cv::Vec3b& rgb) {
  const float total = voxel.weight + weight, share = weight / total;
  voxel.distance += share * (distance - voxel.distance);
  voxel.weight = total;
  for (int c = 0; c < 3; ++c) {
    auto& channel = voxel.rgb[static_cast<std::size_t>(c)];
    const float old = channel;
    channel =
        static_cast<std::uint8_t>(std::lround(old + share * (static_cast<float>(rgb[c]) - old)));
  }
}

void integrate_block(const DepthView& view, const SE3& camera_from_world,
                     const VolumeOptions& options, VoxelBlock& block) {
  const Eigen::Matrix3d rotation = camera_from_world.rotation.toRotationMatrix();
  const double truncation = options.voxel * options.truncation;
  std::size_t i = 0;
  for (int z = 0; z < kBlockSide; ++z)
    for (int y = 0; y < kBlockSide; ++y)
      for (int x = 0; x < kBlockSide; ++x, ++i) {
        const Eigen::Vector3d world =
            options.voxel * (kBlockSide * block.corner + Eigen::Vector3i(x, y, z)).cast<double>();
        const Eigen::Vector3d p = rotation * world + camera_from_world.translation;
        if (!(p.z() > options.voxel)) continue;
        const std::optional<Sample> sample = sample_at(view, project(view.camera, p));
        if (!sample || sample->depth > options.max_depth) continue;
        const double distance = (static_cast<double>(sample->depth) - p.z()) / truncation;
        if (distance <= -1) continue;
        // Sigma of depth grows with its square; what lies behind the surface is less and less sure.
        const double depth2 =
            static_cast<double>(sample->depth) * static_cast<double>(sample->depth);
        const double weight = std::min(1.0, 1 + distance) / (depth2 * depth2);
        add(block.voxels[i], static_cast<float>(std::min(1.0, distance)),
            static_cast<float>(weight), sample->rgb);
      }
}

std::array<int, 3> key_of(const Eigen::Vector3i& corner) {
  return {corner.x(), corner.y(), corner.z()};
}

}  // namespace

std::size_t TsdfVolume::Hash::operator()(const std::array<int, 3>& corner) const {
  std::uint64_t word = 0;
  for (const int value : corner) word = mix(word + static_cast<std::uint32_t>(value) + 1);
  return word;
}

const VoxelBlock* TsdfVolume::find(const Eigen::Vector3i& corner) const {
  const auto found = index_.find(key_of(corner));
  return found == index_.end() ? nullptr : &blocks_[static_cast<std::size_t>(found->second)];
}

int TsdfVolume::block_at(const Eigen::Vector3i& corner) {
  const auto [entry, is_new] = index_.try_emplace(key_of(corner), static_cast<int>(blocks_.size()));
  if (is_new) {
    if (blocks_.size() == options_.max_blocks)
      throw Error(ErrorCode::kResources,
                  fmt::format("the surface needs more than {} blocks of voxels of {} m; choose "
                              "larger voxels",
                              options_.max_blocks, options_.voxel));
    VoxelBlock& block = blocks_.emplace_back();
    block.index = entry->second;
    block.corner = corner;
  }
  return entry->second;
}

// All blocks within the truncation of a pixel's surface, each once.
std::vector<int> TsdfVolume::touched_blocks(const DepthView& view) {
  const double truncation = options_.voxel * options_.truncation;
  const double side = options_.voxel * kBlockSide;
  std::vector<int> touched;
  Eigen::Vector3i last = Eigen::Vector3i::Constant(std::numeric_limits<int>::min());
  for (int y = 0; y < view.depth.rows; ++y)
    for (int x = 0; x < view.depth.cols; ++x) {
      const double depth = static_cast<double>(view.depth(y, x));
      if (!(depth > 0) || depth > options_.max_depth) continue;
      for (double d = std::max(0.0, depth - truncation); d <= depth + truncation; d += side / 4) {
        const Eigen::Vector3d point = view.world_from_camera * back_project(view.camera, x, y, d);
        // Voxel i lies at i * voxel: the block of the nearest one.
        const Eigen::Vector3i corner =
            ((point / options_.voxel).array().round() / kBlockSide).floor().cast<int>();
        if (corner == last) continue;
        last = corner;
        touched.push_back(block_at(corner));
      }
    }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  return touched;
}

void TsdfVolume::integrate(const DepthView& view, int threads) {
  const SE3 camera_from_world = inverse(view.world_from_camera);
  const std::vector<int> touched = touched_blocks(view);
  for_each_index(static_cast<int>(touched.size()), threads, [&](int i) {
    const auto block = static_cast<std::size_t>(touched[static_cast<std::size_t>(i)]);
    integrate_block(view, camera_from_world, options_, blocks_[block]);
  });
}

}  // namespace edvo

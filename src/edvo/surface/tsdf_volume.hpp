// SPDX-License-Identifier: MIT
// A surface from many depth images: truncated signed distances (Curless, Levoy 1996) in blocks of
// 8 x 8 x 8 voxels that exist where there is a surface (Niessner and others 2013).
#pragma once

#include "edvo/core/mesh.hpp"
#include "edvo/surface/depth_view.hpp"

#include <array>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

namespace edvo {

struct VolumeOptions {
  double voxel = 0.01;               // [m]
  double truncation = 4;             // distance beyond which a surface tells nothing [voxels]
  double max_depth = 4;              // farther ones are left out [m]
  std::size_t max_blocks = 400'000;  // 6 kB each
};

struct Voxel {
  float distance = 0;  // to the nearest surface, positive in front of it [truncations]
  float weight = 0;    // of what was measured, 0 = nothing
  std::array<std::uint8_t, 3> rgb = {0, 0, 0};
};

constexpr int kBlockSide = 8;  // [voxels]
constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

struct VoxelBlock {
  int index = 0;                                     // in the order in which they were met
  Eigen::Vector3i corner = Eigen::Vector3i::Zero();  // [blocks]
  std::array<Voxel, kBlockVoxels> voxels{};          // x fastest
};

class TsdfVolume {
 public:
  explicit TsdfVolume(const VolumeOptions& options) : options_(options) {}

  // Adds what one camera measured. The same for any number of threads. Throws Error(kResources) if
  // there would be more blocks than allowed.
  void integrate(const DepthView& view, int threads);

  [[nodiscard]] const std::deque<VoxelBlock>& blocks() const { return blocks_; }
  [[nodiscard]] const VolumeOptions& options() const { return options_; }

  // Null where there is none.
  [[nodiscard]] const VoxelBlock* find(const Eigen::Vector3i& corner) const;

 private:
  struct Hash {
    std::size_t operator()(const std::array<int, 3>& corner) const;
  };

  [[nodiscard]] std::vector<int> touched_blocks(const DepthView& view);
  [[nodiscard]] int block_at(const Eigen::Vector3i& corner);

  VolumeOptions options_;
  std::deque<VoxelBlock> blocks_;  // which do not move when it grows
  std::unordered_map<std::array<int, 3>, int, Hash> index_;
};

}  // namespace edvo

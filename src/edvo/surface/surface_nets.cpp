// SPDX-License-Identifier: MIT
#include "edvo/surface/surface_nets.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace edvo {
namespace {

constexpr int kCorners = 8;

int floor_block(int voxel) {
  return voxel >= 0 ? voxel / kBlockSide : (voxel - kBlockSide + 1) / kBlockSide;
}

std::size_t within_block(int x, int y, int z) {
  return static_cast<std::size_t>((z * kBlockSide + y) * kBlockSide + x);
}

Eigen::Vector3i corner_offset(int corner) {
  return {corner & 1, corner >> 1 & 1, corner >> 2 & 1};
}

bool by_corner(const VoxelBlock* a, const VoxelBlock* b) {
  const Eigen::Vector3i &p = a->corner, &q = b->corner;
  return std::tuple(p.z(), p.y(), p.x()) < std::tuple(q.z(), q.y(), q.x());
}

// The voxels that the cells of a block touch, those of seven neighbours among them.
class Patch {
 public:
  Patch(const TsdfVolume& volume, const VoxelBlock& block) {
    for (int corner = 0; corner < kCorners; ++corner)
      blocks_[static_cast<std::size_t>(corner)] =
          corner == 0 ? &block : volume.find(block.corner + corner_offset(corner));
  }

  // Each coordinate in [0..kBlockSide]; null where nothing was measured.
  [[nodiscard]] const Voxel* at(const Eigen::Vector3i& v) const {
    const int corner = (v.x() == kBlockSide ? 1 : 0) + (v.y() == kBlockSide ? 2 : 0) +
                       (v.z() == kBlockSide ? 4 : 0);
    const VoxelBlock* const block = blocks_[static_cast<std::size_t>(corner)];
    if (block == nullptr) return nullptr;
    const Voxel& voxel =
        block->voxels[within_block(v.x() % kBlockSide, v.y() % kBlockSide, v.z() % kBlockSide)];
    return voxel.weight > 0 ? &voxel : nullptr;
  }

 private:
  std::array<const VoxelBlock*, kCorners> blocks_{};
};

using CellVoxels = std::array<const Voxel*, kCorners>;

// None if something is not known or the surface does not cross the cell.
std::optional<CellVoxels> crossed_cell(const Patch& patch, const Eigen::Vector3i& cell) {
  CellVoxels voxels{};
  int inside = 0;
  for (int corner = 0; corner < kCorners; ++corner) {
    const Voxel* const voxel = patch.at(cell + corner_offset(corner));
    if (voxel == nullptr) return std::nullopt;
    voxels[static_cast<std::size_t>(corner)] = voxel;
    inside += voxel->distance < 0 ? 1 : 0;
  }
  if (inside == 0 || inside == kCorners) return std::nullopt;
  return voxels;
}

// In the mean of the crossings, with the mean colour of the voxels next to them. In voxels from the
// cell's first one.
ColoredPoint vertex_of(const CellVoxels& voxels) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero(), rgb = Eigen::Vector3f::Zero();
  float crossings = 0;
  for (int a = 0; a < kCorners; ++a)
    for (const int axis : {1, 2, 4}) {
      const int b = a | axis;
      if (b == a) continue;
      const Voxel &u = *voxels[static_cast<std::size_t>(a)],
                  &v = *voxels[static_cast<std::size_t>(b)];
      if ((u.distance < 0) == (v.distance < 0)) continue;
      const float share = u.distance / (u.distance - v.distance);
      const Eigen::Vector3f from = corner_offset(a).cast<float>(),
                            to = corner_offset(b).cast<float>();
      sum += from + share * (to - from);
      const Voxel& nearer = share < 0.5F ? u : v;
      rgb += Eigen::Vector3f(nearer.rgb[0], nearer.rgb[1], nearer.rgb[2]);
      crossings += 1;
    }
  ColoredPoint vertex{.position = sum / crossings};
  for (std::size_t c = 0; c < 3; ++c)
    vertex.rgb[c] =
        static_cast<std::uint8_t>(std::lround(rgb[static_cast<Eigen::Index>(c)] / crossings));
  return vertex;
}

class Extraction {
 public:
  explicit Extraction(const TsdfVolume& volume) : volume_(volume) {
    for (const VoxelBlock& block : volume.blocks()) order_.push_back(&block);
    std::sort(order_.begin(), order_.end(), by_corner);
    for (const VoxelBlock* const block : order_) add_vertices(*block);
    for (const VoxelBlock* const block : order_) add_triangles(*block);
  }

  [[nodiscard]] Mesh take() { return std::move(mesh_); }

 private:
  using BlockVertices = std::array<std::int32_t, kBlockVoxels>;  // -1 = none

  [[nodiscard]] static std::size_t index_of(const VoxelBlock& block) {
    return static_cast<std::size_t>(block.index);
  }

  void add_vertices(const VoxelBlock& block) {
    if (vertices_.empty()) vertices_.resize(volume_.blocks().size());
    const Patch patch(volume_, block);
    for (int z = 0; z < kBlockSide; ++z)
      for (int y = 0; y < kBlockSide; ++y)
        for (int x = 0; x < kBlockSide; ++x) {
          const std::optional<CellVoxels> voxels = crossed_cell(patch, {x, y, z});
          if (!voxels) continue;
          std::unique_ptr<BlockVertices>& mine = vertices_[index_of(block)];
          if (!mine) {
            mine = std::make_unique<BlockVertices>();
            mine->fill(-1);
          }
          (*mine)[within_block(x, y, z)] = static_cast<std::int32_t>(mesh_.vertices.size());
          ColoredPoint vertex = vertex_of(*voxels);
          const Eigen::Vector3i first = kBlockSide * block.corner + Eigen::Vector3i(x, y, z);
          vertex.position =
              static_cast<float>(volume_.options().voxel) * (first.cast<float>() + vertex.position);
          mesh_.vertices.push_back(vertex);
        }
  }

  [[nodiscard]] std::int32_t vertex_at(const Eigen::Vector3i& cell) const {
    const Eigen::Vector3i corner = cell.unaryExpr(&floor_block);
    const VoxelBlock* const block = volume_.find(corner);
    if (block == nullptr) return -1;
    const std::unique_ptr<BlockVertices>& vertices = vertices_[index_of(*block)];
    if (!vertices) return -1;
    const Eigen::Vector3i v = cell - kBlockSide * corner;
    return (*vertices)[within_block(v.x(), v.y(), v.z())];
  }

  // Two triangles around each edge, from a voxel of this block along each axis, that is crossed.
  void add_triangles(const VoxelBlock& block) {
    const Patch patch(volume_, block);
    for (int z = 0; z < kBlockSide; ++z)
      for (int y = 0; y < kBlockSide; ++y)
        for (int x = 0; x < kBlockSide; ++x) {
          const Voxel* const from = patch.at({x, y, z});
          if (from == nullptr) continue;
          for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
            const Voxel* const to = patch.at(Eigen::Vector3i(x, y, z) + step);
            if (to == nullptr || (from->distance < 0) == (to->distance < 0)) continue;
            add_around(kBlockSide * block.corner + Eigen::Vector3i(x, y, z), axis,
                       from->distance < 0);
          }
        }
  }

  // outward: the edge's direction leads out of the surface.
  void add_around(const Eigen::Vector3i& voxel, int axis, bool outward) {
    const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3),
                          v = Eigen::Vector3i::Unit((axis + 2) % 3);
    std::array<std::int32_t, 4> ring = {vertex_at(voxel - u - v), vertex_at(voxel - v),
                                        vertex_at(voxel), vertex_at(voxel - u)};
    if (std::any_of(ring.begin(), ring.end(), [](std::int32_t i) { return i < 0; })) return;
    if (!outward) std::swap(ring[1], ring[3]);
    const auto at = [&ring](std::size_t i) { return static_cast<std::uint32_t>(ring[i]); };
    mesh_.triangles.push_back({at(0), at(1), at(2)});
    mesh_.triangles.push_back({at(0), at(2), at(3)});
  }

  const TsdfVolume& volume_;
  std::vector<const VoxelBlock*> order_;
  std::vector<std::unique_ptr<BlockVertices>>
      vertices_;  // of the cells of each block, by its index
  Mesh mesh_;
};

// For each vertex the lowest one that triangles connect it with.
std::vector<std::uint32_t> connected_parts(const Mesh& mesh) {
  std::vector<std::uint32_t> part(mesh.vertices.size());
  std::iota(part.begin(), part.end(), 0U);
  const auto root = [&part](std::uint32_t i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  for (const auto& triangle : mesh.triangles)
    for (const std::size_t k : {1, 2}) {
      const std::uint32_t a = root(triangle[0]), b = root(triangle[k]);
      part[std::max(a, b)] = std::min(a, b);
    }
  for (std::uint32_t i = 0; i < part.size(); ++i) part[i] = root(i);
  return part;
}

// Without small parts, and without vertices that no triangle has.
Mesh without_small_parts(const Mesh& mesh, int min_part) {
  const std::vector<std::uint32_t> part = connected_parts(mesh);
  std::vector<int> size(mesh.vertices.size(), 0);
  for (const auto& triangle : mesh.triangles) ++size[part[triangle[0]]];
  std::vector<std::uint32_t> renamed(mesh.vertices.size());
  Mesh kept;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    renamed[i] = static_cast<std::uint32_t>(kept.vertices.size());
    if (size[part[i]] >= std::max(min_part, 1)) kept.vertices.push_back(mesh.vertices[i]);
  }
  for (const auto& [a, b, c] : mesh.triangles)
    if (size[part[a]] >= min_part) kept.triangles.push_back({renamed[a], renamed[b], renamed[c]});
  return kept;
}

}  // namespace

Mesh extract_mesh(const TsdfVolume& volume, const MeshOptions& options) {
  return without_small_parts(Extraction(volume).take(), options.min_part);
}

}  // namespace edvo

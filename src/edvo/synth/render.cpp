// SPDX-License-Identifier: MIT
#include "edvo/synth/render.hpp"

#include "edvo/synth/parallel.hpp"
#include "edvo/synth/shade.hpp"

#include <algorithm>
#include <limits>

namespace edvo::synth {
namespace {

constexpr int kTile = 16;  // [px]
constexpr int kNoSurface = -1;

// A number for each face of each solid.
int surface_of(const Hit& hit) {
  return hit.solid < 0 ? kNoSurface : hit.solid * 8 + hit.face;
}
Hit hit_of(int surface, float depth) {
  return {.depth = depth, .solid = surface / 8, .face = surface % 8};
}

// The solids that the pixels of a tile may meet; border samples reach into the next pixel.
std::vector<int> candidates_in(const View& view, const cv::Rect& tile) {
  Eigen::AlignedBox2f window;
  for (int y = tile.y; y <= tile.y + tile.height; ++y)
    for (int x = tile.x; x <= tile.x + tile.width; ++x)
      window.extend(Eigen::Vector2f(view.rays(y, x)[0], view.rays(y, x)[1]));
  const Eigen::Vector2f margin = Eigen::Vector2f::Constant(2 * view.pixel_angle);
  const Eigen::AlignedBox2f widened(Eigen::Vector2f(window.min() - margin),
                                    Eigen::Vector2f(window.max() + margin));
  std::vector<int> candidates;
  for (const int i : view.order)
    if (view.solids[i].bounds.intersects(widened)) candidates.push_back(i);
  return candidates;
}

// All eight neighbours show the same face.
bool is_inner(const cv::Mat_<int>& surfaces, int x, int y) {
  const int surface = surfaces(y, x);
  const int left = std::max(x - 1, 0), right = std::min(x + 1, surfaces.cols - 1);
  for (const int row : {std::max(y - 1, 0), y, std::min(y + 1, surfaces.rows - 1)}) {
    const int* of_row = surfaces[row];
    if (of_row[left] != surface || of_row[x] != surface || of_row[right] != surface) return false;
  }
  return true;
}

}  // namespace

Render render(const Scene& scene, double seconds, const SE3& world_from_camera,
              const cv::Mat_<cv::Vec2f>& rays, int threads) {
  const View view = make_warp(scene, seconds, world_from_camera, rays);
  const int width = rays.cols - 1, height = rays.rows - 1;
  const int tiles_x = (width + kTile - 1) / kTile, tiles_y = (height + kTile - 1) / kTile;
  Render image{.bgr = cv::Mat_<cv::Vec3f>(height, width),
               .depth = cv::Mat_<float>(height, width),
               .incidence = cv::Mat_<float>(height, width)};
  cv::Mat_<int> surfaces(height, width);
  std::vector<std::vector<int>> candidates(static_cast<std::size_t>(tiles_x * tiles_y));

  const auto for_each_tile = [&](const auto& function) {
    for_each_block(tiles_y, threads, [&](int row) {
      for (int column = 0; column < tiles_x; ++column) {
        const cv::Rect tile =
            cv::Rect(column * kTile, row * kTile, kTile, kTile) & cv::Rect(0, 0, width, height);
        function(tile, candidates[static_cast<std::size_t>(row * tiles_x + column)]);
      }
    });
  };
  for_each_tile([&](const cv::Rect& tile, std::vector<int>& nearby) {
    nearby = candidates_in(view, tile);
    const int end = tile.x + tile.width;
    for (int y = tile.y; y < tile.y + tile.height; ++y)
      for (int x = tile.x; x < end; x += kPack) {
        RayPack pack;
        for (int i = 0; i < kPack; ++i) {
          const cv::Vec2f& ray = rays(y, std::min(x + i, end - 1));
          pack.x[i] = ray[0];
          pack.y[i] = ray[1];
        }
        const std::array<Hit, kPack> hits = cast(view.solids, nearby, pack);
        for (int i = 0; i < std::min(kPack, end - x); ++i) {
          surfaces(y, x + i) = surface_of(hits[i]);
          image.depth(y, x + i) =
              hits[i].solid < 0 ? std::numeric_limits<float>::quiet_NaN() : hits[i].depth;
        }
      }
  });
  for_each_tile([&](const cv::Rect& tile, const std::vector<int>& nearby) {
    for (int y = tile.y; y < tile.y + tile.height; ++y)
      for (int x = tile.x; x < tile.x + tile.width; ++x) {
        const int surface = surfaces(y, x);
        const Hit hit = hit_of(surface, image.depth(y, x));
        Shade shade;
        if (surface != kNoSurface && is_inner(surfaces, x, y))
          shade = hit.face != kRoundFace ? shade_flat(view, hit, x, y)
                                         : shade_edge(view, {&hit.solid, 1}, hit, x, y);
        else if (surface != kNoSurface)
          shade = shade_edge(view, nearby, hit, x, y);
        image.bgr(y, x) = shade.bgr;
        image.incidence(y, x) = shade.incidence;
      }
  });
  return image;
}

}  // namespace edvo::synth

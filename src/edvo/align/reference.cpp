// SPDX-License-Identifier: MIT
#include "edvo/align/reference.hpp"

#include "edvo/align/bilinear.hpp"
#include "edvo/align/warp.hpp"
#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <utility>

namespace edvo {
namespace {

using simd::Float8;
using simd::Int8;

// What the arrays of a level hold.
enum Array { kX, kY, kZ, kIntensity, kWeight, kJacobian, kArrays = kJacobian + 6 };

using Arrays = std::array<std::vector<float>*, kArrays>;

Arrays arrays_of(ReferenceLevel& level) {
  Arrays arrays = {&level.x, &level.y, &level.z, &level.intensity, &level.weight};
  for (std::size_t k = 0; k < 6; ++k) arrays[kJacobian + k] = &level.jacobian[k];
  return arrays;
}

struct LevelConstants {
  float scale;               // of the level's pixels by those of the full image
  float fx, fy, cx, cy;      // of the full image
  float level_fx, level_fy;  // of the level
  float softness_squared;
  RowMotion rows;
};

// Of the points that lie inside the level's image; returns how many. out: kArrays arrays with room
// for all and simd::kWidth more.
EDVO_CLONES std::size_t fill_level(const SelectedPixel* pixels, std::size_t count,
                                   const cv::Mat_<std::uint8_t>& gray, const LevelConstants& c,
                                   float* const* out) {
  const float limit_u = static_cast<float>(gray.cols - 2);
  const float limit_v = static_cast<float>(gray.rows - 2);
  if (gray.cols < 4 || gray.rows < 4) return 0;
  std::size_t filled = 0;
  for (std::size_t i = 0; i < count; i += simd::kWidth) {
    Float8 x{}, y{}, z{};
    for (std::size_t k = 0; k < simd::kWidth && i + k < count; ++k) {
      x[k] = static_cast<float>(pixels[i + k].pixel.x);
      y[k] = static_cast<float>(pixels[i + k].pixel.y);
      z[k] = pixels[i + k].depth;
    }
    const Float8 u = x * c.scale, v = y * c.scale;
    const Int8 within = (u >= 1.F) & (v >= 1.F) & (u < limit_u) & (v < limit_v) & (z > 0.F);
    std::int32_t all = -1;
    for (std::size_t k = 0; k < simd::kWidth; ++k) all &= within[k];
    Samples image;
    sample(gray, within ? u : Float8{} + 1.F, within ? v : Float8{} + 1.F, image);
    const Float8 &gx = image.gx, &gy = image.gy;
    Float8 px = (x - c.cx) / c.fx * z, py = (y - c.cy) / c.fy * z;
    if (!c.rows.is_none) move_to_middle_row<Float8>(c.rows, y, px, py, z, Float8{} + 1.F);
    // d (u, v) / d xi for a point moved by exp(xi), contracted with the image gradient.
    const Float8 inverse_z = 1.F / z;
    const Float8 a = gx * c.level_fx * inverse_z, b = gy * c.level_fy * inverse_z;
    const Float8 d = -(a * px + b * py) * inverse_z;
    // rho: (a, b, d); phi: p x (a, b, d), because d(exp(xi) p) / d phi = -[p]x.
    const Float8 values[kArrays] = {px,
                                    py,
                                    z,
                                    image.value,
                                    c.softness_squared / (c.softness_squared + gx * gx + gy * gy),
                                    a,
                                    b,
                                    d,
                                    py * d - z * b,
                                    z * a - px * d,
                                    px * b - py * a};
    if (all != 0) {
      for (int n = 0; n < kArrays; ++n) simd::store(out[n] + filled, values[n]);
      filled += simd::kWidth;
      continue;
    }
    for (std::size_t k = 0; k < simd::kWidth; ++k) {
      if (within[k] == 0) continue;
      for (int n = 0; n < kArrays; ++n) out[n][filled] = values[n][k];
      ++filled;
    }
  }
  return filled;
}

}  // namespace

Reference make_reference(const Frame& frame, const std::vector<SelectedPixel>& pixels,
                         const ReferenceOptions& options, Reference recycled) {
  Reference reference = std::move(recycled);
  reference.levels.resize(frame.levels.size());
  reference.surface.clear();
  reference.velocity = frame.shutter.velocity;
  const Camera& full = frame.levels.front().camera;
  for (std::size_t l = 0; l < frame.levels.size(); ++l) {
    const Level& source = frame.levels[l];
    ReferenceLevel& level = reference.levels[l];
    level.camera = source.camera;
    level.count = 0;
    const Arrays arrays = arrays_of(level);
    if (static_cast<int>(l) < options.finest_level ||
        static_cast<int>(l) > options.coarsest_level) {
      for (std::vector<float>* array : arrays) array->clear();
      continue;
    }
    std::array<float*, kArrays> out;
    for (std::size_t n = 0; n < kArrays; ++n) {
      arrays[n]->resize(pixels.size() + simd::kWidth);
      out[n] = arrays[n]->data();
    }
    level.count = fill_level(pixels.data(), pixels.size(), source.gray,
                             {.scale = 1.F / static_cast<float>(1 << l),
                              .fx = static_cast<float>(full.fx),
                              .fy = static_cast<float>(full.fy),
                              .cx = static_cast<float>(full.cx),
                              .cy = static_cast<float>(full.cy),
                              .level_fx = static_cast<float>(source.camera.fx),
                              .level_fy = static_cast<float>(source.camera.fy),
                              .softness_squared = static_cast<float>(options.gradient_weight_scale *
                                                                     options.gradient_weight_scale),
                              .rows = row_motion(frame.shutter.readout(), full.height)},
                             out.data());
    for (std::vector<float>* array : arrays) {
      array->resize(level.count);
      array->resize(simd::padded(level.count));  // by zeros
    }
  }
  return reference;
}

}  // namespace edvo

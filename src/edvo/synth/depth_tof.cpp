// SPDX-License-Identifier: MIT
// Time of flight. Light is a phasor: amplitude as an intensity, angle by the length of its way.
#include "edvo/synth/depth_models.hpp"
#include "edvo/synth/parallel.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace edvo::synth {
namespace {

constexpr float kAmbiguity = 9.4F;  // range of one turn of the phase, 16 MHz after unwrapping [m]
constexpr float kWaveNumber = 2 * std::numbers::pi_v<float> / kAmbiguity;  // [rad/m]
constexpr int kCell = 16;                                                  // [px]

float reflectance(const cv::Vec3f& bgr) {
  constexpr float kDarkest = 0.05F;
  return std::clamp((bgr[0] + bgr[1] + bgr[2]) / (3 * 255), kDarkest, 1.0F);
}

// A piece of surface, for light that is reflected twice.
struct Patch {
  Eigen::Vector3f point = Eigen::Vector3f::Zero();   // [m]
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // to the camera; zero: unknown
  float area = 0;                                    // [m^2]
  float direct = 0;                                  // light from the sensor [1/m^2]
  float reflectance = 0;
};

Patch patch_at(const Render& exact, int x, int y, float focal) {
  constexpr int kStep = 2;        // [px]
  constexpr float kJump = 0.05F;  // of the depth
  Patch patch;
  if (x < kStep || y < kStep || x >= exact.depth.cols - kStep || y >= exact.depth.rows - kStep)
    return patch;
  const auto point = [&](int at_x, int at_y) {
    const float z = exact.depth(at_y, at_x);
    return Eigen::Vector3f(
        z * (static_cast<float>(at_x) - 0.5F * static_cast<float>(exact.depth.cols)) / focal,
        z * (static_cast<float>(at_y) - 0.5F * static_cast<float>(exact.depth.rows)) / focal, z);
  };
  patch.point = point(x, y);
  const Eigen::Vector3f left = point(x - kStep, y), right = point(x + kStep, y);
  const Eigen::Vector3f top = point(x, y - kStep), bottom = point(x, y + kStep);
  for (const Eigen::Vector3f& side : {left, right, top, bottom})
    if (!(std::abs(side.z() - patch.point.z()) < kJump * patch.point.z())) return patch;
  const Eigen::Vector3f normal = (bottom - top).cross(right - left).normalized();
  const float range = patch.point.norm();
  constexpr float kLeastCosine = 0.05F;
  const float cosine = std::max(-normal.dot(patch.point) / range, kLeastCosine);
  const float side = kCell * range / focal;
  patch.normal = normal;
  patch.area = side * side / cosine;
  patch.direct = cosine / (range * range);
  patch.reflectance = reflectance(exact.bgr(y, x));
  return patch;
}

// How much farther a patch seems because of light that came by way of the others [m].
float multipath(const Patch& patch, const std::vector<Patch>& others) {
  std::complex<float> light = patch.direct;
  for (const Patch& other : others) {
    const Eigen::Vector3f between = other.point - patch.point;
    const float squared = between.squaredNorm();
    const float here = patch.normal.dot(between), there = -other.normal.dot(between);
    if (here <= 0 || there <= 0 || squared <= 0) continue;
    const float distance = std::sqrt(squared);
    const float form =
        here * there / squared * other.area / (std::numbers::pi_v<float> * squared + other.area);
    const float detour = 0.5F * (other.point.norm() + distance - patch.point.norm());
    light += std::polar(other.reflectance * other.direct * form, kWaveNumber * detour);
  }
  return std::arg(light) / kWaveNumber;
}

cv::Mat_<float> multipath_of(const Render& exact, const Shot& shot) {
  const int columns = (exact.depth.cols + kCell - 1) / kCell;
  const int rows = (exact.depth.rows + kCell - 1) / kCell;
  std::vector<Patch> patches;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      patches.push_back(patch_at(exact, column * kCell + kCell / 2, row * kCell + kCell / 2,
                                 static_cast<float>(shot.focal_length)));
  cv::Mat_<float> coarse(rows, columns, 0.0F);
  for_each_block(rows, shot.threads, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const Patch& patch = patches[static_cast<std::size_t>(row * columns + column)];
      if (patch.area > 0) coarse(row, column) = multipath(patch, patches);
    }
  });
  cv::Mat_<float> fine;
  cv::resize(coarse, fine, {columns * kCell, rows * kCell}, 0, 0, cv::INTER_LINEAR);
  return fine(cv::Rect({0, 0}, exact.depth.size())).clone();
}

// The light that the pixels gather: each a sharp phasor, then mixed over the footprint.
cv::Mat_<cv::Vec2f> gathered_light(const Render& exact, const Shot& shot) {
  cv::Mat_<cv::Vec2f> light(exact.depth.size());
  for_each_block(light.rows, shot.threads, [&](int y) {
    for (int x = 0; x < light.cols; ++x) {
      const float z = exact.depth(y, x);
      const float amplitude =
          std::isnan(z) ? 0 : reflectance(exact.bgr(y, x)) * exact.incidence(y, x) / (z * z);
      const float angle = std::isnan(z) ? 0 : kWaveNumber * z;
      light(y, x) = {amplitude * std::cos(angle), amplitude * std::sin(angle)};
    }
  });
  cv::GaussianBlur(light, light, {3, 3}, 0, 0, cv::BORDER_REFLECT_101);
  return light;
}

}  // namespace

cv::Mat_<float> tof_depth(const Render& exact, const Shot& shot) {
  constexpr float kWiggle = 0.004F, kWigglePeriod = 0.47F;  // [m]
  constexpr float kNoise = 0.4e-3F;  // sigma where the light coming back is 1 [m]
  constexpr float kLeastLight = 0.004F;
  const cv::Mat_<cv::Vec2f> light = gathered_light(exact, shot);
  const cv::Mat_<float> detour = multipath_of(exact, shot);
  cv::Mat_<float> depth(exact.depth.size(), kNoDepth);
  for_each_block(depth.rows, shot.threads, [&](int y) {
    Random random = shot.row(kDepthStream, y);
    for (int x = 0; x < depth.cols; ++x) {
      const float unit = random.normal();
      const float amplitude = std::hypot(light(y, x)[0], light(y, x)[1]);
      if (amplitude < kLeastLight) continue;
      float angle = std::atan2(light(y, x)[1], light(y, x)[0]);
      if (angle < 0) angle += 2 * std::numbers::pi_v<float>;
      const float z = angle / kWaveNumber + detour(y, x);
      depth(y, x) = z + kWiggle * std::sin(2 * std::numbers::pi_v<float> * z / kWigglePeriod) +
                    kNoise / amplitude * unit;
    }
  });
  return depth;
}

}  // namespace edvo::synth

// SPDX-License-Identifier: MIT
#include "edvo/align/edge_distance.hpp"

#include "edvo/align/robust.hpp"
#include "edvo/align/warp.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

constexpr float kOnEdge = 1.F;    // [px] a keyframe's point at most so far from its edges is on one
constexpr float kHuber = 1.345F;  // [sigmas]

// A value between pixels and its derivatives [1 / px].
struct Sample {
  float value, du, dv;
};

Sample sample(const cv::Mat_<float>& image, float u, float v) {
  const int x = static_cast<int>(u), y = static_cast<int>(v);
  const float a = u - static_cast<float>(x), b = v - static_cast<float>(y);
  const float* top = image[y] + x;
  const float* bottom = image[y + 1] + x;
  const float upper = top[0] + a * (top[1] - top[0]);
  const float lower = bottom[0] + a * (bottom[1] - bottom[0]);
  return {.value = upper + b * (lower - upper),
          .du = (1 - b) * (top[1] - top[0]) + b * (bottom[1] - bottom[0]),
          .dv = lower - upper};
}

}  // namespace

EdgeDistance make_edge_distance(const cv::Mat_<std::uint8_t>& edges, int levels) {
  cv::Mat_<float> full;
  // Without any edge OpenCV's distances are some large number: truncated like all others.
  cv::distanceTransform(~edges, full, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  EdgeDistance distance;
  for (int l = 0; l < levels; ++l) {
    const int stride = 1 << l;
    const float scale = 1.F / static_cast<float>(stride);
    cv::Mat_<float> level((full.rows + stride - 1) / stride, (full.cols + stride - 1) / stride);
    for (int y = 0; y < level.rows; ++y)
      for (int x = 0; x < level.cols; ++x)
        level(y, x) = std::min(scale * full(y * stride, x * stride), kFarthestEdge);
    distance.push_back(level);
  }
  return distance;
}

std::vector<Eigen::Vector3f> edge_points(const EdgeDistance& distance, const Camera& camera,
                                         const std::vector<SelectedPixel>& pixels) {
  std::vector<Eigen::Vector3f> points;
  for (const SelectedPixel& selected : pixels)
    if (distance.front()(selected.pixel) <= kOnEdge)
      points.push_back(
          back_project(camera, selected.pixel.x, selected.pixel.y, selected.depth).cast<float>());
  return points;
}

PoseSums sum_edge_distance(const std::vector<Eigen::Vector3f>& points, const Camera& camera,
                           const cv::Mat_<float>& distance, const SE3& cur_from_ref, float sigma,
                           float weight) {
  const Eigen::Matrix3f R = cur_from_ref.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = cur_from_ref.translation.cast<float>();
  const float fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const float cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const float limit_u = static_cast<float>(distance.cols - 1);
  const float limit_v = static_cast<float>(distance.rows - 1);
  const float inverse_sigma = 1.F / sigma;
  const double outside =
      static_cast<double>(robust(Loss::kHuber, kHuber, kFarthestEdge * inverse_sigma).cost);
  PoseSums sums;
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3f moved = R * p + t;
    const float inverse_z = 1.F / moved.z();
    const float x = moved.x() * inverse_z, y = moved.y() * inverse_z;
    const float u = fx * x + cx, v = fy * y + cy;
    if (!(moved.z() > kNearest && u >= 0 && v >= 0 && u < limit_u && v < limit_v)) {
      sums.cost += outside;
      continue;
    }
    const Sample d = sample(distance, u, v);
    const RobustValue value = robust(Loss::kHuber, kHuber, d.value * inverse_sigma);
    sums.cost += static_cast<double>(value.cost);
    // By the moved point, then turned back to the keyframe, where xi acts: d(exp(xi) p) / d xi =
    // [I | -[p]x].
    const float a = d.du * fx * inverse_z, b = d.dv * fy * inverse_z;
    const Eigen::Vector3f n = R.transpose() * Eigen::Vector3f(a, b, -(a * x + b * y));
    Vector6d jacobian;
    jacobian << n.cast<double>(), p.cross(n).cast<double>();
    const double w = static_cast<double>(value.weight * inverse_sigma * inverse_sigma);
    for (int row = 0; row < 6; ++row)
      for (int column = row; column < 6; ++column)
        sums.hessian(row, column) += w * jacobian[row] * jacobian[column];
    sums.gradient += w * static_cast<double>(d.value) * jacobian;
  }
  sums.hessian *= static_cast<double>(weight);
  sums.gradient *= static_cast<double>(weight);
  sums.cost *= static_cast<double>(weight);
  return sums;
}

}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/frame/undistort.hpp"

#include "edvo/core/error.hpp"

#include <limits>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

// Where the ideal pixel (u, v) lies in the distorted image, [px] (Brown 1966, as in OpenCV).
cv::Vec2f distort(const DistortedCamera& camera, double u, double v) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const Camera& c = camera.pinhole;
  const double x = (u - c.cx) / c.fx, y = (v - c.cy) / c.fy;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {static_cast<float>(c.fx * xd + c.cx), static_cast<float>(c.fy * yd + c.cy)};
}

}  // namespace

Undistortion make_undistortion(const DistortedCamera& camera) {
  const Camera& pinhole = camera.pinhole;
  if (pinhole.width <= 0 || pinhole.height <= 0 || pinhole.fx == 0 || pinhole.fy == 0)
    throw Error(ErrorCode::kCalibration, "camera: width, height, fx and fy must not be zero");
  Undistortion undistortion{
      .camera = pinhole, .map = {}, .interpolation = {}, .nearest = {}, .valid = {}};
  const cv::Size size(pinhole.width, pinhole.height);
  undistortion.valid = cv::Mat_<std::uint8_t>(size, std::uint8_t{255});
  if (!is_distorted(camera)) return undistortion;

  cv::Mat_<cv::Vec2f> map(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) map(y, x) = distort(camera, x, y);
  cv::convertMaps(map, cv::noArray(), undistortion.map, undistortion.interpolation, CV_16SC2);
  undistortion.nearest = cv::Mat_<cv::Vec2s>(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const cv::Vec2f source = map(y, x);
      undistortion.nearest.at<cv::Vec2s>(y, x) = {cv::saturate_cast<short>(source[0]),
                                                  cv::saturate_cast<short>(source[1])};
      const bool inside = source[0] >= 1.F && source[1] >= 1.F &&
                          source[0] <= static_cast<float>(size.width - 2) &&
                          source[1] <= static_cast<float>(size.height - 2);
      if (!inside) undistortion.valid(y, x) = 0;
    }
  return undistortion;
}

cv::Mat undistort_colour(const Undistortion& undistortion, const cv::Mat& image) {
  if (undistortion.map.empty()) return image;
  cv::Mat result;
  cv::remap(image, result, undistortion.map, undistortion.interpolation, cv::INTER_LINEAR,
            cv::BORDER_REPLICATE);
  return result;
}

cv::Mat_<float> undistort_depth(const Undistortion& undistortion, const cv::Mat_<float>& depth) {
  if (undistortion.nearest.empty()) return depth;
  cv::Mat_<float> result;
  cv::remap(depth, result, undistortion.nearest, cv::noArray(), cv::INTER_NEAREST,
            cv::BORDER_CONSTANT, cv::Scalar::all(std::numeric_limits<float>::quiet_NaN()));
  return result;
}

}  // namespace edvo

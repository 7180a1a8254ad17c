// SPDX-License-Identifier: MIT
#include "numpy.hpp"

#include "edvo/io/image_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace edvo::python {
namespace {

// A view; OpenCV knows no constant matrices.
template <typename T, typename Array>
cv::Mat_<T> view_of(const Array& array) {
  return cv::Mat_<T>(
      static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)),
      reinterpret_cast<T*>(const_cast<void*>(static_cast<const void*>(array.data()))));
}

}  // namespace

nb::object numpy_matrix(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  std::vector<double> values(static_cast<std::size_t>(matrix.size()));
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), matrix.rows(), matrix.cols()) = matrix;
  return numpy_array(std::move(values), {static_cast<std::size_t>(matrix.rows()),
                                         static_cast<std::size_t>(matrix.cols())});
}

nb::object numpy_pose(const SE3& target_from_source) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = target_from_source.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = target_from_source.translation;
  return numpy_matrix(matrix);
}

cv::Mat_<cv::Vec3b> to_bgr(const RgbArray& rgb) {
  cv::Mat_<cv::Vec3b> bgr;
  cv::cvtColor(view_of<cv::Vec3b>(rgb), bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

nb::object numpy_rgb(const cv::Mat_<cv::Vec3b>& bgr) {
  std::vector<std::uint8_t> values(bgr.total() * 3);
  cv::Mat_<cv::Vec3b> rgb(bgr.rows, bgr.cols, reinterpret_cast<cv::Vec3b*>(values.data()));
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return numpy_array(std::move(values),
                     {static_cast<std::size_t>(bgr.rows), static_cast<std::size_t>(bgr.cols), 3});
}

cv::Mat_<std::uint8_t> to_mask(const MaskArray& mask) {
  return view_of<std::uint8_t>(mask).clone();
}

nb::object numpy_mask(const cv::Mat_<std::uint8_t>& mask) {
  return numpy_array(std::vector<std::uint8_t>(mask.begin(), mask.end()),
                     {static_cast<std::size_t>(mask.rows), static_cast<std::size_t>(mask.cols)});
}

cv::Mat_<float> to_depth(const MetreArray& metres) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  constexpr float kLargest = std::numeric_limits<float>::max();
  cv::Mat_<float> depth(static_cast<int>(metres.shape(0)), static_cast<int>(metres.shape(1)));
  std::transform(metres.data(), metres.data() + metres.size(), depth[0],
                 [](float z) { return z > 0 && z <= kLargest ? z : kNone; });
  return depth;
}

cv::Mat_<float> to_depth(const UnitArray& raw, double units_per_metre) {
  return depth_to_metres(view_of<std::uint16_t>(raw), units_per_metre);
}

nb::object numpy_depth(const cv::Mat_<float>& depth) {
  const float* const first = depth[0];  // continuous, as every image that was just made
  return numpy_array(std::vector<float>(first, first + depth.total()),
                     {static_cast<std::size_t>(depth.rows), static_cast<std::size_t>(depth.cols)});
}

nb::tuple numpy_trajectory(const Trajectory& trajectory) {
  std::vector<std::int64_t> nanoseconds;
  std::vector<double> poses;
  std::vector<std::int64_t> segments;
  int decimals = 0;
  for (const StampedPose& pose : trajectory) {
    nanoseconds.push_back(pose.stamp.nanoseconds);
    segments.push_back(pose.segment);
    decimals = std::max(decimals, pose.stamp.decimals);
    const Eigen::Vector3d& t = pose.world_from_camera.translation;
    const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    poses.insert(poses.end(), {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
  }
  return nb::make_tuple(numpy_array(std::move(nanoseconds), {trajectory.size()}), decimals,
                        numpy_array(std::move(poses), {trajectory.size(), 7}),
                        numpy_array(std::move(segments), {trajectory.size()}));
}

Trajectory to_trajectory(const StampArray& nanoseconds, int decimals, const PoseArray& poses,
                         const StampArray& segments) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < nanoseconds.shape(0); ++i) {
    const double* const p = poses.data() + 7 * i;
    trajectory.push_back({.stamp = {nanoseconds.data()[i], decimals},
                          .world_from_camera = {.rotation = {p[6], p[3], p[4], p[5]},
                                                .translation = {p[0], p[1], p[2]}},
                          .segment = static_cast<int>(segments.data()[i])});
  }
  return trajectory;
}

}  // namespace edvo::python

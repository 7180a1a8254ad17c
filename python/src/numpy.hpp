// SPDX-License-Identifier: MIT
// Between numpy arrays and the library's types. Arrays that come in are contiguous: the Python side
// has seen to it. Every conversion copies, since the library keeps images for as long as it needs
// them.
#pragma once

#include "edvo/core/rgbd_image.hpp"
#include "edvo/core/trajectory.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

namespace edvo::python {

namespace nb = nanobind;

using RgbArray =
    nb::ndarray<const std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>;
using MetreArray = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using UnitArray = nb::ndarray<const std::uint16_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using MaskArray = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using StampArray = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using PoseArray = nb::ndarray<const double, nb::shape<-1, 7>, nb::c_contig, nb::device::cpu>;

// The array owns the values.
template <typename T>
[[nodiscard]] nb::object numpy_array(std::vector<T> values, std::vector<std::size_t> shape) {
  auto* const kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), shape.size(), shape.data(), owner));
}

// Rows and columns as they are written.
[[nodiscard]] nb::object numpy_matrix(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

// 4 x 4, homogeneous.
[[nodiscard]] nb::object numpy_pose(const SE3& target_from_source);

// H x W x 3 RGB to BGR.
[[nodiscard]] cv::Mat_<cv::Vec3b> to_bgr(const RgbArray& rgb);
// H x W, as read_mask of masked_source.hpp gives it; a copy.
[[nodiscard]] cv::Mat_<std::uint8_t> to_mask(const MaskArray& mask);
[[nodiscard]] nb::object numpy_mask(const cv::Mat_<std::uint8_t>& mask);

[[nodiscard]] nb::object numpy_rgb(const cv::Mat_<cv::Vec3b>& bgr);

// Anything that is not a positive finite number becomes NaN. [m]
[[nodiscard]] cv::Mat_<float> to_depth(const MetreArray& metres);
[[nodiscard]] cv::Mat_<float> to_depth(const UnitArray& raw, double units_per_metre);
[[nodiscard]] nb::object numpy_depth(const cv::Mat_<float>& depth);

// Stamps [ns], their decimals, poses as N x 7: tx ty tz [m] qx qy qz qw, segments.
[[nodiscard]] nb::tuple numpy_trajectory(const Trajectory& trajectory);
[[nodiscard]] Trajectory to_trajectory(const StampArray& nanoseconds, int decimals,
                                       const PoseArray& poses, const StampArray& segments);

}  // namespace edvo::python

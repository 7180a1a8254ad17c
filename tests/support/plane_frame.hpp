// SPDX-License-Identifier: MIT
// Frames of a textured wall, pixels of them and small motions, for tests of tracking.
#pragma once

#include "edvo/features/pixel_selection.hpp"
#include "edvo/image/frame.hpp"
#include "support/synthetic_plane.hpp"

#include <vector>

namespace edvo::test {

inline constexpr SyntheticPlane kPlane{.distance = 2.0};

[[nodiscard]] inline Frame plane_frame(const SE3& world_from_camera) {
  return make_frame(render_plane(kPlane, kVgaCamera, world_from_camera),
                    make_undistortion({kVgaCamera, {}}));
}

// As a rolling shutter sees the wall: each row at its own time, the middle one at the pose. Depth
// is that of all rows at once.
[[nodiscard]] inline Frame rolling_plane_frame(const SE3& world_from_camera,
                                               const Vector6d& velocity, double readout_seconds) {
  RgbdImage image = render_plane(kPlane, kVgaCamera, world_from_camera);
  for (int y = 0; y < image.bgr.rows; ++y) {
    const double share = static_cast<double>(y) / image.bgr.rows - 0.5;
    const SE3 pose = world_from_camera * exp(share * readout_seconds * velocity);
    for (int x = 0; x < image.bgr.cols; ++x)
      image.bgr(y, x) =
          cv::Vec3b::all(cv::saturate_cast<uchar>(intensity_at(kPlane, kVgaCamera, pose, x, y)));
  }
  Frame frame = make_frame(image, make_undistortion({kVgaCamera, {}}));
  frame.shutter = {.velocity = velocity, .readout_seconds = readout_seconds};
  return frame;
}

[[nodiscard]] inline std::vector<SelectedPixel> grid_pixels(const Frame& frame, int stride) {
  std::vector<SelectedPixel> pixels;
  for (int y = 12; y < frame.depth.rows() - 12; y += stride)
    for (int x = 12; x < frame.depth.cols() - 12; x += stride)
      pixels.push_back({{x, y}, frame.depth(y, x), 1.F});
  return pixels;
}

[[nodiscard]] inline SE3 motion(double x, double y, double z, double a, double b, double c) {
  Vector6d xi;
  xi << x, y, z, a, b, c;
  return exp(xi);
}

}  // namespace edvo::test

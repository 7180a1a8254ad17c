// SPDX-License-Identifier: MIT
// An exact, noise-free picture of a scene.
#pragma once

#include "edvo/synth/scene.hpp"

#include <opencv2/core.hpp>

namespace edvo::synth {

struct Render {
  cv::Mat_<cv::Vec3f> bgr;    // H x W, averaged over the pixel's area [grey levels]
  cv::Mat_<float> depth;      // H x W, along z at the pixel's centre [m]
  cv::Mat_<float> incidence;  // H x W, cosine between ray and surface normal [0..1]
};

// rays as of make_rays. The same bits for any number of threads (0 = all of the machine's).
[[nodiscard]] Render render(const Scene& scene, double seconds, const SE3& world_from_camera,
                            const cv::Mat_<cv::Vec2f>& rays, int threads);

}  // namespace edvo::synth

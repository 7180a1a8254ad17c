// SPDX-License-Identifier: MIT
// What the kinds of depth sensors make of an exact picture. All give H x W, [m], NaN = none, and
// leave range and share of missing depth to the caller.
#pragma once

#include "edvo/synth/shot.hpp"

namespace edvo::synth {

// Structured light (the first Kinect). Disparity in steps, so that sigma grows with z^2
// (Khoshelham and Elberink, Sensors 2012), frayed edges and none at grazing angles (Nguyen et al.,
// 3DIMPVT 2012), a shadow on the left of near things.
[[nodiscard]] cv::Mat_<float> kinect1_depth(const Render& exact, const Shot& shot);

// The noise of the ICL-NUIM sequences (Handa et al., ICRA 2014, after Barron and Malik, CVPR 2013):
// depth is read at a place that is off by half a pixel (sigma), interpolated also across edges and
// pixels without depth, which are zero: stray values between both sides, or between zero and the
// surface. Then disparity with noise, in steps of an eighth pixel.
[[nodiscard]] cv::Mat_<float> icl_depth(const Render& exact, const Shot& shot);

// Time of flight (Foix et al., IEEE Sensors Journal 2011; Lefloch et al., LNCS 8200, 2013): the
// phase of the light gathered by a pixel's footprint (flying pixels between the surfaces at an
// edge), light that took the way over another surface (corners seem farther away), a periodic
// deviation (wiggling, Lindner and Kolb, ISVC 2006), noise by the light that comes back.
[[nodiscard]] cv::Mat_<float> tof_depth(const Render& exact, const Shot& shot);

// Active stereo (Keselman et al., CVPRW 2017; Ahn et al., UR 2019): foreground widened
// by half the matching window, the shadow of the second camera, correlated disparity noise of which
// sigma_z grows with z^2; where pattern and texture are weak, wrong blobs, smooth deviations,
// holes.
[[nodiscard]] cv::Mat_<float> stereo_depth(const Render& exact, const Shot& shot);

// A phone's lidar: few points, completed with the colour image to 256 x 192 and enlarged. No holes,
// edges smeared over several pixels, small things lost, a deviation that varies slowly (Luetzenburg
// et al., Scientific Reports 2021; Baruch et al., ARKitScenes, 2021). It is late, too: depth_delay.
[[nodiscard]] cv::Mat_<float> lidar_phone_depth(const Render& exact, const Shot& shot);

}  // namespace edvo::synth

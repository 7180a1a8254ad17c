// SPDX-License-Identifier: MIT
// A map as it outlives a run: keyframes with their poses and images, and what connects them.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/slam/slam.hpp"

#include <string>
#include <vector>

namespace edvo {

// What the map was made with. Another recording fits it if its camera is the same.
struct MapOrigin {
  Camera camera;           // undistorted
  double depth_scale = 0;  // [units per metre], 0 = depth came in metres
  std::string method;
  std::string config;   // every option, TOML
  std::string made_by;  // program and version
};

// A verified motion between two keyframes that are not neighbours in time.
struct MapLink {
  KeyframeId from = 0, to = 0;
  SE3 from_pose_to;
  Matrix6d information = Matrix6d::Zero();  // of xi in from_pose_to * exp(xi)
};

struct SavedMap {
  MapOrigin origin;
  std::vector<MapKeyframe> keyframes;  // by id; in the frame of their segment [m]
  std::vector<Place> views;            // of those whose images were kept, ascending by id
  std::vector<OdometryStep> steps;
  std::vector<MapLink> links;
};

// After slam.finish().
[[nodiscard]] SavedMap make_saved_map(const Slam& slam, MapOrigin origin);

// Segments that have keyframes, ascending.
[[nodiscard]] std::vector<int> segments_of(const SavedMap& map);

}  // namespace edvo

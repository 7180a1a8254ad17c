// SPDX-License-Identifier: MIT
#include "edvo/report/point_file.hpp"

#include "edvo/io/ply_file.hpp"

#include <algorithm>
#include <utility>

namespace edvo {

PointFile::PointFile(std::filesystem::path file) : file_(std::move(file)) {}

void PointFile::keyframe(const KeyframePtr& keyframe) {
  parts_.push_back({.stamp = keyframe->stamp, .points = keyframe->points});
}

void PointFile::end(const RunOutcome& outcome) {
  std::vector<ColoredPoint> cloud;
  for (const Part& part : parts_) {
    const auto pose =
        std::lower_bound(outcome.keyframes.begin(), outcome.keyframes.end(), part.stamp,
                         [](const StampedPose& a, const Stamp& stamp) { return a.stamp < stamp; });
    if (pose == outcome.keyframes.end() || pose->stamp != part.stamp) continue;
    for (const ColoredPoint& point : part.points)
      cloud.push_back(
          {.position = (pose->world_from_camera * point.position.cast<double>()).cast<float>(),
           .rgb = point.rgb});
  }
  write_ply(file_, cloud);
}

}  // namespace edvo

// SPDX-License-Identifier: MIT
// The points of all keyframes as one cloud, written at the end of a run.
#pragma once

#include "edvo/core/colored_point.hpp"
#include "edvo/run/observer.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace edvo {

class PointFile final : public Observer {
 public:
  explicit PointFile(std::filesystem::path file);

  [[nodiscard]] bool wants_keyframes() const override { return true; }
  void keyframe(const KeyframePtr& keyframe) override;

  // Writes the PLY file, in world coordinates by the keyframes' final poses. Throws Error(kOutput).
  void end(const RunOutcome& outcome) override;

 private:
  // Its points alone: images of all keyframes would fill the memory.
  struct Part {
    Stamp stamp;
    std::vector<ColoredPoint> points;  // in the keyframe's camera [m]
  };

  std::filesystem::path file_;
  std::vector<Part> parts_;
};

}  // namespace edvo

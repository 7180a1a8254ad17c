// SPDX-License-Identifier: MIT
// The interface of all inputs: a folder, a renderer, a recording, a camera.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/rgbd_image.hpp"
#include "edvo/core/trajectory.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

// Reference poses of the same camera.
struct GroundTruth {
  std::string source;  // its file, or what computed it
  Trajectory trajectory;
};

// What a source knows before its first frame.
struct SourceInfo {
  std::string name;    // short, also the name of the run folder: "fr1_xyz"
  std::string origin;  // where frames are read from, and in which layout
  DistortedCamera camera;
  std::string camera_origin;                // which camera this is, and why it was chosen
  double depth_scale = 0;                   // [units/m], 0 = depth comes in metres
  std::string depth_origin;                 // why this scale
  bool is_depth_assumed = false;            // neither given by the user nor stated by the data
  std::optional<std::int64_t> frames = {};  // none = not known
  bool is_live = false;  // a sensor that does not wait: a late reader gets the newest frame
  std::optional<std::uint64_t> seed = {};  // of random numbers, if any were used
  std::optional<GroundTruth> ground_truth = {};
  std::vector<std::string> notes = {};     // what was found and chosen
  std::vector<std::string> warnings = {};  // what looks wrong but stops nothing
};

// The next frame of a source; its images may not be read yet.
struct PendingFrame {
  std::int64_t index = 0;  // in the sequence, from 0
  Stamp stamp;             // also of a frame that cannot be read
  // Reads and decodes the images. Any thread may call it, also while others load other frames, as
  // long as the source exists. Throws Error(kInput) if this frame cannot be read; it is skipped.
  std::function<RgbdImage()> load;
};

class RgbdSource {
 public:
  virtual ~RgbdSource() = default;

  // The same before, during and after the sequence.
  [[nodiscard]] virtual const SourceInfo& info() const = 0;

  // The next frame in the order of the stamps, empty after the last one. Called by one thread at a
  // time. A folder only looks up the next files; a recording or a camera reads here, and load()
  // only returns the images. Throws Error if the source fails; earlier frames stay valid.
  [[nodiscard]] virtual std::optional<PendingFrame> next() = 0;

  // Makes a next() that waits for a sensor return none soon. Any thread may call it.
  virtual void stop() {}

 protected:
  RgbdSource() = default;
  RgbdSource(const RgbdSource&) = default;
  RgbdSource& operator=(const RgbdSource&) = default;
};

}  // namespace edvo

// SPDX-License-Identifier: MIT
// Where frames come from: a folder, a renderer, a recording, a camera.
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
  std::string source;  // its file, or what made it
  Trajectory trajectory;
};

// What a source knows before its first frame.
struct SourceInfo {
  std::string name;    // short, also names the run's folder: "fr1_xyz"
  std::string origin;  // where frames are read from, and as what
  DistortedCamera camera;
  std::string camera_origin;                // which camera this is, and why it was taken
  double depth_scale = 0;                   // [units/m], 0 = depth comes in metres
  std::string depth_origin;                 // why this scale
  bool is_depth_assumed = false;            // no one said so: metres depend on it
  std::optional<std::int64_t> frames = {};  // none = not known
  bool is_live = false;  // a sensor that does not wait: who is late gets the newest frame
  std::optional<std::uint64_t> seed = {};  // where something random took part
  std::optional<GroundTruth> ground_truth = {};
  std::vector<std::string> notes = {};     // what was found and chosen
  std::vector<std::string> warnings = {};  // what looks wrong but stops nothing
};

// A frame whose turn it is, perhaps not read yet.
struct PendingFrame {
  std::int64_t index = 0;  // in the sequence, from 0
  Stamp stamp;             // also of a frame that cannot be read
  // Reads and decodes. Any thread may call it, also while others load other frames, as long as the
  // source lives. Throws Error(kInput) about this frame alone, which is then skipped.
  std::function<RgbdImage()> load;
};

class RgbdSource {
 public:
  virtual ~RgbdSource() = default;

  // The same at any time.
  [[nodiscard]] virtual const SourceInfo& info() const = 0;

  // The next frame in the order of the stamps, empty after the last one. Called by one thread at a
  // time. A folder only looks up which files are next; a recording or a camera reads here and its
  // load() hands over. Throws Error if no more frames can be had: what was done so far stays.
  [[nodiscard]] virtual std::optional<PendingFrame> next() = 0;

  // From any thread: a next() that waits for a sensor returns empty soon.
  virtual void stop() {}

 protected:
  RgbdSource() = default;
  RgbdSource(const RgbdSource&) = default;
  RgbdSource& operator=(const RgbdSource&) = default;
};

}  // namespace edvo

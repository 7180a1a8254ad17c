// SPDX-License-Identifier: MIT
// Rendered RGB-D sequences with exact ground truth, made frame by frame in memory.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/fields.hpp"
#include "edvo/core/rgbd_image.hpp"
#include "edvo/core/trajectory.hpp"
#include "edvo/synth/moving_thing.hpp"
#include "edvo/synth/path.hpp"
#include "edvo/synth/scene.hpp"
#include "edvo/synth/sensor.hpp"

#include <concepts>
#include <opencv2/core.hpp>
#include <vector>

namespace edvo::synth {

// The camera of most RGB-D recordings, without distortion.
inline constexpr DistortedCamera kDefaultCamera{
    .pinhole = {.fx = 525, .fy = 525, .cx = 319.5, .cy = 239.5, .width = 640, .height = 480}};

struct SequenceOptions {
  SceneName scene = SceneName::kOffice;
  PathName path = PathName::kDemo;
  int seed = 0;
  int frames = 300;          // before drops
  double path_length = 0;    // [m]
  double rate = 30;          // [Hz]
  double exposure_time = 0;  // [s]
  double readout_time = 0;   // [s]
  MovingThing moving = MovingThing::kNone;
  double moving_share = 0.25;  // [0..1]
  double texture = 1;          // [0..1]
  bool shadows = false;
  double lamp_swing = 0;     // [m]
  double dropped_share = 0;  // [0..1]
  SensorOptions sensor;
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, SequenceOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("scene", self.scene, Range{}, "room to render");
  visit("path", self.path, Range{}, "motion of the camera");
  visit("seed", self.seed, Range{0, 1e9}, "of textures, motion and noise");
  visit("frames", self.frames, Range{1, 1e6}, "length of the sequence, dropped frames included");
  visit("path_length", self.path_length, Range{0, 1e4},
        "of rounds: walk this far, however many frames that takes; 0 = for so many frames [m]");
  visit("rate", self.rate, Range{1, 1000}, "frames per second [Hz]");
  visit("exposure_time", self.exposure_time, Range{0, 0.2}, "blurs motion; 0 = none [s]");
  visit("readout_time", self.readout_time, Range{-0.1, 0.1},
        "rolling shutter: the last row of an image is this much later than the first [s]");
  visit("moving", self.moving, Range{},
        "what moves on its own, before the camera in the middle of the sequence");
  visit("moving_share", self.moving_share, Range{0.05, 1},
        "share of the image that it hides then; a person: at most about half");
  visit("texture", self.texture, Range{0, 1},
        "contrast of the patterns on surfaces; 0 = plain surfaces");
  visit("shadows", self.shadows, Range{}, "the lamp casts shadows");
  visit("lamp_swing", self.lamp_swing, Range{0, 2},
        "the lamp, and so its shadows, swings this far to each side in 2 s [m]");
  visit("dropped_share", self.dropped_share, Range{0, 0.9}, "share of frames lost at random");
}

// All there is to know about a sequence before a frame is rendered.
struct SyntheticSequence {
  SequenceOptions options;
  DistortedCamera camera;
  Scene scene;
  Path path;
  cv::Mat_<cv::Vec2f> rays;  // of make_rays(camera)
  std::vector<int> kept;     // numbers of the frames that were not dropped, ascending
  int threads = 0;           // 0 = all of the machine's
};

// recorded: if not empty, the camera moves like this instead of options.path (see without_jitter,
// fit_into); the sequence ends where the recording does. Throws Error(kConfig) about an option out
// of range, Error(kCalibration) about an impossible camera and what fit_into throws.
[[nodiscard]] SyntheticSequence make_sequence(const SequenceOptions& options,
                                              const DistortedCamera& camera = kDefaultCamera,
                                              const Trajectory& recorded = {});

[[nodiscard]] inline int frame_count(const SyntheticSequence& sequence) {
  return static_cast<int>(sequence.kept.size());
}

// The exact pose of a frame, index in [0..frame_count).
[[nodiscard]] StampedPose pose_of(const SyntheticSequence& sequence, int index);

// Frames may be made in any order, or at the same time: the bits are the same.
[[nodiscard]] RgbdImage make_frame(const SyntheticSequence& sequence, int index);

// As a motion capture system would record it: four poses for each frame time, one of them exactly
// at the frame's stamp.
[[nodiscard]] Trajectory ground_truth(const SyntheticSequence& sequence);

}  // namespace edvo::synth

// SPDX-License-Identifier: MIT
// Things that move on their own in front of the camera.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/fields.hpp"
#include "edvo/core/se3.hpp"
#include "edvo/synth/scene.hpp"

#include <cstdint>

namespace edvo::synth {

enum class MovingThing {
  kNone,
  kBox,        // crosses from left to right at 0.8 m/s, square to the view
  kPerson,     // walks across from left to right at 1.2 m/s, stiffly
  kTurntable,  // a column and two boxes on a disc that turns at 45 deg/s
};

// The camera at the time when the thing is in the middle of its image.
struct Encounter {
  Camera camera;
  SE3 world_from_camera;
  double seconds = 0;  // [s]
};

// Adds a thing that then hides about a share [0..1] of the image, what stands before it aside. A
// box (0.9 m away) or a turntable (0.6 m) is as large as that takes; a person is as near, but no
// nearer than 0.6 m, which is about half of an image.
void add_moving_thing(Scene& scene, MovingThing thing, double share, const Encounter& encounter,
                      std::uint64_t seed);

}  // namespace edvo::synth

template <>
struct edvo::EnumNames<edvo::synth::MovingThing> {
  using MovingThing = edvo::synth::MovingThing;
  static constexpr auto names = std::to_array<std::pair<MovingThing, std::string_view>>({
      {MovingThing::kNone, "none"},
      {MovingThing::kBox, "box"},
      {MovingThing::kPerson, "person"},
      {MovingThing::kTurntable, "turntable"},
  });
};

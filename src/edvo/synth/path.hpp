// SPDX-License-Identifier: MIT
// Where the camera is at any time: smooth made-up motions, or a recorded trajectory.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/core/trajectory.hpp"
#include "edvo/synth/scene.hpp"

#include <cstdint>

namespace edvo::synth {

enum class PathName {
  kDemo,          // all six degrees of freedom, about half a metre per second, as held by a hand
  kOrbit,         // to and fro on an arc around the target
  kPureRotation,  // turning on the spot at 60 degrees per second
  kStill,
  kXyz,     // along each axis in turn, hardly turning
  kRounds,  // walking through rooms and back to the start (make_rounds)
};

// A motion of the camera; pose_at is exact and has no state.
struct Path {
  PathName name = PathName::kDemo;
  Stage stage;
  std::uint64_t seed = 0;
  double pace = 1;      // of the demo: how fast its time runs
  Trajectory recorded;  // if not empty, this is the motion and the rest is unused; of kRounds
};

// The demo's pace is set so that its first ten seconds are 5.5 m long, whatever the stage.
[[nodiscard]] Path make_path(PathName name, const Stage& stage, std::uint64_t seed);

// A walk of a length [m] through the rooms of a scene, with a camera at 1.3 m that looks ahead, at
// 0.9 m/s and slower where it turns: from home, through rooms at random, each in either direction,
// or where the length leaves no room for one to and fro in the corridor, and home again, so that
// it ends where it began. To be Path::recorded. Throws Error(kConfig) if the scene has no way to
// walk.
[[nodiscard]] Trajectory make_rounds(const Scene& scene, double length, std::uint64_t seed);

// seconds counts from the start of the path; a recorded one holds its ends.
[[nodiscard]] SE3 pose_at(const Path& path, double seconds);

// A camera at eye that looks at target (x right, y down, z forward; world z up). The two must not
// lie above each other.
[[nodiscard]] SE3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

// A recorded motion without the jitter of what measured it: motion capture is a pixel off from one
// pose to the next, no camera is. Where fewer than seven poses lie within 0.15 s to either side it
// stays as it is.
[[nodiscard]] Trajectory without_jitter(const Trajectory& recorded);

// Stands a recorded motion upright into a scene: turned about z, shifted, and shrunk if need be, so
// that the camera stays clear of everything and mostly looks at surfaces 0.5 to 4 m away. Motions
// whose world is not z up (a first camera as the world, say) are turned so that the camera is
// upright on average. Throws Error(kInput) if there are fewer than two poses or none fits.
[[nodiscard]] Trajectory fit_into(const Scene& scene, const Trajectory& recorded);

}  // namespace edvo::synth

template <>
struct edvo::EnumNames<edvo::synth::PathName> {
  using PathName = edvo::synth::PathName;
  static constexpr auto names = std::to_array<std::pair<PathName, std::string_view>>({
      {PathName::kDemo, "demo"},
      {PathName::kOrbit, "orbit"},
      {PathName::kPureRotation, "pure_rotation"},
      {PathName::kStill, "still"},
      {PathName::kXyz, "xyz"},
      {PathName::kRounds, "rounds"},
  });
};

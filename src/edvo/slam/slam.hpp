// SPDX-License-Identifier: MIT
// SLAM: the odometry, whose keyframes are joined at the end by the places that they show again. The
// same door as Odometry.
#pragma once

#include "edvo/odometry/odometry.hpp"
#include "edvo/slam/link_search.hpp"
#include "edvo/slam/map_correction.hpp"
#include "edvo/slam/relocalizer.hpp"

#include <memory>
#include <vector>

namespace edvo {

struct SlamConfig {
  LoopOptions loops;
  LinkOptions links;
  bool keep_colour = false;  // of places: for a map that is looked at
};

// Whether there is anything that Slam could join: methods without a window of keyframes are the
// paper's baselines, which have no back end.
[[nodiscard]] inline bool has_back_end(const Config& config) {
  return config.window.keyframes > 0;
}

// While images come it is the odometry, and frames of a segment that was begun after a loss are
// looked for among the keyframes of the others (map_frame). finish() looks for keyframes of the
// same place, in whatever segment, verifies them, joins segments, closes loops, and has all
// keyframes refined together.
class Slam {
 public:
  // As Odometry's, see there.
  Slam(const DistortedCamera& camera, const Config& config, const SlamConfig& slam = {},
       std::unique_ptr<EdgeDetector> detector = nullptr);

  FrameResult process(const RgbdImage& image) { return process(prepare(image)); }
  [[nodiscard]] PreparedImage prepare(const RgbdImage& image) const {
    return odometry_.prepare(image);
  }
  FrameResult process(const PreparedImage& image);

  // Call it once after the last image; more images may follow. The result is the same for any
  // number of threads.
  void finish(int threads = 2);

  [[nodiscard]] Trajectory trajectory() const { return odometry_.trajectory(); }
  [[nodiscard]] Trajectory keyframe_trajectory() const { return odometry_.keyframe_trajectory(); }
  [[nodiscard]] const Map& map() const { return odometry_.map(); }
  [[nodiscard]] KeyframePtr newest_keyframe() const { return odometry_.newest_keyframe(); }

  // Where a segment's frame lies in the map, as found while images came: the odometry's own frame
  // never jumps.
  [[nodiscard]] MapFrame map_frame(int segment) const { return relocalizer_.frame_of(segment); }

  // What the last finish() found out about each candidate.
  [[nodiscard]] const std::vector<LinkReport>& links() const { return links_; }

  // What a map keeps: keyframes with their images, and the steps between keyframes.
  [[nodiscard]] const std::vector<Place>& places() const { return places_; }
  [[nodiscard]] const std::vector<OdometryStep>& steps() const { return steps_; }

  // Takes over poses and segments of all keyframes, by id; after finish().
  void correct(std::span<const MapKeyframe> keyframes) { odometry_.correct(keyframes); }

 private:
  void add_place(const FrameResult& result);
  void measure_steps(KeyframeId first, KeyframeId last);
  void doubt_steps_after_loss();
  void search_places(std::vector<MapKeyframe>& keyframes, int threads);

  Odometry odometry_;
  Camera camera_;
  Config config_;
  SlamConfig slam_;
  std::vector<Place> places_;  // by keyframe; of places where many were taken, fewer
  std::vector<OdometryStep> steps_;
  std::vector<LinkReport> links_;
  Relocalizer relocalizer_;
  bool lost_since_keyframe_ = false;
  std::vector<std::size_t> after_loss_;  // of steps_, those with lost frames between
};

}  // namespace edvo

// SPDX-License-Identifier: MIT
// Finds the segments of before again while images come: frames of a young segment are looked for
// among the keyframes of others, and two that agree tell how the segments lie to each other.
#pragma once

#include "edvo/map/map.hpp"
#include "edvo/odometry/frame_result.hpp"
#include "edvo/slam/link_search.hpp"
#include "edvo/slam/place.hpp"

#include <map>
#include <optional>
#include <vector>

namespace edvo {

// Where the frame of a segment of the odometry lies in the map: world from camera of a frame in the
// map is map_from_odometry * FrameResult::world_from_camera.
struct MapFrame {
  int segment = 0;  // whose first frame defines the map's world
  SE3 map_from_odometry;
};

class Relocalizer {
 public:
  Relocalizer(const Camera& camera, const SearchOptions& options)
      : camera_(camera), options_(options) {}

  // A keyframe that may be found again.
  void add(const Place& place, int segment);
  void drop(std::int64_t id);

  // Looks for a frame of a segment that was just begun; call it for every frame with a pose. Does
  // nothing for a segment that is the first or found already. map: of all keyframes. places: those
  // added, by id. The same bits from run to run.
  void look_for(const Frame& frame, const FrameResult& result, const Map& map,
                const std::vector<Place>& places);

  [[nodiscard]] MapFrame frame_of(int segment) const;

  // Of frames that were found, as links of their keyframes.
  [[nodiscard]] const std::vector<LinkReport>& links() const { return links_; }

 private:
  struct Kept {
    int segment = 0;
    FernCode code{};
    std::vector<CornerFeature> features;  // made when first needed
  };
  // Where the young segment lies, by one frame.
  struct Sighting {
    int segment = 0;         // in which it was found
    SE3 found_from_segment;  // worlds
    SE3 camera;              // of the frame, in the young segment
    bool is_sure = false;    // the link
  };

  [[nodiscard]] std::optional<LinkReport> locate(const Frame& frame, std::int64_t keyframe,
                                                 int segment, const std::vector<Place>& places);
  void settle(int segment);

  Camera camera_;
  SearchOptions options_;
  std::map<std::int64_t, Kept> kept_;  // by keyframe
  std::map<int, MapFrame> found_;      // by segment
  int young_ = 0;                      // segment
  int tries_ = 0;                      // of its frames
  std::vector<Sighting> sightings_;    // of its frames
  std::vector<LinkReport> links_;
};

}  // namespace edvo

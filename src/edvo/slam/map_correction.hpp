// SPDX-License-Identifier: MIT
// What links between keyframes change of a map: segments are joined, loops are closed.
#pragma once

#include "edvo/map/map.hpp"
#include "edvo/slam/pose_graph.hpp"
#include "edvo/slam/verify_link.hpp"

#include <vector>

namespace edvo {

// Whether a link may join segments, where no odometry can contradict it: most corners look alike.
[[nodiscard]] bool is_sure(const LinkReport& link);

// Two segments are joined if at most so many unsure links agree for each sure one. Of two rendered
// rooms of the same layout 11 did, by chance; of true joins of recordings up to 0.9.
constexpr int kMostUnsure = 3;

// Moves segments into the frame of an older one where two sure links or more agree on the motion
// between them, and more than disagree. Accepted links between segments that stay apart become
// kAlone. keyframes: by id.
void join_segments(std::vector<MapKeyframe>& keyframes, std::vector<LinkReport>& links);

// From a keyframe to the next one of its segment, as tracked and refined.
struct OdometryStep {
  KeyframeId from = 0, to = 0;
  SE3 from_pose_to;  // as refined while both were new, before older keyframes pulled one of them
  Matrix6d information = Matrix6d::Zero();  // of xi in from_pose_to * exp(xi), as tracked
};

// Whether a step's own measurement differs from the map by more than refinement explains: the map
// was bent there, to fit what was seen before.
[[nodiscard]] bool is_bent(const std::vector<MapKeyframe>& keyframes,
                           const std::vector<OdometryStep>& steps);

// With what tracking does not tell added.
[[nodiscard]] Matrix6d step_information(const OdometryStep& step);

// Of an aligned link, with what alignment does not tell added.
[[nodiscard]] Matrix6d graph_information(const LinkReport& link);

// Takes that over into the link.
void weaken_link(LinkReport& link);

// Moves keyframes to where the odometry's steps and accepted links agree best. Links that
// contradict the others become kCycle. Aligned links that are known hold what is right already; if
// there are no others, or none of them holds, no pose changes, unless the map is bent. keyframes:
// by id.
void close_loops(std::vector<MapKeyframe>& keyframes, const std::vector<OdometryStep>& steps,
                 std::vector<LinkReport>& links);

}  // namespace edvo

// SPDX-License-Identifier: MIT
// Poses stored beside the images of a data set, one matrix per image: 7-Scenes, BundleFusion,
// ScanNet, Replica as NICE-SLAM renders it.
#pragma once

#include "edvo/core/trajectory.hpp"
#include "edvo/io/dataset.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

struct ImagePoses {
  std::string source;                 // where they are, as part of a sentence
  Trajectory trajectory;              // world_from_camera, with the stamps of the frames
  std::vector<std::string> warnings;  // what could not be used
};

// Looks for, in this order:
//   frame-000000.pose.txt        beside frame-000000.color.png, one 4 x 4 matrix a file
//   pose/0.txt, poses/0.txt      in the root, named as the colour images
//   traj.txt                     in the root or above it, one matrix of 16 (or 12) numbers a line,
//                                the line of a number is that of the image of that number
// Matrices that are no pose (data sets write infinities where tracking was lost) are left out. None
// if there are no such files. Throws Error(kInput) at a file that holds no matrices.
[[nodiscard]] std::optional<ImagePoses> read_image_poses(const std::filesystem::path& root,
                                                         const std::vector<FrameEntry>& frames);

}  // namespace edvo

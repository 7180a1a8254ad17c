// SPDX-License-Identifier: MIT
// An RGB-D sequence on disk: its images, their pairs, and reading them.
#pragma once

#include "edvo/core/rgbd_image.hpp"
#include "edvo/core/trajectory.hpp"
#include "edvo/io/depth_scale.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

struct DatasetOptions {
  // [units/m], empty = from the camera's file, else by the name or the layout
  std::optional<double> depth_scale = {};
  std::optional<std::filesystem::path> camera_file = {};  // empty = the one in the folder, if any
  double assumed_rate = 30;          // [Hz] of numbered frames, which have no stamps
  double largest_gap = 0.02;         // [s] between a colour image and its depth image
  bool is_depth_registered = true;   // else it may have another size than colour
  std::filesystem::path cache = {};  // where archives are unpacked; needed only for them
  // Called with the unpacked share of an archive [0..1], several times a second. An exception that
  // it throws ends the unpacking, removes what was unpacked and is passed on.
  std::function<void(double)> on_unpack = nullptr;
};

struct FrameEntry {
  Stamp stamp;        // of the colour image, and so of the frame
  Stamp depth_stamp;  // of the depth image
  std::filesystem::path colour, depth;
};

struct Dataset {
  std::string name;                // of the folder or the archive, without endings
  std::filesystem::path source;    // as given
  std::filesystem::path root;      // the folder that has the lists or the image folders
  std::string layout;              // what was recognised: "TUM lists", "association file", ...
  std::vector<FrameEntry> frames;  // ordered by stamp
  std::size_t colour_count = 0;    // images found, paired or not
  std::size_t depth_count = 0;
  bool shrink_colour = false;  // to the size of the depth image
  bool is_depth_registered = true;
  // Of the first frame that can be read, and so of all [px]. Depth's differs from that of colour
  // only if it is not registered.
  cv::Size image_size, depth_size;
  DepthScale depth_scale;
  std::optional<std::filesystem::path> ground_truth;  // a trajectory file in the root
  Trajectory poses;                // without such a file: those beside the images (image_poses.hpp)
  std::string poses_source;        // where they are
  std::vector<std::string> notes;  // what was picked and why
  std::vector<std::string> warnings;  // what looks wrong but does not stop the run
};

// Opens a folder, or an archive (tar, zip, also compressed) of one, in any of these layouts:
//   rgb.txt + depth.txt                 TUM; colour and depth associated by time
//   associations.txt, associate.txt...  stamp, file, stamp, file; colour or depth first
//   rgb|color|... + depth|depths        folders of numbered images, no stamps
//   *.color.png + *.depth.png           in one folder, numbered (7-Scenes, BundleFusion)
//   results/frame*.jpg + depth*.png     Replica as NICE-SLAM renders it
// Colour larger than registered depth is refused, except in ScanNet's layout (color/, depth/,
// intrinsic/): there it is shrunk to the depth's size, whose intrinsics then hold. Throws
// Error(kInput) if there is no sequence, no images pair up or no frame can be read, Error(kOutput)
// if an archive cannot be unpacked.
[[nodiscard]] Dataset open_dataset(const std::filesystem::path& source,
                                   const DatasetOptions& options = {});

// index: into dataset.frames. Throws Error(kInput) if the images of that frame are missing, damaged
// or of another size than the first.
[[nodiscard]] RgbdImage read_frame(const Dataset& dataset, std::size_t index);

}  // namespace edvo

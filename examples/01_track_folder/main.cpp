// SPDX-License-Identifier: MIT
// Tracks a recorded RGB-D sequence: track_folder SEQUENCE TRAJECTORY
#include <edvo/io/camera_choice.hpp>
#include <edvo/io/dataset.hpp>
#include <edvo/io/trajectory_file.hpp>
#include <edvo/odometry/odometry.hpp>

#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: track_folder SEQUENCE TRAJECTORY\n";
    return 2;
  }
  // A folder or archive with rgb.txt and depth.txt, an association file, or numbered images.
  const edvo::Dataset dataset = edvo::open_dataset(argv[1]);
  for (const std::string& warning : dataset.warnings) std::cerr << "warning: " << warning << '\n';

  // A calibration file in the folder, or what the folder's name tells.
  const edvo::ChosenCamera chosen = edvo::choose_camera(dataset);
  std::cout << dataset.frames.size() << " frames, camera: " << chosen.source << '\n';

  edvo::Odometry odometry(chosen.camera, edvo::preset(edvo::Method::kCannyCorner));
  for (std::size_t i = 0; i < dataset.frames.size(); ++i) {
    const edvo::FrameResult report = odometry.process(edvo::read_frame(dataset, i));
    std::cout << edvo::to_string(report.stamp) << ' ' << edvo::name_of(report.status) << ' '
              << report.world_from_camera.translation.transpose() << " m\n";
  }

  edvo::write_trajectory(argv[2], odometry.trajectory());
  return 0;
} catch (const edvo::Error& error) {
  std::cerr << error.what() << '\n';
  return static_cast<int>(error.code());
}

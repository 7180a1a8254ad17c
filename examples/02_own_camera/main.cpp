// SPDX-License-Identifier: MIT
// Feeds images from a camera of one's own. The camera here is made up: it slides past a wall.
#include <edvo/odometry/odometry.hpp>

#include <cmath>
#include <iostream>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace {

constexpr int kFrames = 20;
constexpr double kStep = 0.01;           // to the right, per frame [m]
constexpr double kWall = 2.0;            // distance of the wall [m]
constexpr double kUnitsPerMetre = 1000;  // what the sensor counts depth in
constexpr double kNoise = 2;             // standard deviation of depth [mm]

// Stands for the driver of a sensor: colour, and depth in millimetres, 0 = none.
struct FakeSensor {
  edvo::Camera camera;
  cv::Mat wall;

  explicit FakeSensor(const edvo::Camera& its_camera) : camera(its_camera) {
    cv::Mat coarse(60, 100, CV_8UC3);
    cv::RNG(7).fill(coarse, cv::RNG::UNIFORM, 0, 256);
    cv::resize(coarse, wall, {}, 10, 10, cv::INTER_CUBIC);
  }

  cv::Mat colour(int frame) const {
    const double shift = camera.fx * kStep * frame / kWall;  // [px]
    const cv::Mat view = (cv::Mat_<double>(2, 3) << 1, 0, -shift, 0, 1, 0);
    cv::Mat image;
    cv::warpAffine(wall, image, view, {camera.width, camera.height});
    return image;
  }

  // With some noise, as sensors have: depth that is one number everywhere is taken for a
  // placeholder.
  cv::Mat depth(int frame) const {
    cv::Mat image(camera.height, camera.width, CV_16U);
    cv::RNG(frame + 1U).fill(image, cv::RNG::NORMAL, kWall * kUnitsPerMetre, kNoise);
    return image;
  }
};

// edvo wants metres as float, NaN where there is none.
cv::Mat_<float> metres(const cv::Mat& raw) {
  cv::Mat_<float> depth;
  raw.convertTo(depth, CV_32F, 1.0 / kUnitsPerMetre);
  depth.setTo(std::numeric_limits<float>::quiet_NaN(), raw == 0);
  return depth;
}

}  // namespace

int main() try {
  const edvo::Camera pinhole{
      .fx = 300, .fy = 300, .cx = 159.5, .cy = 119.5, .width = 320, .height = 240};
  const edvo::DistortedCamera camera{.pinhole = pinhole, .distortion = {0, 0, 0, 0, 0}};

  edvo::Config config = edvo::preset(edvo::Method::kCannyCorner);
  edvo::set_option(config, "keyframes.period=10");  // a keyframe at least every 10 frames

  edvo::Odometry odometry(camera, config);
  const FakeSensor sensor(pinhole);
  edvo::FrameResult report;
  for (int i = 0; i < kFrames; ++i) {
    report = odometry.process({.stamp = edvo::stamp_from_seconds(i / 30.0),
                               .bgr = sensor.colour(i),
                               .depth = metres(sensor.depth(i))});
    std::cout << i << ' ' << edvo::name_of(report.status) << ' '
              << report.world_from_camera.translation.transpose() << '\n';
  }

  const double moved = report.world_from_camera.translation.x();
  const double truth = kStep * (kFrames - 1);
  std::cout << "moved " << moved << " m to the right, in truth " << truth << " m\n";
  return std::abs(moved - truth) < 0.005 ? 0 : 1;
} catch (const edvo::Error& error) {
  std::cerr << error.what() << '\n';
  return static_cast<int>(error.code());
}

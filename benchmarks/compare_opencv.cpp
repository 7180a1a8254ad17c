// SPDX-License-Identifier: MIT
// edvo and OpenCV's RGB-D odometries on the same frames, one after the other in one process, so
// that whatever slows the machine down slows all of them down. Each frame is read and decoded anew
// for each of them.
#include "edvo/eval/evaluate.hpp"
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/dataset.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/odometry/odometry.hpp"

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd/depth.hpp>

#include <algorithm>
#include <chrono>
#include <memory>

namespace {

using namespace edvo;

// What is compared: images in, a trajectory out.
class System {
 public:
  virtual ~System() = default;
  virtual void process(const RgbdImage& image) = 0;
  [[nodiscard]] virtual Trajectory trajectory() const = 0;
};

class Edvo : public System {
 public:
  Edvo(const DistortedCamera& camera, Method method) : odometry_(camera, preset(method)) {}
  void process(const RgbdImage& image) override { (void)odometry_.process(image); }
  Trajectory trajectory() const override { return odometry_.trajectory(); }

 private:
  Odometry odometry_;
};

// Frame to frame, with OpenCV's defaults. It is spared the undistortion that edvo does.
class OpenCvOdometry : public System {
 public:
  explicit OpenCvOdometry(cv::Ptr<cv::rgbd::Odometry> odometry) : odometry_(std::move(odometry)) {}

  void process(const RgbdImage& image) override {
    cv::Mat gray;
    cv::cvtColor(image.bgr, gray, cv::COLOR_BGR2GRAY);
    auto frame = cv::rgbd::OdometryFrame::create(gray, image.depth);
    if (last_) {
      cv::Mat pose;  // current from last
      // The frame's pyramids and normals are computed here, and once only.
      if (odometry_->compute(last_, frame, pose))
        world_from_camera_ = world_from_camera_ * inverse(to_se3(pose));
    }
    last_ = frame;
    trajectory_.push_back({image.stamp, world_from_camera_});
  }

  Trajectory trajectory() const override { return trajectory_; }

 private:
  static SE3 to_se3(const cv::Mat_<double>& pose) {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) rotation(r, c) = pose(r, c);
      translation[r] = pose(r, 3);
    }
    return {.rotation = Eigen::Quaterniond(rotation).normalized(), .translation = translation};
  }

  cv::Ptr<cv::rgbd::Odometry> odometry_;
  cv::Ptr<cv::rgbd::OdometryFrame> last_;
  SE3 world_from_camera_;
  Trajectory trajectory_;
};

struct Times {
  std::vector<double> decode, process, total;  // one per frame [ms]
};

struct Entry {
  std::string name;
  std::function<std::unique_ptr<System>()> make;
  std::vector<Times> repeats = {};
  Trajectory trajectory = {};  // of the last repeat
};

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

void run_once(const Dataset& dataset, std::size_t frames, std::vector<Entry>& entries) {
  std::vector<std::unique_ptr<System>> systems;
  for (Entry& entry : entries) {
    systems.push_back(entry.make());
    entry.repeats.emplace_back();
  }
  for (std::size_t i = 0; i < frames; ++i) {
    for (std::size_t turn = 0; turn < entries.size(); ++turn) {
      const std::size_t e = (i + turn) % entries.size();  // each goes first equally often
      Times& times = entries[e].repeats.back();
      const auto start = std::chrono::steady_clock::now();
      const RgbdImage image = read_frame(dataset, i);
      times.decode.push_back(milliseconds_since(start));
      systems[e]->process(image);
      times.total.push_back(milliseconds_since(start));
      times.process.push_back(times.total.back() - times.decode.back());
    }
  }
  for (std::size_t e = 0; e < entries.size(); ++e) entries[e].trajectory = systems[e]->trajectory();
}

double quantile(std::vector<double> values, double p) {
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

std::vector<double> all_repeats(const Entry& entry, std::vector<double> Times::*what) {
  std::vector<double> all;
  for (const Times& times : entry.repeats)
    all.insert(all.end(), (times.*what).begin(), (times.*what).end());
  return all;
}

// "5.1 (4.9 to 5.2)": how much longer an entry takes than the first one; median and spread over
// the repeats.
std::string ratio(const Entry& entry, const Entry& first, std::vector<double> Times::*what) {
  std::vector<double> ratios;
  for (std::size_t r = 0; r < entry.repeats.size(); ++r)
    ratios.push_back(sum(entry.repeats[r].*what) / sum(first.repeats[r].*what));
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", quantile(ratios, 0.5),
                     *std::ranges::min_element(ratios), *std::ranges::max_element(ratios));
}

void print_times(const std::vector<Entry>& entries) {
  fmt::print("{:<28}{:>10}{:>10}{:>10}{:>12}{:>10}{:>24}{:>24}\n", "[ms per frame]", "decode",
             "process", "total", "total mean", "p95", "x total (spread)", "x process (spread)");
  for (const Entry& entry : entries) {
    const std::vector<double> total = all_repeats(entry, &Times::total);
    fmt::print("{:<28}{:>10.2f}{:>10.2f}{:>10.2f}{:>12.2f}{:>10.2f}{:>24}{:>24}\n", entry.name,
               quantile(all_repeats(entry, &Times::decode), 0.5),
               quantile(all_repeats(entry, &Times::process), 0.5), quantile(total, 0.5),
               sum(total) / static_cast<double>(total.size()), quantile(total, 0.95),
               ratio(entry, entries.front(), &Times::total),
               ratio(entry, entries.front(), &Times::process));
  }
}

void print_errors(const Dataset& dataset, const std::vector<Entry>& entries) {
  if (!dataset.ground_truth) return;
  const Trajectory truth = read_trajectory(*dataset.ground_truth).trajectory;
  fmt::print("\n{}\n", describe_protocol({}));
  for (const Entry& entry : entries) {
    const Evaluation errors = evaluate(truth, entry.trajectory);
    fmt::print("{:<28}ATE {:.4f} m", entry.name, errors.ate.distance.rmse);
    if (errors.rpe)
      fmt::print(", RPE {:.4f} m/s, {:.3f} deg/s", errors.rpe->translation.rmse,
                 errors.rpe->rotation.rmse);
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App program{"edvo beside OpenCV's RGB-D odometry on the same frames", "compare_opencv"};
  std::string sequence;
  std::size_t frames = 200;
  int repeats = 3, threads = 1;
  bool with_icp = false;
  program.add_option("sequence", sequence, "folder or archive")->required();
  program.add_option("--frames", frames, "at most so many")->capture_default_str();
  program.add_option("--repeats", repeats)->check(CLI::Range(1, 1000))->capture_default_str();
  program.add_option("--threads", threads, "that OpenCV may use")->capture_default_str();
  program.add_flag("--icp", with_icp, "compare with RgbdICPOdometry too (slow)");
  CLI11_PARSE(program, argc, argv);

  cv::setNumThreads(threads);
  const Dataset dataset = open_dataset(sequence);
  const DistortedCamera camera = choose_camera(dataset).camera;
  const Camera& c = camera.pinhole;
  const cv::Mat K = (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  frames = std::min(frames, dataset.frames.size());

  std::vector<Entry> entries;
  entries.push_back({.name = "edvo canny+corner",
                     .make = [&] { return std::make_unique<Edvo>(camera, Method::kCannyCorner); }});
  entries.push_back({.name = "cv::rgbd::RgbdOdometry", .make = [&] {
                       return std::make_unique<OpenCvOdometry>(cv::rgbd::RgbdOdometry::create(K));
                     }});
  if (with_icp)
    entries.push_back({.name = "cv::rgbd::RgbdICPOdometry", .make = [&] {
                         return std::make_unique<OpenCvOdometry>(
                             cv::rgbd::RgbdICPOdometry::create(K));
                       }});
  for (int r = 0; r < repeats; ++r) run_once(dataset, frames, entries);

  fmt::print("{}: {} frames, {} repeats, OpenCV {} with {} threads, edvo's odometry with one\n\n",
             dataset.name, frames, repeats, CV_VERSION, cv::getNumThreads());
  print_times(entries);
  print_errors(dataset, entries);
  return 0;
} catch (const edvo::Error& error) {
  fmt::print(stderr, "compare_opencv: {}\n", error.what());
  return static_cast<int>(error.code());
}

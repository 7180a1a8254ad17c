// SPDX-License-Identifier: MIT
// edvo and OpenCV's RGB-D odometries on the same frames, pass by pass in turn in one process, so
// that whatever slows the machine down slows all of them down.
#include "edvo/eval/evaluate.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/source/folder_source.hpp"
#include "edvo/source/prefetch.hpp"
#include "memory.hpp"

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd/depth.hpp>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <span>

namespace {

using namespace edvo;

// Reads ahead and uses each frame in its turn; frames that cannot be read are left out.
template <typename Read, typename Use>
void read_ahead(Read read, FolderSource& source, const PrefetchOptions& ahead, Use use) {
  source.rewind();
  Prefetch frames(read, source, ahead);
  while (const auto fetched = frames.next())
    if (const auto* frame = std::get_if<0>(&fetched->content)) use(*frame);
}

// What is compared: images in, a trajectory out.
class System {
 public:
  virtual ~System() = default;
  virtual void process(const RgbdImage& image) = 0;
  [[nodiscard]] virtual Trajectory trajectory() const = 0;

  // With images read ahead; tells when each is done.
  virtual void process_all(FolderSource& source, const PrefetchOptions& ahead,
                           const std::function<void()>& done) {
    const auto read = [](const PendingFrame& frame) { return frame.load(); };
    read_ahead(read, source, ahead, [&](const RgbdImage& image) {
      process(image);
      done();
    });
  }
};

class Edvo : public System {
 public:
  Edvo(const DistortedCamera& camera, Method method) : odometry_(camera, preset(method)) {}
  void process(const RgbdImage& image) override { (void)odometry_.process(image); }
  Trajectory trajectory() const override { return odometry_.trajectory(); }

  // As `edvo run` does: whoever reads an image prepares it, too.
  void process_all(FolderSource& source, const PrefetchOptions& ahead,
                   const std::function<void()>& done) override {
    cv::setNumThreads(std::max(1, ahead.threads - 1));
    const auto read = [&](const PendingFrame& frame) { return odometry_.prepare(frame.load()); };
    read_ahead(read, source, ahead, [&](const PreparedImage& image) {
      (void)odometry_.process(image);
      done();
    });
    cv::setNumThreads(ahead.threads);
  }

 private:
  Odometry odometry_;
};

// Does nothing with the images: the least that any system takes with the same reading.
class Nothing : public System {
 public:
  void process(const RgbdImage&) override {}
  Trajectory trajectory() const override { return {}; }
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

enum class Reading {
  kAhead,   // edvo's readers, on a second thread while the system works
  kImread,  // cv::imread, image by image
  kMemory,  // decoded before the clock starts
};

struct Entry {
  std::string name;
  std::function<std::unique_ptr<System>()> make;
  Reading reading = Reading::kAhead;
  std::vector<std::vector<double>> passes = {};  // wall time of each frame [ms]
  Trajectory trajectory = {};                    // of the last pass
};

RgbdImage imread_frame(const Dataset& dataset, std::size_t index) {
  const FrameEntry& entry = dataset.frames[index];
  RgbdImage image{.stamp = entry.stamp, .bgr = {}, .depth = {}};
  image.bgr = cv::imread(entry.colour.string(), cv::IMREAD_COLOR);
  const cv::Mat raw = cv::imread(entry.depth.string(), cv::IMREAD_UNCHANGED);
  raw.convertTo(image.depth, CV_32F, 1.0 / dataset.depth_scale.units_per_metre);
  image.depth.setTo(std::numeric_limits<float>::quiet_NaN(), raw == 0);
  return image;
}

// One pass over the sequence, each frame timed from the end of the one before.
void run_pass(FolderSource& source, std::span<const RgbdImage> decoded,
              const PrefetchOptions& ahead, Entry& entry) {
  const std::unique_ptr<System> system = entry.make();
  std::vector<double>& times = entry.passes.emplace_back();
  auto last = std::chrono::steady_clock::now();
  const auto done = [&] {
    const auto now = std::chrono::steady_clock::now();
    times.push_back(std::chrono::duration<double, std::milli>(now - last).count());
    last = now;
  };
  if (entry.reading == Reading::kAhead) system->process_all(source, ahead, done);
  for (std::size_t i = 0; entry.reading != Reading::kAhead && i < decoded.size(); ++i) {
    system->process(entry.reading == Reading::kMemory ? decoded[i]
                                                      : imread_frame(source.dataset(), i));
    done();
  }
  entry.trajectory = system->trajectory();
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

// "5.1 (4.9 to 5.2)": how many times longer an entry takes than the first one; median and spread
// over the passes.
std::string ratio(const Entry& entry, const Entry& first) {
  std::vector<double> ratios;
  for (std::size_t r = 0; r < entry.passes.size(); ++r)
    ratios.push_back(sum(entry.passes[r]) / sum(first.passes[r]));
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", quantile(ratios, 0.5),
                     *std::ranges::min_element(ratios), *std::ranges::max_element(ratios));
}

void print_times(const std::string& title, std::span<const Entry> entries) {
  fmt::print("{:<46}{:>10}{:>10}{:>10}{:>10}{:>24}\n", title, "median ms", "p99 ms", "mean ms",
             "frames/s", "x first (spread)");
  for (const Entry& entry : entries) {
    std::vector<double> all;
    for (const std::vector<double>& times : entry.passes)
      all.insert(all.end(), times.begin(), times.end());
    const double mean = sum(all) / static_cast<double>(all.size());
    fmt::print("{:<46}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.1f}{:>24}\n", entry.name, quantile(all, 0.5),
               quantile(all, 0.99), mean, 1000 / mean, ratio(entry, entries.front()));
  }
}

void print_errors(const SourceInfo& source, std::span<const Entry> entries) {
  if (!source.ground_truth) return;
  fmt::print("\n{}\n", describe_protocol({}));
  for (const Entry& entry : entries) {
    const Evaluation errors = evaluate(source.ground_truth->trajectory, entry.trajectory);
    fmt::print("{:<46}ATE {:.4f} m", entry.name, errors.ate.distance.rmse);
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
  std::int64_t frames = 200;
  int passes = 5, threads = 2;
  bool with_icp = false;
  program.add_option("sequence", sequence, "folder or archive")->required();
  program.add_option("--frames", frames, "at most so many")->capture_default_str();
  program.add_option("--passes", passes)->check(CLI::Range(1, 1000))->capture_default_str();
  program.add_option("--threads", threads, "for each system, reading included")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  program.add_flag("--icp", with_icp, "RgbdICPOdometry, too (slow)");
  CLI11_PARSE(program, argc, argv);

  app::keep_freed_memory();  // as the edvo program does; OpenCV gains by it, too
  app::take_memory();
  cv::setNumThreads(threads);
  FolderSource source(sequence, {.max_frames = frames});
  const DistortedCamera camera = source.info().camera;
  const Camera& c = camera.pinhole;
  const cv::Mat K = (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);

  const auto edvo_ = [&] { return std::make_unique<Edvo>(camera, Method::kCannyCorner); };
  const auto rgbd = [&] {
    return std::make_unique<OpenCvOdometry>(cv::rgbd::RgbdOdometry::create(K));
  };
  const auto icp = [&] {
    return std::make_unique<OpenCvOdometry>(cv::rgbd::RgbdICPOdometry::create(K));
  };
  std::vector<Entry> with_decoding = {
      {"edvo canny+corner, as edvo run reads", edvo_, Reading::kAhead},
      {"edvo's reading ahead, nothing else", [] { return std::make_unique<Nothing>(); },
       Reading::kAhead},
      {"cv::rgbd::RgbdOdometry, cv::imread", rgbd, Reading::kImread},
      {"cv::rgbd::RgbdOdometry, edvo's reading ahead", rgbd, Reading::kAhead}};
  std::vector<Entry> without = {{"edvo canny+corner", edvo_, Reading::kMemory},
                                {"cv::rgbd::RgbdOdometry", rgbd, Reading::kMemory}};
  if (with_icp) {
    with_decoding.push_back({"cv::rgbd::RgbdICPOdometry, cv::imread", icp, Reading::kImread});
    without.push_back({"cv::rgbd::RgbdICPOdometry", icp, Reading::kMemory});
  }

  std::vector<RgbdImage> decoded;
  while (const auto frame = source.next()) decoded.push_back(frame->load());
  for (int pass = 0; pass < passes; ++pass)
    for (std::vector<Entry>* entries : {&with_decoding, &without})
      for (Entry& entry : *entries) run_pass(source, decoded, {.threads = threads}, entry);

  fmt::print("{}: {} frames, {} passes, OpenCV {}, {} threads each\n\n", source.info().name,
             decoded.size(), passes, CV_VERSION, threads);
  print_times("Decoding included", with_decoding);
  fmt::print("\n");
  print_times("Images in memory", without);
  print_errors(source.info(), without);
  return 0;
} catch (const edvo::Error& error) {
  fmt::print(stderr, "compare_opencv: {}\n", error.what());
  return static_cast<int>(error.code());
}

// SPDX-License-Identifier: MIT
#include "recorded_run.hpp"

#include "command_line.hpp"
#include "edvo/network/edge_network.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/report/point_file.hpp"
#include "edvo/report/recorder.hpp"
#include "edvo/report/run_folder.hpp"
#include "edvo/run/run.hpp"
#include "edvo/slam/slam.hpp"
#include "memory.hpp"
#include "output_name.hpp"
#include "progress.hpp"
#include "run_map.hpp"
#include "run_result.hpp"
#include "stop_signal.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <opencv2/core/utility.hpp>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

fs::path make_run_folder(const RunFlags& flags, const std::string& sequence) {
  if (flags.output.empty()) return make_stamped_run_folder("runs", sequence);
  make_named_run_folder(flags.output, flags.force);
  return flags.output;
}

using Warn = std::function<void(const std::string&)>;

// The network, with a memory if the options ask for one; null where the method needs none. Refers
// to warn.
std::unique_ptr<EdgeDetector> open_detector(const RunFlags& flags, const Config& config,
                                            const Camera& camera, const Warn& warn) {
  const cv::Size size(camera.width, camera.height);
  if (config.edge.detector != Detector::kNetwork && flags.edge_cache.empty()) return nullptr;
  if (flags.edge_cache.empty())
    return make_strength_detector(open_network(config.network, size), config.network);
  if (config.edge.detector != Detector::kNetwork)
    throw Error(ErrorCode::kUsage,
                fmt::format("--edge-cache {}: method {} uses no network; leave the cache out or "
                            "choose --method cnn+corner",
                            flags.edge_cache, method_name(flags)));
  std::error_code error;
  fs::create_directories(flags.edge_cache, error);
  if (error || ::access(flags.edge_cache.c_str(), W_OK) != 0)
    throw Error(ErrorCode::kOutput,
                fmt::format("--edge-cache {}: cannot be written: {}", flags.edge_cache,
                            error ? error.message() : std::strerror(errno)));
  return make_strength_detector(
      open_cached_network(
          config.network, size,
          {.folder = flags.edge_cache, .warn = [&warn](const std::string& text) { warn(text); }}),
      config.network);
}

// The points, whose failure keeps nothing else from being written.
class CheckedPoints : public Observer {
 public:
  explicit CheckedPoints(const std::string& file) : points_(file) {}
  [[nodiscard]] bool wants_keyframes() const override { return points_.wants_keyframes(); }
  void keyframe(const KeyframePtr& keyframe) override { points_.keyframe(keyframe); }
  void end(const RunOutcome& outcome) override {
    try {
      points_.end(outcome);
    } catch (const Error& error) {
      failure_ = error;
    }
  }
  [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

 private:
  PointFile points_;
  std::optional<Error> failure_;
};

// What finish() says, also where it fails: the run's results are shown all the same.
std::optional<Error> finish_maps(const RunMaps& maps, const SlamInMap& slam,
                                 const RunOutcome& outcome, const fs::path& folder) {
  try {
    return maps.finish(slam, outcome.trajectory, folder);
  } catch (const Error& error) {
    return error;
  }
}

}  // namespace

RunDescription describe_run(const SourceInfo& source, const std::string& method,
                            const Config& config) {
  return edvo::describe_run(source, this_command(), method, to_toml(config));
}

RecordedRun record_run(RgbdSource& source, const RunDescription& description, const Config& config,
                       const RunFlags& flags, const std::optional<GroundTruth>& truth,
                       Observer* watcher) {
  require_distinct({{"--points", flags.points}, {"--save-map", flags.save_map}});
  require_ending("--points", flags.points, {".ply"});
  require_new("--points", flags.points, flags.force);
  std::vector<std::string> map_warnings;
  RunMaps maps(flags, config, description,
               [&](const std::string& text) { map_warnings.push_back(text); });
  take_memory();
  cv::setNumThreads(std::max(1, flags.threads - 1));  // one thread reads ahead
  Warn warn = [](const std::string&) {};
  std::unique_ptr<EdgeDetector> detector =
      open_detector(flags, config, description.camera.pinhole, warn);
  Recorder recorder(make_run_folder(flags, description.sequence), description, !flags.no_report);
  Progress progress(flags.quiet);
  Observers observers = {&recorder, &progress};
  CheckedPoints points(flags.points);
  if (!flags.points.empty()) observers.push_back(&points);
  if (watcher != nullptr) observers.push_back(watcher);
  warn = [&](const std::string& text) {
    for (Observer* const observer : observers) observer->warning(text);
  };

  const StopSignal signal;  // also while the results are written
  const RunOptions options{
      .threads = flags.threads, .should_stop = stop_requested, .ground_truth = truth};
  const auto run_with = [&](auto&& tracker) { return run(source, tracker, observers, options); };
  for (const std::string& text : map_warnings) warn(text);
  RecordedRun result;
  const auto run_slam = [&] {
    SlamInMap slam(description.camera, config,
                   {.loops = {}, .links = {}, .keep_colour = maps.writes()}, std::move(detector),
                   maps.origin(), maps.take_earlier(), flags.update_map);
    RunOutcome outcome = run_with(slam);
    result.failure = finish_maps(maps, slam, outcome, recorder.folder());
    if (slam.localization())
      result.localized = localized_frames(*slam.localization(), outcome.trajectory);
    return outcome;
  };
  const bool with_loops = !flags.no_loops && has_back_end(config);
  const RunOutcome outcome =
      with_loops ? run_slam() : run_with(Odometry(description.camera, config, std::move(detector)));
  result.summary = recorder.summary();
  result.folder = recorder.folder();
  const std::optional<Error> failure = failure_of(outcome, description.source);
  if (failure)
    result.failure =
        Error(failure->code(), fmt::format("{}; what was tried is in {}", failure->what(),
                                           (result.folder / "frames.jsonl").string()));
  if (!result.failure) result.failure = points.failure();
  return result;
}

void run_and_show(RgbdSource& source, const Config& config, const RunFlags& flags,
                  Observer* watcher, const std::vector<std::string>& findings) {
  RunDescription description = describe_run(source.info(), method_name(flags), config);
  description.warnings.insert(description.warnings.end(), findings.begin(), findings.end());
  show_choices(description, flags);
  const RecordedRun run = record_run(source, description, config, flags, {}, watcher);
  const bool is_empty = run.failure && run.failure->code() == ErrorCode::kTrackingLost;
  if (!is_empty) show_result(run, flags);
  if (run.failure) throw Error(*run.failure);
  if (run.summary.interrupted) throw CLI::RuntimeError("interrupted", kInterruptedStatus);
}

std::unique_ptr<Observer> make_observer(const Extension& extension, Extension::Values values,
                                        bool force) {
  if (force) values["--force"] = "1";
  return extension.make_observer ? extension.make_observer(values) : nullptr;
}

}  // namespace edvo::app

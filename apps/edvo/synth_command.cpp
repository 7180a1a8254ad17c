// SPDX-License-Identifier: MIT
// edvo synth OUT: writes a rendered sequence as a TUM-layout folder.
#include "commands.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/camera_file.hpp"
#include "edvo/io/image_file.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/synth/parallel.hpp"
#include "sequence_flags.hpp"
#include "stop_signal.hpp"
#include "terminal.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <memory>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

constexpr double kDepthUnitsPerMetre = 5000;  // as in the TUM data sets

struct Arguments {
  std::string out;
  SequenceFlags sequence;
  int threads = 0;  // 0 = all of the machine's
  bool force = false, json = false;
};

[[noreturn]] void cannot(const std::string& what, const fs::path& path, const std::string& why) {
  throw Error(ErrorCode::kOutput, fmt::format("{}: cannot {}, {}", path.string(), what, why));
}

// Makes the folders and empties them of an older sequence.
void prepare_folder(const fs::path& folder, bool force) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    cannot("write the sequence there", folder, "it is a file; give a folder");
  if (!force && fs::is_directory(folder, error) && !fs::is_empty(folder, error))
    cannot("write the sequence there", folder,
           "the folder is not empty; give another one, or --force to replace its sequence");
  for (const char* name : {"rgb", "depth"}) {
    fs::remove_all(folder / name, error);
    if (!error) fs::create_directories(folder / name, error);
    if (error) cannot("make the folder", folder / name, error.message());
  }
}

cv::Mat_<std::uint16_t> to_depth_units(const cv::Mat_<float>& metres) {
  constexpr double kSaturated = 65535;
  cv::Mat_<std::uint16_t> raw(metres.size());
  for (int y = 0; y < raw.rows; ++y)
    for (int x = 0; x < raw.cols; ++x) {
      const double units = std::round(metres(y, x) * kDepthUnitsPerMetre);
      raw(y, x) = units > 0 && units < kSaturated ? static_cast<std::uint16_t>(units) : 0;
    }
  return raw;
}

// Writes both images of a frame and returns its stamp as in their names.
std::string write_frame(const synth::SyntheticSequence& sequence, int index,
                        const fs::path& folder) {
  const RgbdImage image = synth::make_frame(sequence, index);
  const std::string stamp = to_string(image.stamp);
  write_png(folder / "rgb" / (stamp + ".png"), image.bgr);
  write_png(folder / "depth" / (stamp + ".png"), to_depth_units(image.depth));
  return stamp;
}

// Frames are made side by side, a batch at a time; the lists grow with what is on disk, so that
// Ctrl-C leaves a shorter sequence but a whole one.
void write_frames(const synth::SyntheticSequence& sequence, int threads, const fs::path& folder) {
  LineFile colour_list(folder / "rgb.txt"), depth_list(folder / "depth.txt");
  colour_list.append("# colour images\n# timestamp filename");
  depth_list.append("# depth images\n# timestamp filename");
  const int count = synth::frame_count(sequence), batch = synth::thread_count(threads);
  const StopSignal signal;
  for (int first = 0; first < count; first += batch) {
    if (stop_requested()) {
      say("edvo: interrupted, {} of {} frames are written\n", first, count);
      throw CLI::RuntimeError("interrupted", kInterruptedStatus);
    }
    std::vector<std::future<std::string>> stamps;
    for (int index = first; index < std::min(first + batch, count); ++index)
      stamps.push_back(std::async(std::launch::async, [&sequence, &folder, index] {
        return write_frame(sequence, index, folder);
      }));
    for (std::future<std::string>& future : stamps) {
      const std::string stamp = future.get();
      colour_list.append(fmt::format("{0} rgb/{0}.png", stamp));
      depth_list.append(fmt::format("{0} depth/{0}.png", stamp));
    }
    const int tenths_before = 10 * first / count;
    const int tenths = std::min(10 * (first + batch) / count, 10);
    if (tenths > tenths_before) say("synth: {} % of {} frames\n", 10 * tenths, count);
  }
}

void write_sequence(const Arguments& arguments) {
  const fs::path folder = arguments.out;
  synth::SyntheticSequence sequence = make_sequence(arguments.sequence);
  sequence.threads = 1;  // frames are made side by side instead
  const Trajectory truth = synth::ground_truth(sequence);
  prepare_folder(folder, arguments.force);
  write_whole(folder / "camera.toml",
              camera_to_toml(sequence.camera) +
                  fmt::format("depth_scale = {}  # units per metre\n", kDepthUnitsPerMetre));
  write_trajectory(folder / "groundtruth.txt", truth);
  write_frames(sequence, arguments.threads, folder);

  const int frames = synth::frame_count(sequence);
  const double seconds = seconds_between(truth.front().stamp, truth.back().stamp);
  if (arguments.json) {
    const nlohmann::ordered_json result = {{"folder", folder.string()},
                                           {"frames", frames},
                                           {"seconds", seconds},
                                           {"path_length_m", path_length(truth)}};
    print_bytes(result.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
  } else {
    print("{}: {} frames, {:.2f} s, path of {:.2f} m\n", folder.string(), frames, seconds,
          path_length(truth));
  }
}

}  // namespace

void add_synth_command(CLI::App& program) {
  constexpr int kMostThreads = 256;
  CLI::App* verb = program.add_subcommand(
      "synth", "Render a room with a Kinect-like camera: a TUM-layout folder with ground truth");
  const auto arguments = std::make_shared<Arguments>();
  verb->add_option("OUT", arguments->out, "folder to write")->required();
  add_sequence_flags(*verb, arguments->sequence);
  verb->add_option("--threads", arguments->threads, "0 = all of the machine's")
      ->check(CLI::Range(0, kMostThreads))
      ->capture_default_str();
  verb->add_flag("--force", arguments->force, "replace the sequence in a folder that is not empty");
  verb->add_flag("--json", arguments->json, "print one JSON object");
  verb->callback([arguments] { write_sequence(*arguments); });
}

}  // namespace edvo::app

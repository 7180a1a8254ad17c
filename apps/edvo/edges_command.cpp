// SPDX-License-Identifier: MIT
// edvo edges IMAGE|FOLDER -o OUT
#include "commands.hpp"
#include "config_flags.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/image_file.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/io/strength_file.hpp"
#include "edvo/network/edge_network.hpp"
#include "output_name.hpp"
#include "terminal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path input;
  fs::path output;
  std::string detector;  // empty = as the other options say
  ConfigFlags config;
  bool strength = false, raw = false, force = false;
  int threads = 2;
};

struct Task {
  fs::path image, result;
};

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_image(const fs::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

std::vector<fs::path> images_in(const fs::path& folder) {
  std::vector<fs::path> images;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && is_image(entry.path())) images.push_back(entry.path());
  if (images.empty())
    throw Error(ErrorCode::kInput,
                fmt::format("{}: no PNG or JPEG image in this folder", folder.string()));
  std::ranges::sort(images);
  return images;
}

// What is read and what is written, so that nothing is written over an image or another result.
std::vector<Task> plan(const Arguments& arguments) {
  const fs::path& output = arguments.output;
  const std::string ending = arguments.raw ? ".npy" : ".png";
  std::vector<Task> tasks;
  if (fs::is_directory(arguments.input)) {
    for (const fs::path& image : images_in(arguments.input))
      tasks.push_back({image, output / (image.stem().string() + ending)});
  } else {
    const bool is_file = lower_extension(output) == ending && !fs::is_directory(output);
    const fs::path name = arguments.input.stem().string() + ending;
    tasks.push_back({arguments.input, is_file ? output : output / name});
  }
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (i > 0 && tasks[i].result == tasks[i - 1].result)
      throw Error(
          ErrorCode::kInput,
          fmt::format("{} and {} would both become {}; rename one", tasks[i - 1].image.string(),
                      tasks[i].image.string(), tasks[i].result.string()));
    std::error_code ignored;
    if (fs::equivalent(tasks[i].image, tasks[i].result, ignored))
      throw Error(ErrorCode::kUsage,
                  fmt::format("-o {}: {} would be overwritten; choose another folder",
                              output.string(), tasks[i].image.string()));
  }
  return tasks;
}

Config resolve(const Arguments& arguments) {
  ConfigFlags flags = arguments.config;
  if (!arguments.detector.empty())
    flags.method = name_of(arguments.detector == "network" ? Method::kCnn : Method::kCanny);
  Config config = resolve_config(flags);
  if (config.edge.detector == Detector::kNone)
    throw Error(ErrorCode::kUsage,
                "edge.detector = \"none\" finds no edges; choose --detector "
                "canny or network");
  return config;
}

cv::Mat_<std::uint8_t> gray_of(const cv::Mat_<cv::Vec3b>& bgr) {
  cv::Mat gray;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

// The mask that odometry uses, or the strength, in 255 steps or as it is.
void write_edges(const fs::path& file, const cv::Mat_<cv::Vec3b>& bgr, const EdgeStrength* network,
                 const Config& config, const Arguments& arguments) {
  if (network == nullptr) {
    const cv::Mat_<std::uint8_t> edges = canny_edges(gray_of(bgr), config.canny);
    if (!arguments.raw) return write_png(file, edges);
    cv::Mat_<float> ones;  // without a network the strength is 0 or 1
    edges.convertTo(ones, CV_32F, 1 / 255.);
    return write_npy(file, ones);
  }
  const cv::Mat_<float> strength = network->strength(bgr);
  if (arguments.raw) return write_npy(file, strength);
  if (!arguments.strength)
    return write_png(file, edges_of_strength(strength, gray_of(bgr), config.network));
  cv::Mat_<std::uint8_t> levels;
  strength.convertTo(levels, CV_8U, 255);
  write_png(file, levels);
}

void detect_edges(const Arguments& arguments) {
  const Config config = resolve(arguments);
  const std::vector<Task> tasks = plan(arguments);
  for (const Task& task : tasks)
    if (fs::exists(task.result.parent_path()))
      require_new("-o", task.result.string(), arguments.force);
  cv::setNumThreads(arguments.threads);
  std::unique_ptr<EdgeStrength> network;
  for (const Task& task : tasks) {
    const cv::Mat_<cv::Vec3b> bgr = read_colour(task.image);
    if (config.edge.detector == Detector::kNetwork && !network)
      network = open_network(config.network, bgr.size());
    make_folder(task.result.parent_path());
    write_edges(task.result, bgr, network.get(), config, arguments);
  }
  print("{} edge map{} written to {}\n", tasks.size(), tasks.size() == 1 ? "" : "s",
        arguments.output.string());
}

}  // namespace

void add_edges_command(CLI::App& program) {
  constexpr int kMostThreads = 256;
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* verb = program.add_subcommand("edges", "Write the edge maps of images");
  verb->add_option("input", arguments->input, "PNG or JPEG image, or a folder of them")
      ->required()
      ->type_name("IMAGE|FOLDER");
  verb->add_option("-o,--output", arguments->output, "Folder, or for one image a file name")
      ->required()
      ->type_name("OUT");
  verb->add_option("--detector", arguments->detector, "canny or network")
      ->check(CLI::IsMember({"canny", "network"}));
  add_config_flags(*verb, arguments->config);
  verb->get_option("--detector")->excludes(verb->get_option("--method"));
  verb->add_flag("--strength", arguments->strength,
                 "Write the network's edge strength instead of thin edges");
  verb->add_flag("--raw", arguments->raw,
                 "Write it as NumPy's .npy instead, 32-bit floats, nothing rounded")
      ->excludes("--strength");
  verb->add_flag("--force", arguments->force, "Replace edge maps that are there");
  verb->add_option("--threads", arguments->threads, "Threads of the network")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads))
      ->capture_default_str();
  verb->callback([arguments] { detect_edges(*arguments); });
}

}  // namespace edvo::app

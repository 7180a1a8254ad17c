// SPDX-License-Identifier: MIT
// Edge networks through both engines in turn, in one process: a busy machine slows both down alike.
#include "edvo/core/error.hpp"
#include "edvo/eval/statistics.hpp"
#include "edvo/io/model_file.hpp"
#include "edvo/network/edge_network.hpp"
#include "memory.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <opencv2/core/utility.hpp>

namespace {

using Clock = std::chrono::steady_clock;

struct Entry {
  std::string name;
  std::unique_ptr<edvo::EdgeStrength> detector;
  double prepared = 0;          // [ms]
  std::vector<double> forward;  // [ms]
  cv::Mat_<float> answer;
};

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

Entry entry_of(const std::string& model, edvo::InferenceEngine engine, cv::Size size) {
  const bool is_own = model == "own";
  const edvo::Model file = is_own ? edvo::own_model() : edvo::read_model(model);
  Entry entry{.name = fmt::format("{} {}", is_own ? "edvo_edges" : file.description.name,
                                  engine == edvo::InferenceEngine::kOneDnn ? "oneDNN" : "OpenCV"),
              .detector = nullptr,
              .forward = {},
              .answer = {}};
  const auto start = Clock::now();
  entry.detector = edvo::make_network_strength(file, size, engine);
  entry.prepared = milliseconds_since(start);
  return entry;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Compare the engines that run edge networks");
  std::vector<std::string> models = {"own"};
  int rounds = 11, threads = 2;
  cv::Size size(640, 480);
  app.add_option("models", models, "description files; own = edvo's network");
  app.add_option("--rounds", rounds, "forward passes of each, in turn")->check(CLI::Range(1, 1000));
  app.add_option("--threads", threads)->check(CLI::Range(1, 64));
  app.add_option("--width", size.width)->check(CLI::Range(16, 10000));
  app.add_option("--height", size.height)->check(CLI::Range(16, 10000));
  CLI11_PARSE(app, argc, argv);

  edvo::app::keep_freed_memory();  // as the edvo program does
  cv::setNumThreads(threads);
  cv::Mat_<cv::Vec3b> image(size);
  cv::randu(image, 0, 255);
  std::vector<Entry> entries;
  for (const std::string& model : models)
    for (const auto engine : {edvo::InferenceEngine::kOneDnn, edvo::InferenceEngine::kOpenCv}) try {
        entries.push_back(entry_of(model, engine, size));
      } catch (const edvo::Error& error) {
        if (engine == edvo::InferenceEngine::kOpenCv) throw;
        fmt::print("{}\n", error.what());
      }
  for (int round = 0; round <= rounds; ++round)
    for (Entry& entry : entries) {
      const auto start = Clock::now();
      entry.answer = entry.detector->strength(image);
      if (round > 0) entry.forward.push_back(milliseconds_since(start));  // the first warms up
    }
  fmt::print("{} x {} px, {} threads, {} rounds\n{:30} {:>12} {:>12} {:>12} {:>10}\n", size.width,
             size.height, threads, rounds, "", "prepare [ms]", "median [ms]", "least [ms]",
             "ratio");
  for (const Entry& entry : entries)
    fmt::print("{:30} {:12.0f} {:12.1f} {:12.1f} {:10.2f}\n", entry.name, entry.prepared,
               edvo::median(entry.forward), *std::ranges::min_element(entry.forward),
               edvo::median(entry.forward) / edvo::median(entries.front().forward));
} catch (const std::exception& error) {
  fmt::print(stderr, "engines: {}\n", error.what());
  return 1;
}

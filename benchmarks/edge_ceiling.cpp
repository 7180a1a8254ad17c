// SPDX-License-Identifier: MIT
// What the best possible edge map gives: a rendered sequence is followed with edges that were found
// in another rendering of the same frames, without noise, blur and moving shadows. What is aligned
// are the images of the first. benchmarks/network.py calls it.
//
// edge_ceiling SEQUENCE CLEAN [GROUP.FIELD=VALUE...] [DESCRIPTION...]
//
// prints one JSON object of errors for each kind of edges, and for each network described, with
// these options of canny+corner changed.
#include "edvo/core/error.hpp"
#include "edvo/eval/evaluate.hpp"
#include "edvo/features/edge_strength.hpp"
#include "edvo/io/model_file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/network/edge_network.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/slam/slam.hpp"
#include "edvo/source/folder_source.hpp"

#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace edvo;

using Mask = cv::Mat_<std::uint8_t>;  // H x W, 255 = edge

// A frame as it was taken, and without faults.
struct Twin {
  const EdgeInput& taken;
  const RgbdImage& clean;
  const Camera& camera;
};

using FindEdges = std::function<Mask(const Twin&)>;

Mask gray_of(const RgbdImage& image) {
  Mask gray;
  cv::cvtColor(image.bgr, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

// Asks a function, with the clean image of the frame in hand.
class TwinDetector final : public EdgeDetector {
 public:
  TwinDetector(FindEdges find, Camera camera, const RgbdImage& clean)
      : find_(std::move(find)), camera_(camera), clean_(clean) {}

  [[nodiscard]] Mask detect(const EdgeInput& image) const override {
    return find_({image, clean_, camera_});
  }

 private:
  FindEdges find_;
  Camera camera_;
  const RgbdImage& clean_;
};

// Jumps of depth on their near side, and creases: pixels whose surface bends within two pixels.
Mask geometric_edges(const cv::Mat_<float>& depth, const Camera& camera) {
  constexpr int kStep = 2;             // [px]
  constexpr float kJump = 0.04F;       // of the depth
  constexpr float kLeastBend = 0.35F;  // [rad]
  Mask edges(depth.size(), 0);
  const auto bend = [&](float before, float here, float after, double focal) {
    const float step = kStep * here / static_cast<float>(std::abs(focal));
    return std::abs(std::atan2(after - here, step) - std::atan2(here - before, step));
  };
  for (int y = kStep; y < depth.rows - kStep; ++y)
    for (int x = kStep; x < depth.cols - kStep; ++x) {
      const float z = depth(y, x);
      const float left = depth(y, x - kStep), right = depth(y, x + kStep);
      const float up = depth(y - kStep, x), down = depth(y + kStep, x);
      const bool is_jump = std::max({depth(y, x - 1), depth(y, x + 1), depth(y - 1, x),
                                     depth(y + 1, x)}) > (1 + kJump) * z;
      const bool is_crease =
          bend(left, z, right, camera.fx) > kLeastBend || bend(up, z, down, camera.fy) > kLeastBend;
      if (z > 0 && (is_jump || is_crease)) edges(y, x) = 255;
    }
  return edges;
}

Mask widened(const Mask& edges) {
  Mask wide;
  cv::dilate(edges, wide, cv::Mat::ones(3, 3, CV_8U));
  return wide;
}

struct Kind {
  std::string name;
  FindEdges find;
};

FindEdges of_network(const EdgeStrength& strength, NetworkOptions options) {
  return [&strength, options](const Twin& twin) {
    return edges_of_strength(strength.strength(twin.taken.colour()), twin.taken.gray, options);
  };
}

// Other ways to use the strength.
std::vector<Kind> uses_of(const NetworkOptions& usual, const EdgeStrength& own) {
  NetworkOptions less = usual, more = usual, blurred = usual;
  less.edge_exponent = 0.25;
  more.edge_exponent = 1;
  blurred.canny.blur_sigma = 1;
  return {{"network, exponent 0.25", of_network(own, less)},
          {"network, exponent 1", of_network(own, more)},
          {"network, blur of 1 px", of_network(own, blurred)}};
}

std::vector<Kind> kinds_of(const Config& config, const EdgeStrength& own) {
  const CannyOptions canny = config.canny;
  const NetworkOptions network = config.network;
  const auto clean_canny = [canny](const Twin& twin) {
    return canny_edges(gray_of(twin.clean), canny);
  };
  const auto clean_network = [network, &own](const Twin& twin) {
    return edges_of_strength(own.strength(twin.clean.bgr), gray_of(twin.clean), network);
  };
  const auto true_strength = [clean_canny](const Twin& twin) {
    const Mask edges = clean_canny(twin);
    cv::Mat_<float> strength;
    edges.convertTo(strength, CV_32F, 1 / 255.0);
    return strength;
  };
  return {
      {"canny", [canny](const Twin& twin) { return canny_edges(twin.taken.gray, canny); }},
      {"network", of_network(own, network)},
      {"clean canny", clean_canny},
      {"clean network", clean_network},
      {"clean geometry and canny",
       [clean_canny](const Twin& twin) {
         return Mask(clean_canny(twin) | geometric_edges(twin.clean.depth, twin.camera));
       }},
      {"clean geometry",
       [](const Twin& twin) { return widened(geometric_edges(twin.clean.depth, twin.camera)); }},
      {"canny, only true ones",
       [canny, clean_canny](const Twin& twin) {
         return Mask(canny_edges(twin.taken.gray, canny) & widened(clean_canny(twin)));
       }},
      {"true strength",
       [network, true_strength](const Twin& twin) {
         return edges_of_strength(true_strength(twin), twin.taken.gray, network);
       }},
      {"strength of the clean image",
       [network, &own](const Twin& twin) {
         return edges_of_strength(own.strength(twin.clean.bgr), twin.taken.gray, network);
       }},
      {"every pixel", [](const Twin& twin) { return Mask(twin.taken.gray.size(), 255); }},
  };
}

// tracker: an Odometry or a Slam.
template <typename T>
void follow(FolderSource& taken, FolderSource& clean, const std::string& name, T tracker,
            RgbdImage& clean_image) {
  int frames = 0, lost = 0;
  double points = 0;
  while (const auto pending = taken.next()) {
    clean_image = clean.next()->load();
    const FrameResult result = tracker.process(pending->load());
    ++frames;
    points += result.points;
    lost += result.status == FrameStatus::kLost ? 1 : 0;
  }
  tracker.finish();
  try {
    const Evaluation errors = evaluate(taken.info().ground_truth->trajectory, tracker.trajectory());
    fmt::print(R"({{"edges": "{}", "ate": {:.6f}, "rpe": {:.6f}, "lost": {}, "points": {:.0f}}})",
               name, errors.ate.distance.rmse, errors.rpe ? errors.rpe->translation.rmse : NAN,
               lost, points / frames);
  } catch (const Error&) {
    fmt::print(R"({{"edges": "{}", "ate": null, "rpe": null, "lost": {}}})", name, lost);
  }
  fmt::print("\n");
}

void follow(FolderSource& taken, FolderSource& clean, const Kind& kind, const Config& config) {
  taken.rewind();
  clean.rewind();
  RgbdImage clean_image;
  const DistortedCamera& camera = taken.info().camera;
  auto detector = std::make_unique<TwinDetector>(kind.find, camera.pinhole, clean_image);
  if (has_back_end(config))
    follow(taken, clean, kind.name, Slam(camera, config, {}, std::move(detector)), clean_image);
  else
    follow(taken, clean, kind.name, Odometry(camera, config, std::move(detector)), clean_image);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "edge_ceiling SEQUENCE CLEAN [GROUP.FIELD=VALUE...] [DESCRIPTION...]\n");
    return 2;
  }
  cv::setNumThreads(1);
  FolderSource taken(argv[1]), clean(argv[2]);
  const Camera& camera = taken.info().camera.pinhole;
  Config config = preset(Method::kCannyCorner);
  std::vector<std::string> models;
  for (const std::string argument : std::span(argv + 3, static_cast<std::size_t>(argc - 3))) {
    if (argument.find('=') != std::string::npos)
      set_option(config, argument);
    else
      models.push_back(argument);
  }
  const cv::Size size(camera.width, camera.height);
  const std::unique_ptr<EdgeStrength> own = open_network(config.network, size);
  for (const Kind& kind : kinds_of(config, *own)) follow(taken, clean, kind, config);
  for (const Kind& kind : uses_of(config.network, *own)) follow(taken, clean, kind, config);
  for (const std::string& model : models) {
    const std::unique_ptr<EdgeStrength> other = open_network({.model = model}, size);
    follow(taken, clean, {model, of_network(*other, config.network)}, config);
  }
}

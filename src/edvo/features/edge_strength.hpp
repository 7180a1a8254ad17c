// SPDX-License-Identifier: MIT
// Edges from a map of edge strength, such as a network's (paper, section III-A).
#pragma once

#include "edvo/features/edge_detector.hpp"

#include <concepts>
#include <memory>
#include <string>

namespace edvo {

class EdgeStrength {
 public:
  virtual ~EdgeStrength() = default;

  // bgr: H x W, 8-bit, undistorted. Returns H x W, [0..1]. Thread-safe, same bits each time.
  [[nodiscard]] virtual cv::Mat_<float> strength(const cv::Mat_<cv::Vec3b>& bgr) const = 0;
};

struct NetworkOptions {
  std::string model;           // path of a description; empty = edvo's own network
  double edge_exponent = 0.5;  // [1]
  CannyOptions canny{.blur_sigma = 0.7};
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, NetworkOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("model", self.model, Range{},
        "description file of the network (docs/models.md); empty = edvo's own");
  visit("edge_exponent", self.edge_exponent, Range{0, 10},
        "power of the network's strength that weighs the gradient; 0 = Canny's edges");
}

// Canny on the gradient times strength^edge_exponent (docs/adr/0007). strength, gray: H x W of the
// same image. Returns H x W, 255 = edge, one pixel wide.
[[nodiscard]] cv::Mat_<std::uint8_t> edges_of_strength(const cv::Mat_<float>& strength,
                                                       const cv::Mat_<std::uint8_t>& gray,
                                                       const NetworkOptions& options);

// The detector that does this with the strength of each image.
[[nodiscard]] std::unique_ptr<EdgeDetector> make_strength_detector(
    std::unique_ptr<EdgeStrength> source, const NetworkOptions& options);

}  // namespace edvo

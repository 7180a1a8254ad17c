// SPDX-License-Identifier: MIT
// Edges by a network (paper, section III-A): an ONNX file run by oneDNN or OpenCV.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/features/canny.hpp"
#include "edvo/features/edge_detector.hpp"
#include "edvo/network/cached_detector.hpp"
#include "edvo/network/inference.hpp"

#include <concepts>
#include <memory>
#include <string>

namespace edvo {

struct Model;  // edvo/io/model_file.hpp

struct NetworkOptions {
  std::string model;           // path of a description; empty = edvo's own network
  double edge_exponent = 0.5;  // exponent
  CannyOptions crests{.blur_sigma = 0.7};
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, NetworkOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("model", self.model, Range{},
        "description file of the network (docs/models.md); empty = edvo's own");
  visit("edge_exponent", self.edge_exponent, Range{0, 10},
        "power of the network's strength that weighs the gradient; 0 = Canny's edges");
  visit_fields(self.crests, visit);  // of the weighted gradient
}

// Runs the network once on a blank image of this size, so that a model that does not fit fails here
// and not in the middle of a run. Throws Error(kModel) if the engine cannot load or run it, if its
// weights or its output are not finite, or its output is of another size than its input. Uses as
// many threads as cv::setNumThreads says; the result does not depend on it.
[[nodiscard]] std::unique_ptr<EdgeDetector> make_network_detector(
    const Model& model, cv::Size image_size, InferenceEngine engine = InferenceEngine::kAuto);

// The same for the description file of the options, or edvo's own network if they name none.
[[nodiscard]] std::unique_ptr<EdgeDetector> open_network(const NetworkOptions& options,
                                                         cv::Size image_size);

// And one that remembers its answers.
[[nodiscard]] std::unique_ptr<EdgeDetector> open_cached_network(const NetworkOptions& options,
                                                                cv::Size image_size,
                                                                EdgeCache cache);

// The same for two models only if their answers are, too: a hash of the weights, of what their
// description says of input and output, and of the engine.
[[nodiscard]] std::string fingerprint(const Model& model);

// The crests of the image's gradient where the network sees edges: Canny on the gradient times the
// strength to the power of `edge_exponent` (docs/adr/0007). strength, gray: H x W of the same
// image. Returns H x W, 255 = edge, one pixel wide.
[[nodiscard]] cv::Mat_<std::uint8_t> network_edges(const cv::Mat_<float>& strength,
                                                   const cv::Mat_<std::uint8_t>& gray,
                                                   const NetworkOptions& options);

}  // namespace edvo

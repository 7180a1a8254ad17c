// SPDX-License-Identifier: MIT
// Edges by a network (paper, section III-A): an ONNX file run by oneDNN or OpenCV.
#pragma once

#include "edvo/features/edge_strength.hpp"
#include "edvo/network/cached_strength.hpp"
#include "edvo/network/inference.hpp"

#include <memory>
#include <string>

namespace edvo {

struct Model;  // edvo/io/model_file.hpp

// Runs the network once on a blank image of this size, so that a model that does not fit fails here
// and not in the middle of a run. Throws Error(kModel) if the engine cannot load or run it, if its
// weights or its output are not finite, or its output is of another size than its input. Uses as
// many threads as cv::setNumThreads says; the result does not depend on it.
[[nodiscard]] std::unique_ptr<EdgeStrength> make_network_strength(
    const Model& model, cv::Size image_size, InferenceEngine engine = InferenceEngine::kAuto);

// The same for the description file of the options, or edvo's own network if they name none.
[[nodiscard]] std::unique_ptr<EdgeStrength> open_network(const NetworkOptions& options,
                                                         cv::Size image_size);

// And one that remembers its answers.
[[nodiscard]] std::unique_ptr<EdgeStrength> open_cached_network(const NetworkOptions& options,
                                                                cv::Size image_size,
                                                                EdgeCache cache);

// The same for two models only if their answers are, too: a hash of the weights, of what their
// description says of input and output, and of the engine.
[[nodiscard]] std::string fingerprint(const Model& model);

}  // namespace edvo

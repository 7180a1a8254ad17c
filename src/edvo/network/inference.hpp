// SPDX-License-Identifier: MIT
// What computes a network's answer: OpenCV's dnn module, which knows most of ONNX's operators, or
// oneDNN, several times as fast with those of edge networks (docs/models.md has the figures).
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace edvo {

struct OnnxGraph;  // edvo/network/onnx_graph.hpp

enum class InferenceEngine {
  kAuto,  // oneDNN if it knows all of the network's operators
  kOneDnn,
  kOpenCv
};

class Inference {
 public:
  virtual ~Inference() = default;

  // The image in the network's numbers, H x W -> the network's output. Uses at most as many threads
  // as cv::setNumThreads says; the result does not depend on it. Throws Error(kModel), naming the
  // reason but not the file, if the network cannot run on this size.
  [[nodiscard]] virtual cv::Mat forward(const cv::Mat_<cv::Vec3f>& image) = 0;
};

// Both throw Error(kModel), naming the reason but not the file, if the engine cannot load the
// network; its weights must be plain floats (onnx_weights.hpp). `output` is one of the file's
// outputs.
[[nodiscard]] std::unique_ptr<Inference> make_opencv_inference(const std::string& onnx,
                                                               const std::string& output);
// Prepared for this size; another is prepared when it comes.
[[nodiscard]] std::unique_ptr<Inference> make_onednn_inference(OnnxGraph graph,
                                                               const std::string& output,
                                                               cv::Size size);

// The version of oneDNN, for a fingerprint.
[[nodiscard]] std::string onednn_version();

}  // namespace edvo

// SPDX-License-Identifier: MIT
// A network as oneDNN's primitives, for one size of its input.
#pragma once

#include "edvo/network/onnx_graph.hpp"

#include <dnnl.hpp>
#include <opencv2/core/mat.hpp>
#include <string>
#include <unordered_map>
#include <vector>

namespace edvo {

struct NetworkPlan {
  struct Step {
    dnnl::primitive primitive;
    std::unordered_map<int, dnnl::memory> arguments;
  };

  dnnl::memory::dims image;  // 1 x 3 x H x W
  dnnl::engine engine{dnnl::engine::kind::cpu, 0};
  dnnl::stream stream{engine};
  std::vector<dnnl::memory> buffers;  // that the steps' values lie in
  std::vector<Step> steps;            // in their order
  dnnl::memory input, output;         // channels last, plain
};

// The steps that an output of the graph needs. Threads: as many as OpenMP has now, and when it
// runs. Throws Error(kModel) or dnnl::error, saying what oneDNN or this cannot do.
[[nodiscard]] NetworkPlan plan_network(const OnnxGraph& graph, const std::string& output,
                                       const dnnl::memory::dims& image);

// The image as large as the plan's. Returns floats of the output's shape.
[[nodiscard]] cv::Mat run(NetworkPlan& plan, const cv::Mat_<cv::Vec3f>& image);

}  // namespace edvo

// SPDX-License-Identifier: MIT
// The nodes of an ONNX file, their attributes and the constants that they use.
#pragma once

#include "edvo/network/onnx_tensor.hpp"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

// One operator.
struct OnnxNode {
  std::string type;
  std::vector<std::string> inputs, outputs;
  std::map<std::string, std::string, std::less<>> attributes;  // AttributeProto by name
};

struct OnnxGraph {
  std::vector<OnnxNode> nodes;  // every one after those whose outputs it uses; without Constant
  std::map<std::string, OnnxTensor, std::less<>> constants;
  std::string image;  // the one input that is no constant
};

// All throw Error(kModel) naming what is damaged, not the file.
[[nodiscard]] OnnxNode onnx_node(std::string_view node);
[[nodiscard]] OnnxGraph onnx_graph(std::string_view onnx);

// The image among a graph's inputs that are no constants: the only one.
[[nodiscard]] std::string only_image(const std::vector<std::string>& inputs);

// The outputs alone, in the order of the file: OpenCV lists them by the alphabet.
[[nodiscard]] std::vector<std::string> onnx_outputs(std::string_view onnx);

// An attribute's value; none where the node does not have it.
[[nodiscard]] std::optional<std::int64_t> integer(const OnnxNode& node, std::string_view name);
[[nodiscard]] std::vector<std::int64_t> integers(const OnnxNode& node, std::string_view name);
[[nodiscard]] std::string text(const OnnxNode& node, std::string_view name);
[[nodiscard]] std::optional<OnnxTensor> tensor(const OnnxNode& node, std::string_view name);

}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/network/onnx_weights.hpp"

#include "edvo/core/error.hpp"
#include "edvo/network/onnx_fields.hpp"
#include "edvo/network/onnx_graph.hpp"
#include "edvo/network/protobuf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace edvo {
namespace {

using protobuf::Field;

using namespace onnx_field;

[[noreturn]] void fail(const std::string& reason) {
  throw Error(ErrorCode::kModel, reason);
}

Quantization quantization_of(const OnnxNode& node) {
  Quantization quantization;
  quantization.axis = integer(node, "axis").value_or(quantization.axis);
  quantization.block_size = integer(node, "block_size").value_or(quantization.block_size);
  return quantization;
}

// What is known of a graph before it runs.
class Folding {
 public:
  explicit Folding(std::string_view graph) : fields_(onnx_fields(graph)) {
    for (const Field& field : fields_) {
      if (field.number == kGraphInitializer) {
        // OpenCV believes the shapes and would read beyond the data.
        check_onnx_tensor(field.content);
        stored_[onnx_tensor_name(field.content)] = field.content;
      }
      if (field.number != kGraphOutput && field.number != kGraphInput) continue;
      for (const Field& value : onnx_fields(field.content))
        if (value.number == kValueName)
          (field.number == kGraphOutput ? outputs_ : inputs_).emplace(value.content);
    }
    std::vector<OnnxNode> nodes;
    std::vector<std::string_view> contents;
    for (const Field& field : fields_)
      if (field.number == kGraphNode) {
        nodes.push_back(onnx_node(field.content));
        contents.push_back(field.content);
      }
    check_names(nodes);
    for (const OnnxNode& node : nodes)
      for (const std::string& input : node.inputs) ++uses_[input];
    auto content = contents.begin();
    for (const OnnxNode& node : nodes) {
      if (!fold(node)) kept_.push_back(*content);
      ++content;
    }
  }

  [[nodiscard]] bool changes_something() const { return !computed_.empty() || !renamed_.empty(); }

  // The graph without what was folded.
  [[nodiscard]] std::string graph() const {
    std::set<std::string, std::less<>> used(outputs_);
    std::string graph;
    graph.reserve(size());  // large: not to be copied more often than it must
    for (const std::string_view node : kept_) {
      std::string content;
      for (const Field& field : onnx_fields(node)) {
        if (field.number != kNodeInput) {
          content += field.encoded;
          continue;
        }
        const std::string name = origin(std::string(field.content));
        used.insert(name);
        protobuf::append_bytes(content, kNodeInput, name);
      }
      protobuf::append_bytes(graph, kGraphNode, content);
    }
    for (const Field& field : fields_) {
      if (field.number == kGraphNode) continue;
      if (field.number == kGraphInitializer && !used.contains(onnx_tensor_name(field.content)))
        continue;
      graph += field.encoded;
    }
    for (const auto& [name, tensor] : computed_)
      if (used.contains(name))
        protobuf::append_bytes(graph, kGraphInitializer, encoded(tensor, name));
    return graph;
  }

 private:
  // OpenCV looks for names that nothing gives until it crashes.
  void check_names(const std::vector<OnnxNode>& nodes) const {
    std::vector<std::string> images;
    std::set<std::string, std::less<>> given(inputs_);
    for (const std::string& input : inputs_)
      if (!stored_.contains(input)) images.push_back(input);
    (void)only_image(images);
    for (const auto& [name, content] : stored_) given.insert(name);
    for (const OnnxNode& node : nodes) {
      for (const std::string& input : node.inputs)
        if (!input.empty() && !given.contains(input))
          fail(fmt::format("its node {} needs '{}', which nothing gives", node.type, input));
      given.insert(node.outputs.begin(), node.outputs.end());
    }
    for (const std::string& output : outputs_)
      if (!given.contains(output)) fail(fmt::format("nothing gives its output '{}'", output));
  }

  // Of the graph without what was folded [bytes], rather too much.
  [[nodiscard]] std::size_t size() const {
    constexpr std::size_t kOverhead = 256;  // of a tensor's head
    std::size_t bytes = 0;
    for (const Field& field : fields_) bytes += field.encoded.size();
    for (const auto& [name, tensor] : computed_) bytes += tensor.data.size() + kOverhead;
    return bytes;
  }

  [[nodiscard]] std::string origin(const std::string& name) const {
    const auto found = renamed_.find(name);
    return found == renamed_.end() ? name : found->second;
  }

  [[nodiscard]] bool is_constant(const std::string& name) const {
    return computed_.contains(name) || in_nodes_.contains(name) || stored_.contains(name);
  }

  [[nodiscard]] OnnxTensor constant(const std::string& name) const {
    for (const auto* known : {&computed_, &in_nodes_})
      if (const auto found = known->find(name); found != known->end()) return found->second;
    return onnx_tensor(stored_.at(name));
  }

  // True if the node needs not run.
  bool fold(OnnxNode node) {
    for (std::string& input : node.inputs) input = origin(input);
    if (node.type == "Constant") keep_constant(node);
    if (node.outputs.size() != 1 || outputs_.contains(node.outputs[0])) return false;
    const std::string& output = node.outputs[0];
    if (node.type == "Identity" && node.inputs.size() == 1) {
      renamed_[output] = node.inputs[0];
      return true;
    }
    if (node.inputs.size() < 2 ||
        !std::ranges::all_of(node.inputs,
                             [this](const std::string& name) { return is_constant(name); }))
      return false;
    try {
      if (node.type == "DequantizeLinear")
        computed_[output] =
            dequantized(constant(node.inputs[0]), constant(node.inputs[1]),
                        node.inputs.size() > 2 ? constant(node.inputs[2]) : OnnxTensor{},
                        quantization_of(node));
      else if (node.type == "Reshape" && computed_.contains(node.inputs[0]))
        computed_[output] = reshaped(take(node.inputs[0]), constant(node.inputs[1]));
      else
        return false;
    } catch (const Error& error) {
      throw Error(ErrorCode::kModel, fmt::format("weights '{}': {}", output, error.what()));
    }
    return true;
  }

  // Not copied where nothing else needs it: all weights together are large.
  OnnxTensor take(const std::string& name) {
    const auto found = computed_.find(name);
    if (uses_[name] > 1 || !renamed_.empty()) return found->second;
    OnnxTensor tensor = std::move(found->second);
    computed_.erase(found);
    return tensor;
  }

  // A constant may also be a node.
  void keep_constant(const OnnxNode& node) {
    if (node.outputs.size() != 1) return;
    if (auto value = tensor(node, "value")) in_nodes_[node.outputs[0]] = std::move(*value);
  }

  std::vector<Field> fields_;
  std::set<std::string, std::less<>> inputs_, outputs_;
  std::map<std::string, int> uses_;  // as an input, by name
  std::map<std::string, std::string_view> stored_;
  std::map<std::string, OnnxTensor> in_nodes_;  // of the type Constant
  std::map<std::string, OnnxTensor> computed_;
  std::map<std::string, std::string> renamed_;  // outputs of Identity, by their inputs
  std::vector<std::string_view> kept_;          // NodeProto
};

std::optional<std::string> folded(std::string_view onnx) {
  std::string model;
  for (const Field& field : onnx_fields(onnx)) {
    if (field.number != kModelGraph) {
      model += field.encoded;
      continue;
    }
    const Folding folding(field.content);
    if (!folding.changes_something()) return std::nullopt;
    constexpr std::size_t kHead = 16;  // [bytes], key and length
    const std::string graph = folding.graph();
    model.reserve(onnx.size() - field.encoded.size() + graph.size() + kHead);
    protobuf::append_bytes(model, kModelGraph, graph);
  }
  return model;
}

}  // namespace

std::optional<std::string> with_plain_weights(std::string_view onnx, const std::string& source) {
  try {
    return folded(onnx);
  } catch (const Error& error) {
    throw Error(ErrorCode::kModel, fmt::format("{}: {}", source, error.what()));
  }
}

}  // namespace edvo

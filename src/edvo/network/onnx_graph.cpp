// SPDX-License-Identifier: MIT
#include "edvo/network/onnx_graph.hpp"

#include "edvo/core/error.hpp"
#include "edvo/network/onnx_fields.hpp"
#include "edvo/network/protobuf.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace edvo {
namespace {

using protobuf::Field;
using protobuf::WireType;
using namespace onnx_field;

std::string_view graph_of(std::string_view onnx) {
  std::optional<std::string_view> graph;
  for (const Field& field : onnx_fields(onnx))
    if (field.number == kModelGraph && field.type == WireType::kBytes && !graph)
      graph = field.content;
  if (!graph) throw_not_onnx();
  return *graph;
}

std::string value_name(std::string_view value) {
  for (const Field& field : onnx_fields(value))
    if (field.number == kValueName) return std::string(field.content);
  throw_not_onnx();
}

// The fields of this number of a node's attribute.
std::vector<Field> attribute(const OnnxNode& node, std::string_view name, std::uint64_t number) {
  const auto found = node.attributes.find(name);
  if (found == node.attributes.end()) return {};
  std::vector<Field> fields = onnx_fields(found->second);
  std::erase_if(fields, [number](const Field& field) { return field.number != number; });
  return fields;
}

}  // namespace

OnnxNode onnx_node(std::string_view content) {
  OnnxNode node{.type = {}, .inputs = {}, .outputs = {}, .attributes = {}};
  for (const Field& field : onnx_fields(content)) {
    if (field.number == kNodeType) node.type = field.content;
    if (field.number == kNodeInput) node.inputs.emplace_back(field.content);
    if (field.number == kNodeOutput) node.outputs.emplace_back(field.content);
    if (field.number != kNodeAttribute) continue;
    for (const Field& part : onnx_fields(field.content))
      if (part.number == kAttributeName) node.attributes[std::string(part.content)] = field.content;
  }
  return node;
}

OnnxGraph onnx_graph(std::string_view onnx) {
  OnnxGraph graph;
  std::vector<std::string> inputs;
  for (const Field& field : onnx_fields(graph_of(onnx))) {
    if (field.number == kGraphInitializer)
      graph.constants[onnx_tensor_name(field.content)] = onnx_tensor(field.content);
    if (field.number == kGraphInput) inputs.push_back(value_name(field.content));
    if (field.number != kGraphNode) continue;
    OnnxNode node = onnx_node(field.content);
    auto value = node.type == "Constant" ? tensor(node, "value") : std::nullopt;
    if (value && node.outputs.size() == 1)
      graph.constants[node.outputs[0]] = std::move(*value);
    else
      graph.nodes.push_back(std::move(node));
  }
  std::erase_if(inputs, [&](const std::string& name) { return graph.constants.contains(name); });
  graph.image = only_image(inputs);
  return graph;
}

std::string only_image(const std::vector<std::string>& inputs) {
  if (inputs.size() != 1)
    throw Error(ErrorCode::kModel, fmt::format("it has {} inputs ({}); one, the image, is expected",
                                               inputs.size(), fmt::join(inputs, ", ")));
  return inputs.front();
}

std::vector<std::string> onnx_outputs(std::string_view onnx) {
  std::vector<std::string> names;
  for (const Field& field : onnx_fields(graph_of(onnx)))
    if (field.number == kGraphOutput) names.push_back(value_name(field.content));
  if (names.empty()) throw_not_onnx();
  return names;
}

std::optional<std::int64_t> integer(const OnnxNode& node, std::string_view name) {
  const std::vector<Field> found = attribute(node, name, kAttributeInteger);
  if (found.empty()) return std::nullopt;
  return static_cast<std::int64_t>(found.back().value);
}

std::vector<std::int64_t> integers(const OnnxNode& node, std::string_view name) {
  std::vector<std::int64_t> numbers;
  for (const Field& field : attribute(node, name, kAttributeIntegers)) {
    const auto values = field.type == WireType::kBytes ? protobuf::packed_varints(field.content)
                                                       : std::vector{field.value};
    if (!values) throw Error(ErrorCode::kModel, fmt::format("attribute '{}' is damaged", name));
    for (const std::uint64_t value : *values) numbers.push_back(static_cast<std::int64_t>(value));
  }
  return numbers;
}

std::string text(const OnnxNode& node, std::string_view name) {
  const std::vector<Field> found = attribute(node, name, kAttributeText);
  return found.empty() ? std::string() : std::string(found.back().content);
}

std::optional<OnnxTensor> tensor(const OnnxNode& node, std::string_view name) {
  const std::vector<Field> found = attribute(node, name, kAttributeTensor);
  if (found.empty()) return std::nullopt;
  return onnx_tensor(found.back().content);
}

}  // namespace edvo

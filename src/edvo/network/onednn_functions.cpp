// SPDX-License-Identifier: MIT
#include "edvo/network/onednn_functions.hpp"

#include "edvo/network/onednn_version.hpp"

namespace edvo {

using dnnl::algorithm;

dnnl::primitive_attr attributes_of(const FusedOperators& fused) {
  dnnl::post_ops operators;
  if (!fused.added.empty()) operators.append_sum();
  for (const ElementFunction& function : fused.functions)
    append_function(operators, function.kind, function.alpha, function.beta);
  dnnl::primitive_attr attributes;
  attributes.set_post_ops(operators);
  attributes.set_scratchpad_mode(dnnl::scratchpad_mode::user);  // the planner gives the memory
  return attributes;
}

std::optional<ElementFunction> function_of(const OnnxGraph& graph, const OnnxNode& node) {
  const std::string& type = node.type;
  if (type == "Relu") return ElementFunction{.kind = algorithm::eltwise_relu};
  if (type == "Sigmoid") return ElementFunction{.kind = algorithm::eltwise_logistic};
  if (node.inputs.size() != 2) return std::nullopt;
  const bool commutes = type == "Add" || type == "Mul";
  const bool is_first = commutes && !single_number(graph, node.inputs[1]);
  const auto number = single_number(graph, node.inputs[is_first ? 0 : 1]);
  if (!number) return std::nullopt;
  const auto linear = [](float alpha, float beta) {
    return ElementFunction{.kind = algorithm::eltwise_linear, .alpha = alpha, .beta = beta};
  };
  if (type == "Add") return linear(1, *number);
  if (type == "Sub") return linear(1, -*number);
  if (type == "Mul") return linear(*number, 0);
  if (type == "Div") return linear(1 / *number, 0);
  return std::nullopt;
}

std::optional<float> single_number(const OnnxGraph& graph, const std::string& name) {
  const auto found = graph.constants.find(name);
  if (found == graph.constants.end() || found->second.data.size() != sizeof(float))
    return std::nullopt;
  return floats_of(found->second).front();
}

}  // namespace edvo

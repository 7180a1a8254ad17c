// SPDX-License-Identifier: MIT
// Functions of one number that oneDNN can do together with the primitive before them.
#pragma once

#include "edvo/network/onnx_graph.hpp"

#include <dnnl.hpp>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

struct ElementFunction {
  dnnl::algorithm kind = dnnl::algorithm::undef;
  float alpha = 0, beta = 0;
};

// What a primitive does to each of its sums before it writes it.
struct FusedOperators {
  std::string output;  // of the last
  std::string added;   // first another value is added, empty = none
  std::vector<ElementFunction> functions;
};

[[nodiscard]] dnnl::primitive_attr attributes_of(const FusedOperators& fused);

// None where the node is no function of one number: Relu, Sigmoid, and arithmetic with a constant.
[[nodiscard]] std::optional<ElementFunction> function_of(const OnnxGraph& graph,
                                                         const OnnxNode& node);

// The constant of this name if it is one number.
[[nodiscard]] std::optional<float> single_number(const OnnxGraph& graph, const std::string& name);

}  // namespace edvo

// SPDX-License-Identifier: MIT
// The graph and the tensors of an ONNX file.
#include "edvo/core/error.hpp"
#include "edvo/network/onnx_graph.hpp"
#include "edvo/network/onnx_weights.hpp"
#include "fuzz/memory_file.hpp"

using namespace edvo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = fuzz::text_of(data, size);
  try {
    static_cast<void>(onnx_graph(bytes));
  } catch (const Error&) {
  }
  try {
    static_cast<void>(onnx_outputs(bytes));
  } catch (const Error&) {
  }
  try {
    static_cast<void>(with_plain_weights(bytes, "fuzz"));
  } catch (const Error&) {
  }
  return 0;
}

// SPDX-License-Identifier: MIT
// The outputs of an ONNX file, in its own order.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

// OpenCV lists outputs by the alphabet; a description counts them as the file does. Empty where the
// bytes are no ONNX model or end too early.
[[nodiscard]] std::optional<std::vector<std::string>> onnx_outputs(std::string_view bytes);

}  // namespace edvo

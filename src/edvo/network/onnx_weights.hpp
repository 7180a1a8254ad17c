// SPDX-License-Identifier: MIT
// An ONNX file with its weights as plain floats.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace edvo {

// Weights may be stored as integers with a scale per block and restored by the network itself
// (DequantizeLinear, Reshape: the OpenCV zoo's DexiNed), or shared through Identity nodes (torch's
// exporter). OpenCV 4.6 loads neither; here both are worked out once, before it sees the file.
// None where the file has nothing of that kind and may be used as it is. Throws Error(kModel)
// naming the source if it is damaged, as where a tensor has not the size that its shape says.
[[nodiscard]] std::optional<std::string> with_plain_weights(std::string_view onnx,
                                                            const std::string& source);

}  // namespace edvo

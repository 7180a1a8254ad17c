// SPDX-License-Identifier: MIT
// The constant tensors of an ONNX file, and weights stored as small integers made floats again.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

enum class OnnxType {
  kFloat = 1,
  kUint8 = 2,
  kInt8 = 3,
  kInt16 = 5,
  kInt32 = 6,
  kInt64 = 7,
  kBool = 9,
  kFloat16 = 10,
  kDouble = 11
};

struct OnnxTensor {
  std::vector<std::int64_t> dims;  // none = one number
  OnnxType type = OnnxType::kFloat;
  std::string data;  // little-endian, as raw_data
};

// How ONNX's DequantizeLinear spreads its scales over the numbers.
struct Quantization {
  std::int64_t axis = 1;        // negative = counted from the last
  std::int64_t block_size = 0;  // numbers along the axis that share a scale, 0 = not in blocks
};

// From a TensorProto. Throws Error(kModel) naming the tensor, not the file, if it is damaged, of
// another type, has less or more data than its shape says or keeps them in another file.
[[nodiscard]] OnnxTensor onnx_tensor(std::string_view message);

// Throws where onnx_tensor() would.
void check_onnx_tensor(std::string_view message);

[[nodiscard]] std::string onnx_tensor_name(std::string_view message);

// Its numbers. Throws Error(kModel) if they are not 32-bit floats.
[[nodiscard]] std::vector<float> floats_of(const OnnxTensor& tensor);

// As a TensorProto.
[[nodiscard]] std::string encoded(const OnnxTensor& tensor, std::string_view name);

// (number - zero) * scale; a zero point without data stands for 0. Throws Error(kModel) if shapes
// or types do not fit.
[[nodiscard]] OnnxTensor dequantized(const OnnxTensor& numbers, const OnnxTensor& scale,
                                     const OnnxTensor& zero, const Quantization& quantization);

// The same numbers in another shape, as ONNX's Reshape: 0 keeps a side, one -1 takes what is left.
[[nodiscard]] OnnxTensor reshaped(OnnxTensor tensor, const OnnxTensor& shape);

}  // namespace edvo

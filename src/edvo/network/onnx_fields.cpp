// SPDX-License-Identifier: MIT
#include "edvo/network/onnx_fields.hpp"

#include "edvo/core/error.hpp"

namespace edvo {

void throw_not_onnx() {
  throw Error(ErrorCode::kModel, "not an ONNX file, or a truncated one");
}

std::vector<protobuf::Field> onnx_fields(std::string_view message) {
  auto fields = protobuf::fields_of(message);
  if (!fields) throw_not_onnx();
  return std::move(*fields);
}

}  // namespace edvo

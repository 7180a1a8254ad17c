// SPDX-License-Identifier: MIT
// The messages of an ONNX file: field numbers of onnx.proto, as far as edvo reads it.
#pragma once

#include "edvo/network/protobuf.hpp"

#include <cstdint>
#include <string_view>
#include <vector>

namespace edvo {

// In their order. Throws Error(kModel) where the message is damaged or ends too early.
[[nodiscard]] std::vector<protobuf::Field> onnx_fields(std::string_view message);

[[noreturn]] void throw_not_onnx();

namespace onnx_field {

inline constexpr std::uint64_t kModelGraph = 7;
inline constexpr std::uint64_t kGraphNode = 1, kGraphInitializer = 5, kGraphInput = 11,
                               kGraphOutput = 12;
inline constexpr std::uint64_t kNodeInput = 1, kNodeOutput = 2, kNodeType = 4, kNodeAttribute = 5;
inline constexpr std::uint64_t kAttributeName = 1, kAttributeInteger = 3, kAttributeText = 4,
                               kAttributeTensor = 5, kAttributeIntegers = 8;
inline constexpr std::uint64_t kValueName = 1;

}  // namespace onnx_field
}  // namespace edvo

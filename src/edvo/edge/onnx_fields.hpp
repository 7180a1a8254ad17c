// SPDX-License-Identifier: MIT
// Field numbers of onnx.proto, as far as edvo reads it.
#pragma once

#include <cstdint>

namespace edvo::onnx_field {

inline constexpr std::uint64_t kModelGraph = 7;
inline constexpr std::uint64_t kGraphNode = 1, kGraphInitializer = 5, kGraphInput = 11,
                               kGraphOutput = 12;
inline constexpr std::uint64_t kNodeInput = 1, kNodeOutput = 2, kNodeType = 4, kNodeAttribute = 5;
inline constexpr std::uint64_t kAttributeName = 1, kAttributeInteger = 3, kAttributeText = 4,
                               kAttributeTensor = 5, kAttributeIntegers = 8;
inline constexpr std::uint64_t kValueName = 1;

}  // namespace edvo::onnx_field

// SPDX-License-Identifier: MIT
// Just enough of Protocol Buffers' wire format to read and rewrite an ONNX file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo::protobuf {

enum class WireType { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };

// One field of a message; refers to the message's bytes.
struct Field {
  std::uint64_t number = 0;
  WireType type = WireType::kVarint;
  std::uint64_t value = 0;   // of a varint
  std::string_view content;  // of all others
  std::string_view encoded;  // with its key, to be copied as it is
};

// In their order; none where the message is damaged or ends too early.
[[nodiscard]] std::optional<std::vector<Field>> fields_of(std::string_view message);

// The numbers one after the other; none where the last is cut off.
[[nodiscard]] std::optional<std::vector<std::uint64_t>> packed_varints(std::string_view bytes);

void append_varint(std::string& message, std::uint64_t number, std::uint64_t value);
void append_bytes(std::string& message, std::uint64_t number, std::string_view content);

}  // namespace edvo::protobuf

// SPDX-License-Identifier: MIT
#include "edvo/edge/onnx_outputs.hpp"

#include <cstdint>

namespace edvo {
namespace {

// Field numbers of onnx.proto.
constexpr std::uint64_t kModelGraph = 7;
constexpr std::uint64_t kGraphOutput = 12;
constexpr std::uint64_t kValueName = 1;

// Wire types of protocol buffers.
constexpr std::uint64_t kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5;

std::optional<std::uint64_t> take_varint(std::string_view& bytes) {
  constexpr std::size_t kLongest = 10;  // [bytes]
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < kLongest && i < bytes.size(); ++i) {
    const auto byte = static_cast<unsigned char>(bytes[i]);
    value |= static_cast<std::uint64_t>(byte & 0x7f) << (7 * i);
    if ((byte & 0x80) != 0) continue;
    bytes.remove_prefix(i + 1);
    return value;
  }
  return std::nullopt;
}

// The contents of every field of this number that holds bytes; empty where the message is damaged.
std::optional<std::vector<std::string_view>> fields(std::string_view message,
                                                    std::uint64_t wanted) {
  std::vector<std::string_view> found;
  while (!message.empty()) {
    const auto key = take_varint(message);
    if (!key) return std::nullopt;
    const std::uint64_t type = *key & 7;
    std::uint64_t length = 0;
    if (type == kVarint) {
      if (!take_varint(message)) return std::nullopt;
    } else if (type == kFixed64 || type == kFixed32) {
      length = type == kFixed64 ? 8 : 4;
    } else if (type == kBytes) {
      const auto stated = take_varint(message);
      if (!stated) return std::nullopt;
      length = *stated;
    } else {
      return std::nullopt;
    }
    if (length > message.size()) return std::nullopt;
    if (type == kBytes && *key >> 3 == wanted) found.push_back(message.substr(0, length));
    message.remove_prefix(length);
  }
  return found;
}

}  // namespace

std::optional<std::vector<std::string>> onnx_outputs(std::string_view bytes) {
  const auto graphs = fields(bytes, kModelGraph);
  if (!graphs || graphs->size() != 1) return std::nullopt;
  const auto values = fields(graphs->front(), kGraphOutput);
  if (!values || values->empty()) return std::nullopt;
  std::vector<std::string> names;
  for (const std::string_view value : *values) {
    const auto name = fields(value, kValueName);
    if (!name || name->size() != 1) return std::nullopt;
    names.emplace_back(name->front());
  }
  return names;
}

}  // namespace edvo

// SPDX-License-Identifier: MIT
#include "edvo/network/protobuf.hpp"

namespace edvo::protobuf {
namespace {

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

void append_raw_varint(std::string& bytes, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) bytes += static_cast<char>(value | 0x80);
  bytes += static_cast<char>(value);
}

// The length of what follows the key, or of a varint none.
std::optional<std::uint64_t> length_of(WireType type, std::string_view& message) {
  if (type == WireType::kFixed64) return 8;
  if (type == WireType::kFixed32) return 4;
  return take_varint(message);
}

}  // namespace

std::optional<std::vector<Field>> fields_of(std::string_view message) {
  std::vector<Field> found;
  while (!message.empty()) {
    const std::string_view start = message;
    const auto key = take_varint(message);
    if (!key) return std::nullopt;
    const std::uint64_t type = *key & 7;
    if (type > 5 || type == 3 || type == 4) return std::nullopt;
    Field field{.number = *key >> 3, .type = static_cast<WireType>(type)};
    const auto number = length_of(field.type, message);
    if (!number) return std::nullopt;
    if (field.type == WireType::kVarint) {
      field.value = *number;
    } else {
      if (*number > message.size()) return std::nullopt;
      field.content = message.substr(0, *number);
      message.remove_prefix(*number);
    }
    field.encoded = start.substr(0, start.size() - message.size());
    found.push_back(field);
  }
  return found;
}

std::optional<std::vector<std::uint64_t>> packed_varints(std::string_view bytes) {
  std::vector<std::uint64_t> values;
  while (!bytes.empty()) {
    const auto value = take_varint(bytes);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

void append_varint(std::string& message, std::uint64_t number, std::uint64_t value) {
  append_raw_varint(message, number << 3 | static_cast<std::uint64_t>(WireType::kVarint));
  append_raw_varint(message, value);
}

void append_bytes(std::string& message, std::uint64_t number, std::string_view content) {
  append_raw_varint(message, number << 3 | static_cast<std::uint64_t>(WireType::kBytes));
  append_raw_varint(message, content.size());
  message += content;
}

}  // namespace edvo::protobuf

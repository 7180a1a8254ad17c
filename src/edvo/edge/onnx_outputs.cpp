// SPDX-License-Identifier: MIT
#include "edvo/edge/onnx_outputs.hpp"

#include "edvo/edge/protobuf.hpp"

namespace edvo {
namespace {

using protobuf::Field;
using protobuf::WireType;

// Field numbers of onnx.proto.
constexpr std::uint64_t kModelGraph = 7;
constexpr std::uint64_t kGraphOutput = 12;
constexpr std::uint64_t kValueName = 1;

// The contents of every field of this number that holds bytes; empty where the message is damaged.
std::optional<std::vector<std::string_view>> contents(std::string_view message,
                                                      std::uint64_t wanted) {
  const auto fields = protobuf::fields_of(message);
  if (!fields) return std::nullopt;
  std::vector<std::string_view> found;
  for (const Field& field : *fields)
    if (field.type == WireType::kBytes && field.number == wanted) found.push_back(field.content);
  return found;
}

}  // namespace

std::optional<std::vector<std::string>> onnx_outputs(std::string_view bytes) {
  const auto graphs = contents(bytes, kModelGraph);
  if (!graphs || graphs->size() != 1) return std::nullopt;
  const auto values = contents(graphs->front(), kGraphOutput);
  if (!values || values->empty()) return std::nullopt;
  std::vector<std::string> names;
  for (const std::string_view value : *values) {
    const auto name = contents(value, kValueName);
    if (!name || name->size() != 1) return std::nullopt;
    names.emplace_back(name->front());
  }
  return names;
}

}  // namespace edvo

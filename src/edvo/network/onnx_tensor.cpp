// SPDX-License-Identifier: MIT
#include "edvo/network/onnx_tensor.hpp"

#include "edvo/core/error.hpp"
#include "edvo/network/protobuf.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <functional>
#include <numeric>
#include <optional>

namespace edvo {
namespace {

using protobuf::Field;
using protobuf::WireType;

static_assert(std::endian::native == std::endian::little, "raw_data is little-endian");

// Field numbers of TensorProto in onnx.proto.
constexpr std::uint64_t kDims = 1, kDataType = 2, kFloatData = 4, kInt32Data = 5, kInt64Data = 7,
                        kName = 8, kRawData = 9, kDoubleData = 10, kDataLocation = 14;

constexpr std::int64_t kMostNumbers = std::int64_t{1} << 29;

[[noreturn]] void fail(const std::string& reason) {
  throw Error(ErrorCode::kModel, reason);
}

std::size_t bytes_each(OnnxType type) {
  switch (type) {
    case OnnxType::kUint8:
    case OnnxType::kBool:
    case OnnxType::kInt8:
      return 1;
    case OnnxType::kFloat16:
    case OnnxType::kInt16:
      return 2;
    case OnnxType::kFloat:
    case OnnxType::kInt32:
      return 4;
    case OnnxType::kDouble:
    case OnnxType::kInt64:
      return 8;
  }
  return 0;
}

// How many numbers, or none if a side is negative or they are too many.
std::optional<std::int64_t> count_of(const std::vector<std::int64_t>& dims) {
  std::int64_t count = 1;
  for (const std::int64_t side : dims) {
    if (side < 0 || side > kMostNumbers) return std::nullopt;
    count *= side;
    if (count > kMostNumbers) return std::nullopt;
  }
  return count;
}

template <typename Number>
void append_number(std::string& data, std::uint64_t value) {
  const auto number = static_cast<Number>(value);
  data.append(reinterpret_cast<const char*>(&number), sizeof number);
}

// Small types travel as varints where they are not raw.
std::string from_varints(const Field& field, OnnxType type) {
  const auto values = field.type == WireType::kBytes ? protobuf::packed_varints(field.content)
                                                     : std::vector<std::uint64_t>{field.value};
  if (!values) fail("its data is damaged");
  std::string data;
  for (const std::uint64_t value : *values) {
    if (bytes_each(type) == 1) append_number<std::uint8_t>(data, value);
    if (bytes_each(type) == 2) append_number<std::uint16_t>(data, value);
    if (bytes_each(type) == 4) append_number<std::uint32_t>(data, value);
    if (bytes_each(type) == 8) append_number<std::uint64_t>(data, value);
  }
  return data;
}

bool is_known(std::uint64_t type) {
  return type >= 1 && type <= 11 && bytes_each(static_cast<OnnxType>(type)) > 0;
}

// A tensor whose data are not put together yet.
struct Parts {
  OnnxTensor tensor;                     // without data
  std::vector<std::string_view> pieces;  // as they are
  std::string numbers;                   // from varints
};

Parts parts_of(const std::vector<Field>& fields) {
  Parts parts;
  OnnxTensor& tensor = parts.tensor;
  for (const Field& field : fields)
    if (field.number == kDataType) {
      if (!is_known(field.value)) fail(fmt::format("its data type {} is not known", field.value));
      tensor.type = static_cast<OnnxType>(field.value);
    }
  std::size_t bytes = 0;
  for (const Field& field : fields) {
    if (field.number == kDims) {
      const auto sides = field.type == WireType::kBytes ? protobuf::packed_varints(field.content)
                                                        : std::vector<std::uint64_t>{field.value};
      if (!sides) fail("its shape is damaged");
      for (const std::uint64_t side : *sides)
        tensor.dims.push_back(static_cast<std::int64_t>(side));
    }
    if (field.number == kDataLocation && field.value != 0)
      fail("its data are in another file; save the network as one file");
    if (field.number == kRawData || field.number == kFloatData || field.number == kDoubleData) {
      parts.pieces.push_back(field.content);
      bytes += field.content.size();
    }
    if (field.number == kInt32Data || field.number == kInt64Data)
      parts.numbers += from_varints(field, tensor.type);
  }
  bytes += parts.numbers.size();
  const auto count = count_of(tensor.dims);
  if (!count || static_cast<std::size_t>(*count) * bytes_each(tensor.type) != bytes)
    fail(fmt::format("it has the shape ({}), but {} bytes of data", fmt::join(tensor.dims, ", "),
                     bytes));
  return parts;
}

Parts named_parts_of(std::string_view message) {
  const std::string name = onnx_tensor_name(message);
  try {
    return parts_of(*protobuf::fields_of(message));
  } catch (const Error& error) {
    fail(fmt::format("tensor '{}': {}", name, error.what()));
  }
}

template <typename Number>
Number number_at(const std::string& data, std::size_t i) {
  Number number;
  std::memcpy(&number, data.data() + i * sizeof number, sizeof number);
  return number;
}

// Where the scale of a number lies: numbers are counted by outer sides, axis, inner sides.
struct ScaleIndex {
  std::int64_t axis_side = 1, inner = 1;
  std::int64_t block = 1;  // numbers along the axis with one scale
  // Scales that one step outside the axis, one block along it and one step inside skip.
  std::int64_t outer_step = 0, axis_step = 0, inner_step = 0;
};

ScaleIndex index_of_scales(const OnnxTensor& numbers, const OnnxTensor& scale,
                           const Quantization& quantization) {
  ScaleIndex index;
  const std::int64_t scales = *count_of(scale.dims);
  if (scales == 1 && quantization.block_size == 0) return index;
  const auto rank = static_cast<std::int64_t>(numbers.dims.size());
  const std::int64_t axis = quantization.axis + (quantization.axis < 0 ? rank : 0);
  if (axis < 0 || axis >= rank) fail(fmt::format("axis {} is out of range", quantization.axis));
  const auto begin = numbers.dims.begin();
  index.axis_side = begin[axis];
  index.inner =
      std::accumulate(begin + axis + 1, numbers.dims.end(), std::int64_t{1}, std::multiplies<>());
  index.axis_step = 1;
  if (quantization.block_size == 0) {
    if (scale.dims == std::vector{index.axis_side}) return index;
  } else {
    if (quantization.block_size < 0 || quantization.block_size > kMostNumbers)
      fail(fmt::format("blocks of {} make no sense", quantization.block_size));
    index.block = quantization.block_size;
    const std::int64_t blocks = (index.axis_side + index.block - 1) / index.block;
    std::vector<std::int64_t> expected = numbers.dims;
    expected[static_cast<std::size_t>(axis)] = blocks;
    index.axis_step = index.inner;
    index.inner_step = 1;
    index.outer_step = blocks * index.inner;
    if (scale.dims == expected) return index;
  }
  fail(fmt::format(
      "scales of the shape ({}) do not fit weights of the shape ({}) with blocks of {}",
      fmt::join(scale.dims, ", "), fmt::join(numbers.dims, ", "), quantization.block_size));
}

template <typename Number>
std::string dequantized_data(const OnnxTensor& numbers, const OnnxTensor& scale,
                             const OnnxTensor& zero, const ScaleIndex& index) {
  const auto count = static_cast<std::size_t>(*count_of(numbers.dims));
  std::string data(count * sizeof(float), '\0');
  std::size_t i = 0;
  for (std::int64_t out = 0; i < count; ++out)
    for (std::int64_t along = 0; along < index.axis_side; ++along) {
      std::int64_t place = out * index.outer_step + along / index.block * index.axis_step;
      for (std::int64_t in = 0; in < index.inner; ++in, ++i, place += index.inner_step) {
        const auto at = static_cast<std::size_t>(place);
        const float offset =
            zero.data.empty() ? 0.F : static_cast<float>(number_at<Number>(zero.data, at));
        const float value = (static_cast<float>(number_at<Number>(numbers.data, i)) - offset) *
                            number_at<float>(scale.data, at);
        std::memcpy(data.data() + i * sizeof value, &value, sizeof value);
      }
    }
  return data;
}

}  // namespace

std::string onnx_tensor_name(std::string_view message) {
  const auto fields = protobuf::fields_of(message);
  if (!fields) fail("a tensor is damaged");
  for (const Field& field : *fields)
    if (field.number == kName) return std::string(field.content);
  return {};
}

void check_onnx_tensor(std::string_view message) {
  (void)named_parts_of(message);
}

OnnxTensor onnx_tensor(std::string_view message) {
  Parts parts = named_parts_of(message);
  for (const std::string_view piece : parts.pieces) parts.tensor.data += piece;
  parts.tensor.data += parts.numbers;
  return std::move(parts.tensor);
}

std::vector<float> floats_of(const OnnxTensor& tensor) {
  if (tensor.type != OnnxType::kFloat) fail("a constant is not of 32-bit floats");
  std::vector<float> numbers(tensor.data.size() / sizeof(float));
  if (!numbers.empty())  // memcpy knows no null, not even for nothing
    std::memcpy(numbers.data(), tensor.data.data(), numbers.size() * sizeof(float));
  return numbers;
}

std::string encoded(const OnnxTensor& tensor, std::string_view name) {
  std::string message;
  for (const std::int64_t side : tensor.dims)
    protobuf::append_varint(message, kDims, static_cast<std::uint64_t>(side));
  protobuf::append_varint(message, kDataType, static_cast<std::uint64_t>(tensor.type));
  protobuf::append_bytes(message, kName, name);
  protobuf::append_bytes(message, kRawData, tensor.data);
  return message;
}

OnnxTensor dequantized(const OnnxTensor& numbers, const OnnxTensor& scale, const OnnxTensor& zero,
                       const Quantization& quantization) {
  if (scale.type != OnnxType::kFloat) fail("its scales are not of 32-bit floats");
  if (!zero.data.empty() && (zero.type != numbers.type || zero.dims != scale.dims))
    fail("its zero points are of another type or shape than they should be");
  const ScaleIndex index = index_of_scales(numbers, scale, quantization);
  OnnxTensor floats{.dims = numbers.dims, .type = OnnxType::kFloat, .data = {}};
  switch (numbers.type) {
    case OnnxType::kInt8:
      floats.data = dequantized_data<std::int8_t>(numbers, scale, zero, index);
      break;
    case OnnxType::kUint8:
      floats.data = dequantized_data<std::uint8_t>(numbers, scale, zero, index);
      break;
    case OnnxType::kInt16:
      floats.data = dequantized_data<std::int16_t>(numbers, scale, zero, index);
      break;
    case OnnxType::kInt32:
      floats.data = dequantized_data<std::int32_t>(numbers, scale, zero, index);
      break;
    default:
      fail("only weights of 8, 16 or 32-bit integers can be made floats");
  }
  return floats;
}

OnnxTensor reshaped(OnnxTensor tensor, const OnnxTensor& shape) {
  if (shape.type != OnnxType::kInt64 || shape.dims.size() != 1) fail("its new shape is no shape");
  std::vector<std::int64_t> dims;
  std::int64_t known = 1, unknown = -1;
  for (std::size_t i = 0; i < shape.data.size() / sizeof(std::int64_t); ++i) {
    auto side = number_at<std::int64_t>(shape.data, i);
    if (side == 0 && i < tensor.dims.size()) side = tensor.dims[i];
    dims.push_back(side);
    if (side == -1 && unknown < 0) {
      unknown = static_cast<std::int64_t>(i);
      continue;
    }
    if (side < 1 || side > kMostNumbers || known > kMostNumbers / side)
      fail("its new shape is no shape");
    known *= side;
  }
  const std::int64_t count = *count_of(tensor.dims);
  if (unknown >= 0) dims[static_cast<std::size_t>(unknown)] = count / known;
  if (count_of(dims) != count)
    fail(fmt::format("({}) cannot be reshaped to ({})", fmt::join(tensor.dims, ", "),
                     fmt::join(dims, ", ")));
  tensor.dims = dims;
  return tensor;
}

}  // namespace edvo

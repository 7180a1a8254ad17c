// SPDX-License-Identifier: MIT
// The description of an edge network: the small TOML file beside its weights.
#pragma once

#include "edvo/core/fields.hpp"

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>

namespace edvo {

enum class ChannelOrder { kBgr, kRgb };

template <>
struct EnumNames<ChannelOrder> {
  static constexpr auto names = std::to_array<std::pair<ChannelOrder, std::string_view>>(
      {{ChannelOrder::kBgr, "bgr"}, {ChannelOrder::kRgb, "rgb"}});
};

// How an image is padded at its right and lower side.
enum class Padding { kReflect, kReplicate };

template <>
struct EnumNames<Padding> {
  static constexpr auto names = std::to_array<std::pair<Padding, std::string_view>>(
      {{Padding::kReflect, "reflect"}, {Padding::kReplicate, "replicate"}});
};

// From the network's output to the probability of an edge.
enum class Activation { kNone, kSigmoid };

template <>
struct EnumNames<Activation> {
  static constexpr auto names = std::to_array<std::pair<Activation, std::string_view>>(
      {{Activation::kNone, "none"}, {Activation::kSigmoid, "sigmoid"}});
};

// The image is resized to size, or by factor where there is no size; then padded until its sides
// are multiples of multiple_of. The output is cropped and resized back.
struct NetworkInput {
  ChannelOrder channels = ChannelOrder::kBgr;
  std::array<double, 3> mean = {0, 0, 0};  // in that order, taken off the image of [0..255]
  double scale = 1;                        // multiplied afterwards
  int multiple_of = 1;                     // [px]
  Padding padding = Padding::kReflect;
  cv::Size size;      // [px], empty = that of the image
  double factor = 1;  // of the image's size
};

struct NetworkOutput {
  std::string name;  // empty = chosen by index
  int index = -1;    // as the file lists its outputs, from 0; -1 = the last
  Activation activation = Activation::kNone;
};

struct ModelDescription {
  std::string name;
  std::string file;    // the ONNX file, relative to the description
  std::string sha256;  // of that file in hexadecimal, empty = not checked
  std::string licence;
  std::string source;  // who made the weights, and from what
  NetworkInput input;
  NetworkOutput output;
};

// Unknown keys, wrong types and values that make no sense throw Error(kModel) naming source, line,
// key and value.
[[nodiscard]] ModelDescription model_description_from_toml(std::string_view text,
                                                           const std::string& source);

// Every key; reads back as the same description.
[[nodiscard]] std::string to_toml(const ModelDescription& model);

}  // namespace edvo

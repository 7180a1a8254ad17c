// SPDX-License-Identifier: MIT
#include "edvo/network/convolution_window.hpp"

#include "edvo/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace edvo {
namespace {

[[noreturn]] void fail(const std::string& reason) {
  throw Error(ErrorCode::kModel, reason);
}

Sides sides_of(const OnnxNode& node, std::string_view name, Sides otherwise) {
  const std::vector<std::int64_t> values = integers(node, name);
  if (values.empty()) return otherwise;
  if (values.size() != 2) fail(fmt::format("{} of other than two dimensions", node.type));
  return {values[0], values[1]};
}

std::int64_t output_side(std::int64_t input, std::int64_t kernel, std::int64_t stride,
                         std::int64_t dilation, std::int64_t added) {
  const std::int64_t room = input + added - dilation * (kernel - 1) - 1;
  if (room < 0 || stride < 1) fail("an image smaller than a kernel");
  return room / stride + 1;
}

}  // namespace

Sides KernelWindow::output_size(Sides input) const {
  return {output_side(input.y, kernel.y, stride.y, dilation.y, before.y + after.y),
          output_side(input.x, kernel.x, stride.x, dilation.x, before.x + after.x)};
}

KernelWindow window_of(const OnnxNode& node) {
  const std::string automatic = text(node, "auto_pad");
  if (!automatic.empty() && automatic != "NOTSET")
    fail(fmt::format("{} with auto_pad {}", node.type, automatic));
  if (integer(node, "ceil_mode").value_or(0) != 0)
    fail(fmt::format("{} with ceil_mode", node.type));
  const std::vector<std::int64_t> pads = integers(node, "pads");
  KernelWindow window{.kernel = sides_of(node, "kernel_shape", {1, 1}),
                      .stride = sides_of(node, "strides", {1, 1}),
                      .dilation = sides_of(node, "dilations", {1, 1}),
                      .before = {},
                      .after = {}};
  if (pads.size() == 4) {
    window.before = {pads[0], pads[1]};
    window.after = {pads[2], pads[3]};
  }
  return window;
}

KernelWindow window_of(const OnnxNode& node, const OnnxTensor& weights) {
  if (weights.dims.size() != 4) fail(fmt::format("{} of other than two dimensions", node.type));
  const Sides kernel = {weights.dims[2], weights.dims[3]};
  KernelWindow window = window_of(node);
  if (sides_of(node, "kernel_shape", kernel) != kernel)
    fail(fmt::format("{} whose weights do not fit its kernel_shape", node.type));
  window.kernel = kernel;
  return window;
}

bool suits_winograd(const std::vector<std::int64_t>& weights, const KernelWindow& window) {
  constexpr std::int64_t kChannels = 64;
  return weights.size() == 4 && weights[0] >= kChannels && weights[1] >= kChannels &&
         window.kernel == Sides{3, 3} && window.stride == Sides{1, 1} &&
         window.dilation == Sides{1, 1} && window.before == window.after &&
         window.before.y == window.before.x;
}

Enlargement enlargement_of(const OnnxNode& node, const KernelWindow& transposed) {
  const auto extra = integers(node, "output_padding");
  const std::int64_t s = transposed.stride.y, k = transposed.kernel.y, p = transposed.before.y;
  if (transposed.stride.x != s || transposed.kernel.x != k || transposed.before.x != p ||
      transposed.after != Sides{p, p} || transposed.dilation != Sides{1, 1} ||
      std::ranges::any_of(extra, [](std::int64_t n) { return n != 0; }) ||
      integer(node, "group").value_or(1) != 1 || s < 1 || k - 2 * p != s || p < 0)
    fail("ConvTranspose that does not enlarge by its stride");
  const std::int64_t K = (k + s - 1) / s;
  const std::int64_t before = K - 1 - p / s, after = (p + s - 1) / s;
  return {.factor = s,
          .margin = p % s,
          .window = {.kernel = {K, K}, .before = {before, before}, .after = {after, after}}};
}

std::vector<float> spread_weights(const OnnxTensor& weights, const Enlargement& by) {
  const std::vector<float> numbers = floats_of(weights);
  const std::int64_t inputs = weights.dims[0], outputs = weights.dims[1], k = weights.dims[2];
  const std::int64_t s = by.factor, K = by.window.kernel.y;
  std::vector<float> spread(static_cast<std::size_t>(s * s * outputs * inputs * K * K), 0.F);
  auto to = spread.begin();
  for (std::int64_t ry = 0; ry < s; ++ry)
    for (std::int64_t rx = 0; rx < s; ++rx)
      for (std::int64_t output = 0; output < outputs; ++output)
        for (std::int64_t input = 0; input < inputs; ++input)
          for (std::int64_t y = s * (K - 1) + ry; y >= 0; y -= s)
            for (std::int64_t x = s * (K - 1) + rx; x >= 0; x -= s, ++to)
              if (y < k && x < k)
                *to =
                    numbers[static_cast<std::size_t>(((input * outputs + output) * k + y) * k + x)];
  return spread;
}

}  // namespace edvo

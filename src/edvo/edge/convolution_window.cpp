// SPDX-License-Identifier: MIT
#include "edvo/edge/convolution_window.hpp"

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

KernelWindow Enlargement::window() const {
  const std::int64_t side = last - first + 1;
  return {.kernel = {side, side}, .before = {-first, -first}, .after = {last, last}};
}

Enlargement enlargement_of(const OnnxNode& node, const KernelWindow& transposed) {
  const auto extra = integers(node, "output_padding");
  const std::int64_t s = transposed.stride.y, k = transposed.kernel.y, p = transposed.before.y;
  if (transposed.stride.x != s || transposed.kernel.x != k || transposed.before.x != p ||
      transposed.after != Sides{p, p} || transposed.dilation != Sides{1, 1} ||
      std::ranges::any_of(extra, [](std::int64_t n) { return n != 0; }) ||
      integer(node, "group").value_or(1) != 1 || s < 1 || k - 2 * p != s || p < 0)
    fail("ConvTranspose that does not enlarge by its stride");
  Enlargement enlargement{.factor = s, .first = 0, .last = (s - 1 + p) / s};
  while (p - s * (enlargement.first - 1) <= k - 1) --enlargement.first;
  return enlargement;
}

std::vector<float> spread_weights(const OnnxTensor& weights, const KernelWindow& transposed,
                                  const Enlargement& by) {
  const std::vector<float> numbers = floats_of(weights);
  const std::int64_t inputs = weights.dims[0], outputs = weights.dims[1], k = weights.dims[2];
  const std::int64_t s = by.factor, K = by.window().kernel.y, before = transposed.before.y;
  std::vector<float> spread(static_cast<std::size_t>(s * s * outputs * inputs * K * K), 0.F);
  const auto tap = [&](std::int64_t r, std::int64_t d) { return r + before - s * d; };
  const auto inside = [k](std::int64_t t) { return t >= 0 && t < k; };
  auto to = spread.begin();
  for (std::int64_t ry = 0; ry < s; ++ry)
    for (std::int64_t rx = 0; rx < s; ++rx)
      for (std::int64_t output = 0; output < outputs; ++output)
        for (std::int64_t input = 0; input < inputs; ++input)
          for (std::int64_t dy = by.first; dy <= by.last; ++dy)
            for (std::int64_t dx = by.first; dx <= by.last; ++dx, ++to)
              if (inside(tap(ry, dy)) && inside(tap(rx, dx)))
                *to = numbers[static_cast<std::size_t>(
                    ((input * outputs + output) * k + tap(ry, dy)) * k + tap(rx, dx))];
  return spread;
}

}  // namespace edvo

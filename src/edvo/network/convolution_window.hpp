// SPDX-License-Identifier: MIT
// Where a convolution's kernel lies on an image, as an ONNX node says it, and transposed
// convolutions as plain ones.
#pragma once

#include "edvo/network/onnx_graph.hpp"

#include <cstdint>
#include <vector>

namespace edvo {

// Along the two sides of an image: of a kernel, its steps, or what is added to an image's borders.
struct Sides {
  std::int64_t y = 0, x = 0;
  [[nodiscard]] bool operator==(const Sides&) const = default;
};

struct KernelWindow {
  Sides kernel, stride = {1, 1}, dilation = {1, 1};
  Sides before, after;  // what is added to the image [px]

  // Throws Error(kModel) if the image is smaller than the kernel.
  [[nodiscard]] Sides output_size(Sides input) const;
};

// All below throw Error(kModel), naming the operator, for what is not supported.

// Of a pooling.
[[nodiscard]] KernelWindow window_of(const OnnxNode& node);

// Of a convolution with these weights, ... x ... x kernel.
[[nodiscard]] KernelWindow window_of(const OnnxNode& node, const OnnxTensor& weights);

// Whether Winograd's way is faster for a convolution with weights of these sides. It takes a
// quarter of the products, but more memory: from 64 channels on it is two to three times as fast.
[[nodiscard]] bool suits_winograd(const std::vector<std::int64_t>& weights,
                                  const KernelWindow& window);

// A transposed convolution that enlarges s times is a convolution with s * s times the channels,
// each for one place among s x s pixels, which are then spread. To take no more of the kernel than
// a pixel needs, its places are those of the result moved by the convolution's padding p:
// out[s q + r - p] takes the kernel at s d + r of in[q - d].
struct Enlargement {
  std::int64_t factor = 1;  // s
  std::int64_t margin = 0;  // rows and columns, once spread, that lie before the result's
  KernelWindow window;      // of the convolution
};

[[nodiscard]] Enlargement enlargement_of(const OnnxNode& node, const KernelWindow& transposed);

// The convolution's weights: input x output x k x k -> (s s output) x input x K x K.
[[nodiscard]] std::vector<float> spread_weights(const OnnxTensor& weights, const Enlargement& by);

}  // namespace edvo

#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes tests/data/tiny_edges.onnx: an edge "network" of fixed weights, small enough for tests.

Needs Debian's python3-onnx, only to make the file again: /usr/bin/python3 make_tiny_onnx.py OUT
It is the gradient of a Gaussian, written as layers:
    gray = luma . bgr;  (gx, gy) = dG * gray;  logit = kSlope (|g| - kThreshold)
Outputs: "edges", H x W, before a sigmoid; "coarse", the same at half the size (for tests of shape).
"""
import numpy as np
from onnx import helper, numpy_helper

import onnx_writer

LUMA_OF_BGR = (0.114, 0.587, 0.299)
SIGMA = 1.0  # [px]
RADIUS = 3  # [px]
THRESHOLD = 0.03  # |g| where the probability is one half [full scale / px]
SLOPE = 100.0


def gaussian_derivatives():
    offset = np.arange(-RADIUS, RADIUS + 1, dtype=np.float64)
    bell = np.exp(-offset**2 / (2 * SIGMA**2))
    bell /= bell.sum()
    slope = offset * bell
    slope /= (offset * slope).sum()  # a ramp of 1 per pixel gives 1
    return np.stack([np.outer(bell, slope), np.outer(slope, bell)])[:, None]


def constant(name, values, kind=np.float32):
    return numpy_helper.from_array(np.asarray(values, dtype=kind), name)


def convolution(inputs, output, size=1):
    return helper.make_node("Conv", inputs, [output], kernel_shape=[size, size])


def main(path):
    p = RADIUS
    weights = [
        constant("luma", np.reshape(LUMA_OF_BGR, (1, 3, 1, 1))),
        constant("border", [0, 0, p, p, 0, 0, p, p], np.int64),
        constant("derivatives", gaussian_derivatives()),
        constant("sum", np.ones((1, 2, 1, 1))),
        constant("tiny", [1e-12]),
        constant("slope", np.full((1, 1, 1, 1), SLOPE)),
        constant("offset", [-SLOPE * THRESHOLD]),
    ]
    nodes = [
        convolution(["bgr", "luma"], "gray"),
        helper.make_node("Pad", ["gray", "border"], ["padded"], mode="reflect"),
        convolution(["padded", "derivatives"], "gradient", 2 * p + 1),
        helper.make_node("Mul", ["gradient", "gradient"], ["squares"]),
        convolution(["squares", "sum"], "square"),
        helper.make_node("Add", ["square", "tiny"], ["positive"]),
        helper.make_node("Sqrt", ["positive"], ["magnitude"]),
        convolution(["magnitude", "slope", "offset"], "edges"),
        helper.make_node("AveragePool", ["edges"], ["coarse"], kernel_shape=[2, 2], strides=[2, 2]),
    ]
    outputs = [onnx_writer.value("edges", 1, "height", "width"),
               onnx_writer.value("coarse", 1, "half_h", "half_w")]
    onnx_writer.save(path, "tiny_edges", nodes, [onnx_writer.value("bgr", 3, "height", "width")],
                     outputs, weights)


if __name__ == "__main__":
    main(onnx_writer.path_argument(__doc__))

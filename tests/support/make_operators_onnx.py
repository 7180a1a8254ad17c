#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes tests/data/operators.onnx: random weights in every operator that edvo runs with oneDNN.

Needs Debian's python3-onnx, only to make the file again: /usr/bin/python3 make_operators_onnx.py OUT
Kernels that are not square or stand off the middle, groups, dilations, values that several nodes use,
an output that nobody asks for. Outputs: "edges" (probabilities, H x W), "aside".
"""
import numpy as np
from onnx import helper, numpy_helper

import onnx_writer


class Graph:
    def __init__(self):
        self.random = np.random.default_rng(1)
        self.nodes, self.weights = [], []

    def constant(self, values, kind=np.float32):
        name = f"constant{len(self.weights)}"
        self.weights.append(numpy_helper.from_array(np.asarray(values, dtype=kind), name))
        return name

    def node(self, kind, *inputs, output=None, **attributes):
        output = output or f"{kind}{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, list(inputs), [output], **attributes))
        return output

    def convolution(self, value, shape, kind="Conv", bias=True, **attributes):
        fan_in = np.prod(shape[1:]) if kind == "Conv" else shape[0] * shape[2] * shape[3] / 4
        inputs = [value, self.constant(self.random.normal(0, 1.4 / np.sqrt(fan_in), shape))]
        if bias:
            channels = shape[0] if kind == "Conv" else shape[1]
            inputs.append(self.constant(self.random.normal(0, 0.1, channels)))
        return self.node(kind, *inputs, kernel_shape=shape[2:], **attributes)


def network():
    g = Graph()
    mean = g.constant(np.reshape([100, 110, 120], (1, 3, 1, 1)))
    x = g.node("Div", g.node("Sub", "bgr", mean), g.constant([60]))
    half = g.node("Relu", g.convolution(x, (8, 3, 4, 4), strides=[2, 2], pads=[1, 1, 1, 1]))
    # A function of one value in several steps, as Smish.
    u = g.node("Add", g.constant(1), g.node("Sigmoid", half))
    square = g.node("Mul", u, u)
    half = g.node("Mul", half, g.node("Div", g.node("Sub", square, g.constant(0.5)),
                                      g.node("Add", square, g.constant(1))))
    # Residuals: added before and after what they are added to is used elsewhere, and halved.
    wide = g.convolution(half, (8, 1, 3, 3), group=8, dilations=[2, 2], pads=[2, 2, 2, 2])
    half = g.node("Relu", g.node("Add", half, g.convolution(wide, (8, 8, 1, 1), bias=False)))
    skewed = g.convolution(half, (8, 4, 1, 3), group=2, pads=[0, 2, 0, 0])
    half = g.node("Mul", g.node("Add", skewed, half), g.constant([0.5]))
    quarter = g.node("MaxPool", half, kernel_shape=[3, 3], strides=[2, 2], pads=[1, 1, 1, 1])
    quarter = g.convolution(quarter, (6, 8, 3, 3), strides=[1, 1], pads=[1, 1, 1, 1])
    larger = g.node("Resize", quarter, g.constant([]), g.constant([1, 1, 2, 2]), mode="linear",
                    coordinate_transformation_mode="half_pixel")
    merged = g.node("Concat", half, g.node("Relu", larger), axis=1)
    maps = [
        g.convolution(merged, (14, 1, 4, 4), "ConvTranspose", strides=[2, 2], pads=[1, 1, 1, 1]),
        g.convolution(half, (8, 2, 2, 2), "ConvTranspose", strides=[2, 2]),
        g.node("Relu", g.convolution(half, (8, 1, 8, 8), "ConvTranspose", bias=False,
                                     strides=[2, 2], pads=[3, 3, 3, 3])),
        g.convolution(quarter, (6, 1, 4, 4), "ConvTranspose", strides=[4, 4]),
    ]
    fused = g.convolution(g.node("Concat", *maps, axis=1), (1, 5, 1, 1))
    g.node("Sigmoid", fused, output="edges")
    g.node("Softplus", quarter, output="aside")
    return g


def main(path):
    g = network()
    onnx_writer.save(path, "operators", g.nodes, [onnx_writer.value("bgr", 3, "height", "width")],
                     [onnx_writer.value("edges", 1, "height", "width"),
                      onnx_writer.value("aside", 6, "h", "w")], g.weights)


if __name__ == "__main__":
    main(onnx_writer.path_argument(__doc__))

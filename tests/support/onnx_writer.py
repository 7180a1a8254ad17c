# SPDX-License-Identifier: MIT
"""What the makers of test networks share. Needs Debian's python3-onnx."""
import sys

import onnx
from onnx import TensorProto, helper


def value(name, channels, *sides):
    """1 x channels x sides, of floats; sides that are names may have any length."""
    return helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, channels, *sides])


def save(path, name, nodes, inputs, outputs, weights):
    graph = helper.make_graph(nodes, name, inputs, outputs, weights)
    model = helper.make_model(graph, producer_name="edvo",
                              opset_imports=[helper.make_opsetid("", 11)])
    model.ir_version = 7
    onnx.checker.check_model(model)
    onnx.save(model, path)


def path_argument(usage):
    if len(sys.argv) != 2:
        sys.exit(usage)
    return sys.argv[1]

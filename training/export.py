# SPDX-License-Identifier: MIT
"""Writes a checkpoint's mean weights as ONNX, with the description that edvo reads (docs/models.md).

python3 training/export.py runs/first/checkpoint.pth models/edvo_edges.onnx
"""
import argparse
import hashlib
from pathlib import Path

import cv2
import numpy as np
import onnx
import torch

import model

LARGEST_DIFFERENCE = 1e-4  # between torch and OpenCV, of the logits
SIZES = ((480, 640), (360, 640), (328, 488))  # [pixels]; the first is what the file is traced with


def without_identities(proto):
    """OpenCV 4.6 rejects the Identity nodes by which the exporter shares equal weights."""
    graph = proto.graph
    source = {}
    for node in [n for n in graph.node if n.op_type == "Identity"]:
        source[node.output[0]] = source.get(node.input[0], node.input[0])
        graph.node.remove(node)
    for node in graph.node:
        for i, name in enumerate(node.input):
            node.input[i] = source.get(name, name)
    return proto


def write_onnx(net, path):
    """net: as model.merged gives it."""
    torch.onnx.export(net, torch.zeros(1, 3, *SIZES[0]), str(path), opset_version=11,
                      input_names=["image"], output_names=["edges"],
                      dynamic_axes={"image": {2: "height", 3: "width"},
                                    "edges": {2: "height", 3: "width"}})
    proto = without_identities(onnx.load(str(path)))
    onnx.checker.check_model(proto)
    onnx.save(proto, str(path))


def largest_difference(net, path):
    """Between torch and OpenCV, on noise of several sizes."""
    reader = cv2.dnn.readNetFromONNX(str(path))
    generator = np.random.default_rng(1)
    worst = 0.0
    for height, width in SIZES:
        x = generator.standard_normal((1, 3, height, width)).astype(np.float32)
        reader.setInput(x)
        with torch.no_grad():
            worst = max(worst, float(np.abs(reader.forward() - net(torch.from_numpy(x)).numpy()).max()))
    return worst


def description(path, source, licence):
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    mean = ", ".join([str(model.MEAN)] * 3)
    return f"""name = "{path.stem}"
file = "{path.name}"
sha256 = "{digest}"
licence = "{licence}"
source = "{source}"

[input]
channels = "bgr"
mean = [{mean}]
scale = {model.SCALE}
multiple_of = {model.STRIDE}
padding = "reflect"

[output]
name = "edges"
activation = "sigmoid"
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkpoint")
    parser.add_argument("onnx", type=Path)
    parser.add_argument("--label-share", type=float, default=0.5,
                        help="weight of the label head in the merged logit; the teacher's has the rest")
    parser.add_argument("--bias", type=float, default=0.0,
                        help="added to the logit, so that the best threshold becomes 0.5")
    parser.add_argument("--source", default="the authors of edvo; see models/README.md")
    parser.add_argument("--licence", default="see models/README.md")
    options = parser.parse_args()
    torch.set_num_threads(1)
    saved = torch.load(options.checkpoint, map_location="cpu")
    net = model.EdgeNet()
    net.load_state_dict(saved["mean"])
    share = options.label_share
    net = model.merged(net, (share, 1 - share), options.bias)
    write_onnx(net, options.onnx)
    worst = largest_difference(net, options.onnx)
    if not worst <= LARGEST_DIFFERENCE:
        raise SystemExit(f"{options.onnx}: OpenCV and torch differ by {worst:.2g}")
    options.onnx.with_suffix(".toml").write_text(
        description(options.onnx, options.source, options.licence))
    print(f"{options.onnx}: step {saved['step']}, {options.onnx.stat().st_size} bytes, "
          f"OpenCV and torch differ by {worst:.1g}")


if __name__ == "__main__":
    main()

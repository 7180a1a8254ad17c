#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes DexiNed with random weights as ONNX, and what torch says it answers.

    /usr/bin/python3 scripts/dexined_random.py FOLDER --image IMAGE [--divide N] [--seed S]

needs Debian's python3-torch, python3-onnx and python3-opencv. It is the architecture of Soria et
al., "Dense Extreme Inception Network for Edge Detection" (2023), 35.2 M parameters; --divide makes
every layer so many times narrower. FOLDER gets
    dexined.onnx + .toml       as torch exports it
    dexined_int8.onnx + .toml  the same weights as the OpenCV zoo stores them: 8-bit integers with a
                               scale for each block of 16
    reference.npy              torch's fused edge probability of the image, H x W, float32
The weights are first rounded to what 8 bits can hold, so that both files are the same network.
"""
import argparse
import hashlib
import io
import math
import time
from pathlib import Path

import cv2
import numpy as np
import onnx
import torch
from onnx import helper, numpy_helper
from torch import nn

MEAN_BGR = (103.939, 116.779, 123.68)
STRIDE = 16  # [px]
BLOCK = 16  # weights that share a scale
OPSET_OF_BLOCKS = 21  # the first with block_size


def normalized(channels_in, channels_out, size, stride=1, padding=0):
    return nn.Sequential(nn.Conv2d(channels_in, channels_out, size, stride, padding),
                         nn.BatchNorm2d(channels_out))


class Dense(nn.Module):
    """Layers that each average their answer with a skip connection that stays the same."""

    def __init__(self, layers, channels_in, channels):
        super().__init__()
        self.layers = nn.ModuleList(
            nn.Sequential(nn.ReLU(), normalized(channels_in if i == 0 else channels, channels, 3,
                                                padding=2),
                          nn.ReLU(), normalized(channels, channels, 3))
            for i in range(layers))

    def forward(self, x, skip):
        for layer in self.layers:
            x = 0.5 * (layer(x) + skip)
        return x


def upsampling(channels, doublings, hidden):
    """From 1/2^doublings of the size to all of it, one channel."""
    size = 2 ** doublings
    layers = []
    for i in range(doublings):
        out = 1 if i == doublings - 1 else hidden
        layers += [nn.Conv2d(channels, out, 1), nn.ReLU(),
                   nn.ConvTranspose2d(out, out, size, stride=2, padding=size // 2 - 1)]
        channels = out
    return nn.Sequential(*layers)


class DexiNed(nn.Module):
    def __init__(self, divide=1):
        super().__init__()

        def width(channels):
            return max(2, channels // divide)

        c32, c64, c128, c256, c512 = (width(c) for c in (32, 64, 128, 256, 512))
        self.block1 = nn.Sequential(normalized(3, c32, 3, 2, 1), nn.ReLU(),
                                    normalized(c32, c64, 3, 1, 1), nn.ReLU())
        self.block2 = nn.Sequential(normalized(c64, c128, 3, 1, 1), nn.ReLU(),
                                    normalized(c128, c128, 3, 1, 1))
        self.block3 = Dense(2, c128, c256)
        self.block4 = Dense(3, c256, c512)
        self.block5 = Dense(3, c512, c512)
        self.block6 = Dense(3, c512, c256)
        self.pool = nn.MaxPool2d(3, 2, 1)
        self.side1 = normalized(c64, c128, 1, 2)
        self.side2 = normalized(c128, c256, 1, 2)
        self.side3 = normalized(c256, c512, 1, 2)
        self.side4 = normalized(c512, c512, 1)
        self.side5 = normalized(c512, c256, 1)  # in the count of parameters, not in use
        self.skip2 = normalized(c128, c256, 1, 2)
        self.skip3 = normalized(c128, c256, 1)
        self.skip4 = normalized(c256, c512, 1)
        self.skip5 = normalized(c512, c512, 1)
        self.skip6 = normalized(c512, c256, 1)
        self.up = nn.ModuleList(upsampling(c, d, width(16)) for c, d in (
            (c64, 1), (c128, 1), (c256, 2), (c512, 3), (c512, 4), (c256, 4)))
        self.fuse = nn.Conv2d(6, 1, 1)

    def forward(self, x):
        b1 = self.block1(x)
        b2 = self.block2(b1)
        down2 = self.pool(b2)
        in3 = down2 + self.side1(b1)
        b3 = self.block3(in3, self.skip3(down2))
        down3 = self.pool(b3)
        in4 = down3 + self.side2(in3)
        b4 = self.block4(in4, self.skip4(down3 + self.skip2(down2)))
        down4 = self.pool(b4)
        in5 = down4 + self.side3(in4)
        b5 = self.block5(in5, self.skip5(down4))
        b6 = self.block6(b5 + self.side4(in5), self.skip6(b5))
        maps = [up(b) for up, b in zip(self.up, (b1, b2, b3, b4, b5, b6))]
        return (*maps, self.fuse(torch.cat(maps, dim=1)))


def network_input(bgr):
    """1 x 3 x H x W, padded to multiples of the stride as the description says."""
    height, width = bgr.shape[:2]
    padded = cv2.copyMakeBorder(bgr, 0, -height % STRIDE, 0, -width % STRIDE,
                                cv2.BORDER_REFLECT_101)
    shifted = padded.astype(np.float32) - np.array(MEAN_BGR, np.float32)
    return torch.from_numpy(shifted.transpose(2, 0, 1)[None].copy())


def randomized(network, example, seed):
    """Weights as before training; normalisation as if it had seen the example."""
    torch.manual_seed(seed)
    for module in network.modules():
        if isinstance(module, (nn.Conv2d, nn.ConvTranspose2d)):
            fan_in = module.weight[0].numel()
            if isinstance(module, nn.ConvTranspose2d):
                fan_in = module.weight.shape[0] * module.kernel_size[0] ** 2 / 4
            nn.init.normal_(module.weight, std=math.sqrt(2 / fan_in))
            nn.init.normal_(module.bias, std=0.1)
        if isinstance(module, nn.BatchNorm2d):
            module.momentum = None  # the mean of what it sees
            nn.init.uniform_(module.weight, 0.5, 1.5)
            nn.init.normal_(module.bias, std=0.1)
    with torch.no_grad():
        maps = network.train()(example)[:-1]
        scales = [0.8 / float(m.std() + 1e-6) for m in maps]
        network.fuse.weight.copy_(torch.tensor(scales)[None, :, None, None])
        network.fuse.bias.fill_(-sum(s * float(m.mean()) for s, m in zip(scales, maps)))
    return network.eval()


def fuse_normalization(network):
    """Into the convolution before it: that is what exporters store."""
    for module in network.modules():
        if isinstance(module, nn.Sequential) and len(module) == 2 and \
                isinstance(module[1], nn.BatchNorm2d):
            module[0] = nn.utils.fuse_conv_bn_eval(module[0], module[1])
            module[1] = nn.Identity()


def exported(network):
    file = io.BytesIO()
    names = [f"map{i}" for i in range(1, 7)] + ["fused"]
    torch.onnx.export(network, torch.zeros(1, 3, 480, 640), file, opset_version=11,
                      input_names=["img"], output_names=names,
                      dynamic_axes={name: {2: "height", 3: "width"} for name in ["img", *names]})
    return onnx.load_from_string(file.getvalue())


def quantized(weights):
    """Integers, scales and zero points of each block; and the floats that they stand for."""
    flat = weights.reshape(weights.shape[0], -1) if weights.ndim > 1 else weights[None]
    block = next(d for d in range(BLOCK, 0, -1) if flat.shape[1] % d == 0)
    blocks = flat.reshape(flat.shape[0], -1, block)
    low = np.minimum(blocks.min(-1), 0)
    high = np.maximum(blocks.max(-1), 0)
    scale = np.where(high > low, (high - low) / 255, 1).astype(np.float32)
    zero = np.rint(-128 - low / scale).astype(np.int8)
    numbers = np.clip(np.rint(blocks / scale[..., None] + zero[..., None]), -128, 127)
    numbers = numbers.astype(np.int8)
    floats = (numbers.astype(np.float32) - zero[..., None].astype(np.float32)) * scale[..., None]
    if weights.ndim == 1:
        return numbers.reshape(-1), scale[0], zero[0], block, floats.reshape(-1)
    return numbers.reshape(flat.shape), scale, zero, block, floats.reshape(weights.shape)


def round_and_quantize(model):
    """Rounds the weights of every convolution in the model; returns its copy in integers."""
    stored = {i.name: i for i in model.graph.initializer}
    nodes, tensors, replaced = [], {}, {}
    for node in [n for n in model.graph.node if n.op_type == "Conv"]:
        for name in node.input:
            if name not in stored or name in replaced:
                continue
            weights = numpy_helper.to_array(stored[name])
            if weights.size < BLOCK:
                continue
            numbers, scale, zero, block, floats = quantized(weights)
            stored[name].CopyFrom(numpy_helper.from_array(floats, name))
            parts = {"quantized": numbers, "scales": scale, "zero_point": zero}
            tensors |= {f"{name}_{part}": value for part, value in parts.items()}
            replaced[name] = f"{name}_dequantized"
            nodes.append(helper.make_node(
                "DequantizeLinear", [f"{name}_{part}" for part in parts], [replaced[name]],
                block_size=block, axis=min(1, numbers.ndim - 1)))
            if weights.ndim > 2:
                tensors[f"{name}_shape"] = np.array(weights.shape)
                replaced[name] = f"{name}_reshaped"
                nodes.append(helper.make_node(
                    "Reshape", [f"{name}_dequantized", f"{name}_shape"], [replaced[name]]))
    copy = onnx.ModelProto()
    copy.CopyFrom(model)
    copy.ir_version = 10
    copy.opset_import[0].version = OPSET_OF_BLOCKS
    kept = [i for i in model.graph.initializer if i.name not in replaced]
    del copy.graph.initializer[:]
    copy.graph.initializer.extend(kept + [numpy_helper.from_array(v, n) for n, v in tensors.items()])
    for node in copy.graph.node:
        node.input[:] = [replaced.get(name, name) for name in node.input]
    nodes += copy.graph.node
    del copy.graph.node[:]
    copy.graph.node.extend(nodes)
    return copy


def write_model(model, folder, name):
    model.producer_name = "edvo"
    data = model.SerializeToString()
    (folder / f"{name}.onnx").write_bytes(data)
    (folder / f"{name}.toml").write_text(f"""name = "{name}"
file = "{name}.onnx"
sha256 = "{hashlib.sha256(data).hexdigest()}"
licence = "MIT"
source = "edvo: random weights, scripts/dexined_random.py"

[input]
channels = "bgr"
mean = {list(MEAN_BGR)}
multiple_of = {STRIDE}

[output]
index = -1
activation = "sigmoid"
""", encoding="utf-8")
    print(f"{name}.onnx: {len(data)} bytes")


def example_image(height=48, width=80):
    """A bright square on a pattern; tests make the same one."""
    y, x = np.mgrid[:height, :width]
    image = np.stack([(3 * x + 5 * y + 40 * c + x * y % 17) % 128 for c in range(3)], axis=-1)
    image[10:30, 20:60] += 100
    return image.astype(np.uint8)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--image", help="default: a pattern of 80 x 48 px")
    parser.add_argument("--divide", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    bgr = cv2.imread(arguments.image) if arguments.image else example_image()
    if bgr is None:
        parser.error(f"{arguments.image}: cannot be read")

    network = DexiNed(arguments.divide)
    parameters = sum(p.numel() for p in network.parameters())
    network = randomized(network, network_input(example_image(160, 224)), arguments.seed)
    fuse_normalization(network)
    print(f"{parameters} parameters")
    model = exported(network)
    integers = round_and_quantize(model)
    write_model(model, arguments.folder, "dexined")
    write_model(integers, arguments.folder, "dexined_int8")

    network.load_state_dict({i.name: torch.from_numpy(numpy_helper.to_array(i).copy())
                             for i in model.graph.initializer}, strict=False)  # side5
    example = network_input(bgr)
    with torch.no_grad():
        start = time.perf_counter()
        logits = network(example)[-1]
        seconds = time.perf_counter() - start
    height, width = bgr.shape[:2]
    probability = torch.sigmoid(logits)[0, 0, :height, :width].numpy()
    np.save(arguments.folder / "reference.npy", probability)
    print(f"torch {torch.__version__}: {seconds:.2f} s for {width} x {height} px; probabilities "
          f"{probability.min():.4f} to {probability.max():.4f}, mean {probability.mean():.4f}")


if __name__ == "__main__":
    main()

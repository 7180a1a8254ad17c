# SPDX-License-Identifier: MIT
"""Writes a teacher: the answers of a checkpoint's label head, weighed by the contrast of the image.

python3 training/contrast.py runs/second/checkpoint.pth CONTRAST.onnx

A network trained on drawings marks what people would draw, also where the image hardly changes; noise
moves such an edge, and another view does not show it again. p' = sqrt(p g / (g + CONTRAST)), with g the
Sobel magnitude after a Gaussian blur, says which edges stay where they are. train.py takes the file
as --teacher.
"""
import argparse

import numpy as np
import torch
from torch import nn
from torch.nn import functional

import export
import model

CONTRAST = 100.0  # Sobel magnitude that halves the weight [grey levels]
SIGMA = 1.5  # [px]
RADIUS = 6  # [px]
LUMA_OF_BGR = (0.114, 0.587, 0.299)


def sobel_of_gaussian():
    """2 x 1 x N x N: x and y."""
    offset = np.arange(-RADIUS, RADIUS + 1, dtype=np.float64)
    bell = np.exp(-offset**2 / (2 * SIGMA**2))
    bell /= bell.sum()
    slope = np.convolve(bell, [1, 0, -1])
    smooth = np.convolve(bell, [1, 2, 1])
    return torch.tensor(np.stack([np.outer(smooth, slope), np.outer(slope, smooth)])[:, None]).float()


class Weighed(nn.Module):
    """B x 3 x H x W, BGR of 0..255 -> B x 1 x H x W."""

    def __init__(self, net):
        super().__init__()
        self.net = net
        self.register_buffer("luma", torch.tensor(LUMA_OF_BGR).reshape(1, 3, 1, 1))
        self.register_buffer("derivatives", sobel_of_gaussian())
        self.register_buffer("both", torch.ones(1, 2, 1, 1))

    def forward(self, bgr):
        probability = torch.sigmoid(self.net((bgr - model.MEAN) * model.SCALE))
        # Zeros around the image: within 7 pixels of its border contrast is high, which weighs nothing.
        gray = functional.conv2d(bgr, self.luma)
        gradient = functional.conv2d(gray, self.derivatives, padding=RADIUS + 1)
        magnitude = torch.sqrt(functional.conv2d(gradient * gradient, self.both) + 1e-6)
        return torch.sqrt(probability * magnitude / (magnitude + CONTRAST))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkpoint")
    parser.add_argument("onnx")
    options = parser.parse_args()
    net = model.EdgeNet()
    net.load_state_dict(torch.load(options.checkpoint, map_location="cpu")["mean"])
    export.write_onnx(Weighed(model.merged(net, (1, 0))).eval(), options.onnx)


if __name__ == "__main__":
    main()

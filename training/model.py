# SPDX-License-Identifier: MIT
"""The network: an edge map of full resolution from features of 1/2, 1/4 and 1/8.

Its shape follows what OpenCV's dnn module is fast at on a CPU (README.md has the measurements):
depthwise 3x3 with pointwise convolutions, few full ones at half resolution, none at full resolution.
"""
import torch
from torch import nn
from torch.nn import functional

STRIDE = 8  # the sides of the input are multiples of this
MEAN = 127.5  # subtracted from the image of 0..255
SCALE = 1 / 64  # multiplied afterwards


class ConvNorm(nn.Sequential):
    """Convolution and batch normalization; `folded` gives the same as one convolution."""

    def __init__(self, inputs, outputs, kernel, stride=1, groups=1):
        super().__init__(
            nn.Conv2d(inputs, outputs, kernel, stride, (kernel - 1) // 2, 1, groups, bias=False),
            nn.BatchNorm2d(outputs),
        )

    def folded(self):
        conv, norm = self
        gain = norm.weight / torch.sqrt(norm.running_var + norm.eps)
        fold = nn.Conv2d(conv.in_channels, conv.out_channels, conv.kernel_size, conv.stride,
                         conv.padding, conv.dilation, conv.groups)
        fold.weight.data = conv.weight.data * gain.data[:, None, None, None]
        fold.bias.data = (norm.bias - norm.running_mean * gain).data
        return fold


class Separable(nn.Module):
    """Depthwise 3x3, then pointwise; adds its input when the shapes agree."""

    def __init__(self, inputs, outputs, stride=1, adds=None):
        super().__init__()
        self.depthwise = ConvNorm(inputs, inputs, 3, stride, groups=inputs)
        self.pointwise = ConvNorm(inputs, outputs, 1)
        self.adds = stride == 1 and inputs == outputs if adds is None else adds

    def forward(self, x):
        y = self.pointwise(functional.relu(self.depthwise(x)))
        return functional.relu(x + y if self.adds else y)


class MergeHalf(nn.Sequential):
    """Two Separable on the features of half resolution and those of coarser ones."""

    def __init__(self, half):
        super().__init__(Separable(2 * half, 2 * half, adds=False), Separable(2 * half, half))

    def forward(self, fine, coarse):
        return super().forward(torch.cat([fine, coarse], 1))


class InGroups(nn.Module):
    """The same as MergeHalf after folding, on groups of channels that are never put together.

    What a layer reads and writes then stays in the CPU's cache.
    """

    def __init__(self, merge):
        super().__init__()
        self.layers = nn.ModuleList()
        group = merge[-1].pointwise.out_channels
        for layer in merge:
            inputs, outputs = (range(0, n, group) for n in (layer.pointwise.in_channels,
                                                            layer.pointwise.out_channels))
            depthwise = [self.part(layer.depthwise, slice(i, i + group), slice(None)) for i in inputs]
            pointwise = [nn.ModuleList(self.part(layer.pointwise, slice(o, o + group),
                                                 slice(i, i + group), has_bias=i == 0)
                                       for i in inputs) for o in outputs]
            self.layers.append(nn.ModuleDict({"depthwise": nn.ModuleList(depthwise),
                                              "pointwise": nn.ModuleList(pointwise)}))

    @staticmethod
    def part(conv, outputs, inputs, has_bias=True):
        weight = conv.weight.data[outputs, inputs]
        groups = 1 if conv.groups == 1 else len(weight)
        part = nn.Conv2d(groups * weight.shape[1], len(weight), conv.kernel_size, conv.stride,
                         conv.padding, conv.dilation, groups, bias=has_bias)
        part.weight.data = weight.clone()
        if has_bias:
            part.bias.data = conv.bias.data[outputs].clone()
        return part

    def forward(self, *groups):
        for layer in self.layers:
            seen = [functional.relu(conv(x)) for conv, x in zip(layer["depthwise"], groups)]
            groups = [functional.relu(sum(conv(x) for conv, x in zip(row, seen)))
                      for row in layer["pointwise"]]
        return groups[0]


def double(x):
    return functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)


class EdgeNet(nn.Module):
    """B x 3 x H x W -> B x `heads` x H x W logits.

    In training there are two heads: the first learns the labels, the second the teacher.
    `merged` gives the network with one head, whose logit is a weighted mean of both.
    """

    def __init__(self, half=16, quarter=48, eighth=96, heads=2):
        super().__init__()
        self.stem = ConvNorm(3, half, 4, 2)  # 4x4 lies symmetrically on the 2x2 pixels of a cell
        self.fine = ConvNorm(half, half, 3)
        self.to_quarter = ConvNorm(half, quarter, 3, 2)
        self.quarter = nn.Sequential(*[Separable(quarter, quarter) for _ in range(3)])
        self.to_eighth = Separable(quarter, eighth, 2)
        self.eighth = nn.Sequential(*[Separable(eighth, eighth) for _ in range(4)])
        self.from_eighth = ConvNorm(eighth, quarter, 1)
        self.merge_quarter = nn.Sequential(*[Separable(quarter, quarter) for _ in range(2)])
        self.from_quarter = ConvNorm(quarter, half, 1)
        self.merge_half = MergeHalf(half)
        # Every pixel of the answer sees 2x2 cells of half resolution.
        self.head = nn.ConvTranspose2d(half, heads, 4, 2, 1)
        nn.init.normal_(self.head.weight, std=0.02)
        nn.init.constant_(self.head.bias, -2.0)

    def forward(self, x):
        half = functional.relu(self.stem(x))
        half = functional.relu(self.fine(half))
        quarter = self.quarter(functional.relu(self.to_quarter(half)))
        eighth = self.eighth(self.to_eighth(quarter))
        quarter = self.merge_quarter(quarter + double(self.from_eighth(eighth)))
        coarse = functional.relu(double(self.from_quarter(quarter)))
        return self.head(self.merge_half(half, coarse))


def merged(net, weights=(0.5, 0.5), bias=0.0):
    """A copy for inference: batch normalization folded in, the heads' logits averaged, `bias` added,
    features of half resolution in groups."""
    import copy
    out = copy.deepcopy(net).eval()
    for module in list(out.modules()):
        for name, child in list(module.named_children()):
            if isinstance(child, ConvNorm):
                setattr(module, name, child.folded())
    out.merge_half = InGroups(out.merge_half)
    share = torch.tensor(weights, dtype=torch.float32)
    head = nn.ConvTranspose2d(out.head.in_channels, 1, 4, 2, 1)
    head.weight.data = (out.head.weight.data * share[None, :, None, None]).sum(1, keepdim=True)
    head.bias.data = (out.head.bias.data * share).sum().reshape(1) + bias
    out.head = head
    return out


def to_input(bgr):
    """H x W x 3 image of 0..255 (or a batch B x H x W x 3) -> what the network takes."""
    x = torch.as_tensor(bgr).float()
    x = x[None] if x.ndim == 3 else x
    return ((x - MEAN) * SCALE).permute(0, 3, 1, 2).contiguous()

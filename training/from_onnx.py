# SPDX-License-Identifier: MIT
"""The network of an ONNX file that export.py wrote, as a torch network that can be trained on."""
import onnx
import torch
from onnx import numpy_helper

import model


def weights_of(path):
    graph = onnx.load(str(path)).graph
    return {t.name: torch.from_numpy(numpy_helper.to_array(t).copy()) for t in graph.initializer}


def fill(norm, bias, mean, variance):
    """Batch normalization that adds `bias` to its input, whose statistics are these."""
    norm.running_mean.copy_(mean)
    norm.running_var.copy_(variance)
    norm.weight.data.copy_(torch.sqrt(variance + norm.eps))
    norm.bias.data.copy_(bias + mean)


def load(path):
    """EdgeNet whose second head is the file's; batch normalization passes everything on (eval mode).

    Call calibrate() before training.
    """
    weights = weights_of(path)
    net = model.EdgeNet().eval()
    for name, module in net.named_modules():
        if not isinstance(module, model.ConvNorm):
            continue
        conv, norm = module
        if name.startswith("merge_half."):
            _, layer, kind = name.split(".")
            weight, bias = merged_groups(weights, f"merge_half.layers.{layer}.{kind}", kind)
        else:
            weight, bias = weights[f"{name}.weight"], weights[f"{name}.bias"]
        conv.weight.data.copy_(weight)
        fill(norm, bias, torch.zeros_like(bias), torch.ones_like(bias))
    net.head.weight.data[:, 1:] = weights["head.weight"]
    net.head.bias.data[1:] = weights["head.bias"]
    net.head.weight.data[:, :1] = weights["head.weight"]
    net.head.bias.data[:1] = weights["head.bias"]
    return net


def merged_groups(weights, name, kind):
    """What model.InGroups took apart."""
    if kind == "depthwise":
        count = sum(f"{name}.{i}.weight" in weights for i in range(16))
        return (torch.cat([weights[f"{name}.{i}.{what}"] for i in range(count)])
                for what in ("weight", "bias"))
    rows = [o for o in range(16) if f"{name}.{o}.0.weight" in weights]
    columns = [i for i in range(16) if f"{name}.0.{i}.weight" in weights]
    weight = torch.cat([torch.cat([weights[f"{name}.{o}.{i}.weight"] for i in columns], 1)
                        for o in rows])
    return weight, torch.cat([weights[f"{name}.{o}.0.bias"] for o in rows])


@torch.no_grad()
def calibrate(net, images):
    """Gives batch normalization the statistics of its inputs for these images (B x 3 x H x W, as
    model.to_input makes them). The network's answers stay the same in eval mode."""
    found = {}
    hooks = [module[1].register_forward_pre_hook(
                 lambda norm, inputs: found.__setitem__(norm, torch.var_mean(inputs[0], (0, 2, 3))))
             for module in net.modules() if isinstance(module, model.ConvNorm)]
    net.eval()
    net(images)
    for hook in hooks:
        hook.remove()
    for norm, (variance, mean) in found.items():
        bias = norm.bias - norm.running_mean * norm.weight / torch.sqrt(norm.running_var + norm.eps)
        scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
        assert torch.allclose(scale, torch.ones_like(scale), atol=1e-3), "calibrate once, after load"
        fill(norm, bias.clone(), mean, variance)

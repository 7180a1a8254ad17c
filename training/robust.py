# SPDX-License-Identifier: MIT
"""Trains edvo's network on to give the same answer whatever noise, blur and shadows an image has.

Images are free photographs and rendered twins: a sequence NAME with faults of the camera and of the
light, and NAME-clean without (benchmarks/network.py renders such pairs). What is learned is the
answer of the present network for the clean image and the same enlarged, mixed with the edges that
Canny finds there (--canny).

python3 training/robust.py models/edvo_edges.onnx --photos FREE --twins TWINS --out RUN
"""
import argparse
import copy
import math
import time
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.nn import functional

import data
import from_onnx
import model

PHOTO_SIDES = (800, 500)  # longest sides of a photograph [pixels]
ZOOM = 1.5


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("start", help="ONNX file of the network to begin with")
    parser.add_argument("--photos", type=Path, required=True)
    parser.add_argument("--twins", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--canny", type=float, default=0, help="share of Canny in the target [0..1]")
    parser.add_argument("--photo-share", type=float, default=0.5, help="of the crops")
    parser.add_argument("--steps", type=int, default=8000)
    parser.add_argument("--seconds", type=float, default=1e9, help="the rate falls to 0 until then")
    parser.add_argument("--batch", type=int, default=32)
    parser.add_argument("--size", type=int, default=192)
    parser.add_argument("--rate", type=float, default=1.5e-3)
    parser.add_argument("--workers", type=int, default=5)
    parser.add_argument("--average", type=float, default=0.998)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    return parser.parse_args()


@torch.no_grad()
def strength(net, bgr, device):
    """Of the image and of the image enlarged: the mean of both logits, as a probability."""

    def logit(image):
        height, width = image.shape[:2]
        padded = cv2.copyMakeBorder(image, 0, -height % 8, 0, -width % 8, cv2.BORDER_REFLECT_101)
        answer = net(model.to_input(padded).to(device))[0, 1, :height, :width]
        return answer.cpu().numpy()

    large = cv2.resize(bgr, None, fx=ZOOM, fy=ZOOM, interpolation=cv2.INTER_CUBIC)
    shrunk = cv2.resize(logit(large), bgr.shape[1::-1], interpolation=cv2.INTER_AREA)
    return 1 / (1 + np.exp(-(logit(bgr) + shrunk) / 2))


def canny(bgr, share=0.2, low_ratio=0.4):
    """As edvo's canny+corner finds edges, a pixel wider."""
    gray = cv2.GaussianBlur(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), (0, 0), 1.0)
    gx, gy = (cv2.Sobel(gray, cv2.CV_16S, *axis) for axis in ((1, 0), (0, 1)))
    norm = np.abs(gx.astype(np.int32)) + np.abs(gy)
    high = max(16, float(np.quantile(norm, 1 - share)))
    return cv2.dilate(cv2.Canny(gx, gy, low_ratio * high, high), np.ones((3, 3), np.uint8)) / 255


def samples_of(options, net):
    def sample(taken, clean):
        target = strength(net, clean, options.device)
        if options.canny:
            target = (1 - options.canny) * target + options.canny * canny(clean)
        target = np.rint(255 * target).astype(np.uint8)
        return data.Sample(taken, np.zeros_like(target), target, False)

    photos, twins = [], []
    for path in data.images_below(options.photos):
        for side in PHOTO_SIDES:
            image = data.read(path)
            image = data.shrink(image, min(1, side / max(image.shape)))
            photos.append(sample(image, image))
    for folder in sorted(options.twins.glob("*-clean")):
        taken = folder.with_name(folder.name.removesuffix("-clean"))
        for path in sorted((folder / "rgb").glob("*.png")):
            twins.append(sample(data.read(taken / "rgb" / path.name), data.read(path)))
    return photos, twins


def blur_motion(bgr, rng):
    """Along a line of up to 12 pixels, at any angle, the middle where it was."""
    length, angle = rng.uniform(2, 12), rng.uniform(0, math.pi)
    kernel = np.zeros((15, 15), np.float32)
    for t in np.linspace(-length / 2, length / 2, 49):
        x, y = 7 + t * math.cos(angle), 7 + t * math.sin(angle)
        kernel[int(round(y)), int(round(x))] += 1
    return cv2.filter2D(bgr, -1, kernel / kernel.sum())


def make_dark(bgr, rng):
    """Little light, amplified: noise of each colour that grows with brightness."""
    gain = rng.uniform(1, 9)
    variance = (2 * gain) ** 2 + 0.05 * gain * bgr.astype(np.float32)
    noisy = bgr + np.sqrt(variance) * rng.standard_normal(bgr.shape, np.float32)
    return np.clip(noisy, 0, 255).astype(np.uint8)


class Crops(torch.utils.data.Dataset):
    """Crop number n is the same for the same seed."""

    def __init__(self, photos, twins, options):
        self.photos, self.twins, self.options = photos, twins, options

    def __len__(self):
        return self.options.steps * self.options.batch

    def __getitem__(self, number):
        cv2.setNumThreads(0)
        rng = np.random.default_rng([self.options.seed, number])
        is_photo = rng.random() < self.options.photo_share
        source = self.photos if is_photo else self.twins
        bgr, _, target = data.crop(source[rng.integers(len(source))], self.options.size, rng)
        if is_photo and rng.random() < 0.25:
            bgr = blur_motion(bgr, rng)
        if is_photo and rng.random() < 0.35:
            bgr = make_dark(bgr, rng)
        else:
            bgr = data.disturb(bgr, rng)
        return np.ascontiguousarray(bgr), target


def rate_at(done, options):
    """done: share of the steps or of the time, whichever is more."""
    warm = min(1, done / 0.03)
    return options.rate * warm * 0.5 * (1 + math.cos(math.pi * min(done, 1)))


def main():
    options = arguments()
    torch.manual_seed(options.seed)
    options.out.mkdir(parents=True, exist_ok=True)
    started = time.time()
    net = from_onnx.load(options.start).to(options.device)
    photos, twins = samples_of(options, net)
    print(f"{len(photos)} photographs, {len(twins)} twins, {time.time() - started:.0f} s", flush=True)
    crops = Crops(photos, twins, options)
    loader = torch.utils.data.DataLoader(crops, options.batch, num_workers=options.workers,
                                         prefetch_factor=4 if options.workers else 2)
    first = np.stack([crops[i][0] for i in range(min(256, len(crops)))])
    from_onnx.calibrate(net, model.to_input(first).to(options.device))
    mean = copy.deepcopy(net)
    net.train()
    optimizer = torch.optim.AdamW(net.parameters(), options.rate, weight_decay=1e-4)
    log = open(options.out / "log.csv", "a")
    total, count, began = 0.0, 0, time.time()
    for step, (bgr, target) in enumerate(loader):
        done = max(step / options.steps, (time.time() - began) / options.seconds)
        for group in optimizer.param_groups:
            group["lr"] = rate_at(done, options)
        image = model.to_input(bgr.to(options.device))
        target = target.to(options.device).float()[:, None] / 255
        loss = functional.binary_cross_entropy_with_logits(net(image)[:, 1:], target)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        with torch.no_grad():
            decay = min(options.average, (step + 1) / (step + 10))
            for kept, new in zip(mean.state_dict().values(), net.state_dict().values()):
                kept.lerp_(new, 1 - decay) if kept.dtype.is_floating_point else kept.copy_(new)
        total, count = total + loss.item(), count + 1
        last = done >= 1 or step + 1 == options.steps
        if count == 500 or last:
            print(f"{step + 1},{total / count:.5f},{time.time() - started:.0f}", file=log, flush=True)
            total, count = 0.0, 0
            saved = {"step": step + 1, "mean": {k: v.cpu() for k, v in mean.state_dict().items()}}
            torch.save(saved, options.out / "checkpoint.part")
            (options.out / "checkpoint.part").replace(options.out / "checkpoint.pth")
        if last:
            break


if __name__ == "__main__":
    main()

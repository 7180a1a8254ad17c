# SPDX-License-Identifier: MIT
"""Do depth and colour belong together: in space and in time. Edges of both must coincide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from edvo.doctor.finding import Finding, ok, unknown
from edvo.doctor.sample import Sample, to_gray
from edvo.sources.base import Frame

LARGEST_SHIFT = 12  # [px]
Map = NDArray[np.float32]


def gradient(image: Map) -> Map:
    result = np.zeros_like(image)
    dx = np.abs(image[1:-1, 2:] - image[1:-1, :-2])
    dy = np.abs(image[2:, 1:-1] - image[:-2, 1:-1])
    result[1:-1, 1:-1] = dx + dy
    return result


def image_edges(frame: Frame) -> Map:
    """The logarithm tames single strong edges."""
    return np.log1p(gradient(to_gray(frame.rgb)))


def depth_edges(frame: Frame) -> Map:
    """1 where depth jumps by more than 5 %, on the nearer side's border; holes are no edges."""
    z = frame.depth
    edges = np.zeros(z.shape, np.float32)
    with np.errstate(invalid="ignore", divide="ignore"):
        for axis in (0, 1):
            a = z[:-1] if axis == 0 else z[:, :-1]
            b = z[1:] if axis == 0 else z[:, 1:]
            jump = np.abs(a - b) > 0.05 * np.minimum(a, b)
            if axis == 0:
                edges[:-1] += jump * (a < b)
                edges[1:] += jump * (b <= a)
            else:
                edges[:, :-1] += jump * (a < b)
                edges[:, 1:] += jump * (b <= a)
    return np.minimum(edges, 1)


def correlations(image: Map, depth: Map) -> Map:
    """Mean image edge under the depth edges moved by (dy, dx), over the image's mean."""
    size = 2 * LARGEST_SHIFT + 1
    result = np.zeros((size, size), np.float32)
    s = LARGEST_SHIFT
    ys, xs = np.nonzero(depth[s:-s, s:-s])
    if len(ys) < 200:
        return result
    if len(ys) > 6000:
        chosen = np.linspace(0, len(ys) - 1, 6000).astype(int)
        ys, xs = ys[chosen], xs[chosen]
    mean = float(image.mean()) + 1e-6
    for dy in range(-s, s + 1):
        for dx in range(-s, s + 1):
            result[dy + s, dx + s] = image[ys + s + dy, xs + s + dx].mean() / mean
    return result


def registration(sample: Sample) -> Finding:
    total = np.zeros((2 * LARGEST_SHIFT + 1,) * 2, np.float32)
    used = 0
    for group in sample.groups:
        for frame in group[:: max(1, len(group) // 2)]:
            found = correlations(image_edges(frame), depth_edges(frame))
            total += found
            used += bool(found.any())
    if used < 3:
        return unknown("registration", "too few jumps in depth")
    total /= used
    background = float(np.median(total))
    peak = np.unravel_index(int(total.argmax()), total.shape)
    dy, dx = int(peak[0]) - LARGEST_SHIFT, int(peak[1]) - LARGEST_SHIFT
    s = LARGEST_SHIFT
    near = float(total[s - 1 : s + 2, s - 1 : s + 2].max()) - background
    best = float(total[peak]) - background
    measured = f"edges of depth fit edges of colour best when moved by ({dx}, {dy}) px"
    if best < 0.15 * background:
        return unknown("registration", "edges of depth and colour do not correlate anywhere")
    if max(abs(dx), abs(dy)) >= 3 and best > 1.15 * near:
        return Finding(
            "registration",
            "fault",
            measured,
            "depth is not registered to colour: record the aligned stream, or give the depth "
            "camera with --depth-camera and --colour-from-depth",
            3,
        )
    return ok("registration", measured)


def fit_at(image: Map, depth: Map) -> float:
    """How well edges coincide, allowing 1 px."""
    ys, xs = np.nonzero(depth[2:-2, 2:-2])
    if len(ys) < 200:
        return float("nan")
    around = np.max(
        [image[ys + 2 + dy, xs + 2 + dx] for dy in (-1, 0, 1) for dx in (-1, 0, 1)], axis=0
    )
    return float(around.mean() / (image.mean() + 1e-6))


def time_offset(sample: Sample) -> Finding:
    """Depth of which neighbouring frame fits the image best, where the camera moves."""
    reach = 2
    scores: list[list[float]] = []
    for group in sample.groups:
        images = [image_edges(frame) for frame in group]
        depths = [depth_edges(frame) for frame in group]
        for i in range(reach, len(group) - reach):
            row = [fit_at(images[i], depths[i + k]) for k in range(-reach, reach + 1)]
            if np.isfinite(row).all() and max(row) > 1.03 * min(row):  # the camera moves
                scores.append(row)
    if len(scores) < 6:
        return unknown("time_offset", "too little motion or too few jumps in depth")
    table = np.array(scores)
    mean = table.mean(axis=0)
    best = int(mean.argmax()) - reach
    period = float(np.median(np.diff(sample.stamps_ns))) * 1e-9
    measured = f"depth of {best:+d} frames fits best ({1000 * best * period:+.0f} ms)"
    wins = float((table.argmax(axis=1) == best + reach).mean())
    if best != 0 and wins > 0.5 and mean[best + reach] > 1.01 * mean[reach]:
        return Finding(
            "time_offset",
            "fault",
            measured,
            f"move the stamps of depth by {-best * period:+.3f} s, or synchronize the streams",
            2,
        )
    return ok("time_offset", measured)

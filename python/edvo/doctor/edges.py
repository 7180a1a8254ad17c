# SPDX-License-Identifier: MIT
"""Do depth and colour belong together: in space and in time. Edges of both must coincide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from edvo.doctor.finding import Finding, ok, unknown
from edvo.doctor.sample import Sample, to_gray
from edvo.sources.base import Frame

LARGEST_SHIFT = 12  # [px] of images that are about 320 px wide
WORKING_WIDTH = 320  # [px]
SCALES = 1.04 ** np.arange(-13, 14)  # 0.60 to 1.67: colour cameras see less or more than depth's
COARSE_SCALES = (0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4)
FEWEST_EDGES = 200  # pixels of an image
CLEARLY = 1.15  # times as good
REACH = 2  # frames, of the search in time
LEAST_DELAY = 0.8  # periods; less is how a sensor stamps its images
FEWEST_SCORES = 12  # frames in motion
LEAST_FIT = 0.25  # sigmas of the images' detail
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


def blurred(image: Map, reach: int) -> Map:
    """The mean of (2 * reach + 1)^2 pixels, borders repeated."""
    size = 2 * reach + 1
    for axis in (0, 1):
        padding = [(0, 0), (0, 0)]
        padding[axis] = (reach + 1, reach)
        sums = np.cumsum(np.pad(image, padding, mode="edge"), axis=axis, dtype=np.float64)
        ends = [slice(None), slice(None)]
        begins = [slice(None), slice(None)]
        ends[axis], begins[axis] = slice(size, None), slice(None, -size)
        image = ((sums[tuple(ends)] - sums[tuple(begins)]) / size).astype(np.float32)
    return image


def image_detail(frame: Frame) -> Map:
    """Edges of the small image less those around them, so that busy parts count as others do."""
    edges = image_edges(frame)
    factor = max(1, round(edges.shape[1] / WORKING_WIDTH))
    height, width = edges.shape[0] // factor, edges.shape[1] // factor
    blocks = edges[: height * factor, : width * factor].reshape(height, factor, width, factor)
    small = blocks.mean(axis=(1, 3)).astype(np.float32)
    detail = blurred(small, 1) - blurred(small, 6)
    return np.asarray(detail / (detail.std() + 1e-6))


def edge_pixels(frame: Frame, shape: tuple[int, ...]) -> NDArray[np.float64] | None:
    """(y, x) of depth edges in the small image; None = too few."""
    ys, xs = np.nonzero(depth_edges(frame))
    if len(ys) < FEWEST_EDGES:
        return None
    if len(ys) > 6000:
        chosen = np.linspace(0, len(ys) - 1, 6000).astype(int)
        ys, xs = ys[chosen], xs[chosen]
    return np.asarray(np.stack([ys, xs]) * (shape[1] / frame.depth.shape[1]))


class EdgeFit:
    """How well depth edges, enlarged about the image's middle and moved, fit edges of images.

    ``pairs``: the frames whose images and those whose depths are taken.
    """

    def __init__(self, pairs: list[tuple[Frame, Frame]]) -> None:
        self.images = []
        self.depths = []
        for of_image, of_depth in pairs:
            image = image_detail(of_image)
            depth = edge_pixels(of_depth, image.shape)
            if depth is not None:
                self.images.append(np.fft.rfft2(image))
                self.depths.append(depth)
                self.shape = image.shape

    def best(self) -> float:
        """At a few enlargements; 0 with too few images."""
        return max(float(self.at(s).max()) for s in COARSE_SCALES) if len(self.depths) > 3 else 0

    def at(self, scale: float) -> Map:
        """By (dy, dx): mean detail [its sigmas] under the depth edges of all frames."""
        s = LARGEST_SHIFT
        height, width = self.shape
        middle = np.array([[(height - 1) / 2], [(width - 1) / 2]])
        total = np.zeros(self.images[0].shape, complex)
        for image, depth in zip(self.images, self.depths):
            y, x = np.rint((depth - middle) * scale + middle).astype(int)
            inside = (y >= s) & (y < height - s) & (x >= s) & (x < width - s)
            if inside.sum() < FEWEST_EDGES / 4:
                continue
            edges = np.zeros(self.shape, np.float32)
            np.add.at(edges, (y[inside], x[inside]), 1 / inside.sum())
            total += np.conj(np.fft.rfft2(edges)) * image
        fit = np.fft.irfft2(total, self.shape) / len(self.depths)
        around = np.arange(-s, s + 1)
        return np.asarray(fit[np.ix_(around, around)], np.float32)


def pairs_apart(sample: Sample, apart: int) -> list[tuple[Frame, Frame]]:
    """Images of two or three frames of each group with the depth of a frame before or after."""
    return [
        (group[i], group[i + apart])
        for group in sample.groups
        for i in range(0, len(group), max(1, len(group) // 2))
        if 0 <= i + apart < len(group)
    ]


def registration(sample: Sample) -> Finding:
    """Where edges of depth lie; a fault if they do so with depth of every time that fits as well.

    While the camera moves one way, depth of another time lies beside the image, too: a Kinect's
    depth is 20 ms late. That is time_offset's to judge.
    """
    found = registration_apart(sample, 0)
    if found.verdict == "unknown":
        return mirrored_depth(sample) or found
    if found.verdict != "fault":
        return found
    fits = {k: EdgeFit(pairs_apart(sample, k)).best() for k in range(-REACH, REACH + 1)}
    as_good = [k for k, best in fits.items() if CLEARLY * best >= max(fits.values())]
    others = [registration_apart(sample, k) for k in as_good if k]
    if 0 in as_good:
        others.append(found)
    return next((other for other in others if other.verdict != "fault"), others[0])


MIRRORS = {
    "left to right": (slice(None), slice(None, None, -1)),
    "upside down": (slice(None, None, -1), slice(None)),
    "by half a turn": (slice(None, None, -1), slice(None, None, -1)),
}


def mirrored_depth(sample: Sample) -> Finding | None:
    """A fault if edges of depth fit only after depth is mirrored."""
    pairs = pairs_apart(sample, 0)
    plain = EdgeFit(pairs).best()
    for name, flip in MIRRORS.items():
        turned = [(c, Frame(d.stamp_ns, d.rgb, d.depth[flip])) for c, d in pairs]
        best = EdgeFit(turned).best()
        if best >= LEAST_FIT and best > 1.5 * plain:
            return Finding(
                "registration",
                "fault",
                f"edges of depth fit edges of colour {best / max(plain, 1e-3):.1f} times as well when "
                f"depth is mirrored {name}",
                "depth or colour is mirrored: write both as the sensor sees them",
                3,
            )
    return None


def registration_apart(sample: Sample, apart: int) -> Finding:
    pairs = pairs_apart(sample, apart)
    fit = EdgeFit(pairs)
    if len(fit.depths) < 4:
        return unknown("registration", "too few jumps in depth")
    maps = {scale: fit.at(scale) for scale in SCALES}
    scale = max(maps, key=lambda s: maps[s].max())
    best = float(maps[scale].max())
    rival = max(float(m.max()) for other, m in maps.items() if abs(np.log(other / scale)) > 0.1)
    if best < LEAST_FIT or best < 1.5 * rival:  # a right scale stands out
        return unknown("registration", "edges of depth and colour do not correlate anywhere")
    factor = round(pairs[0][1].depth.shape[1] / fit.shape[1])
    peak = np.unravel_index(int(maps[scale].argmax()), maps[scale].shape)
    dy, dx = (factor * (int(k) - LARGEST_SHIFT) for k in peak)
    measured = f"edges of depth fit edges of colour best when moved by ({dx}, {dy}) px"
    if apart:
        measured += f", with depth of {apart:+d} frames"
    unscaled = maps[1.0]
    s = LARGEST_SHIFT
    near = float(unscaled[s - 1 : s + 2, s - 1 : s + 2].max())
    if scale != 1 and best > 1.5 * float(unscaled.max()):
        return Finding(
            "registration",
            "fault",
            f"{measured} and enlarged to {scale:.2f} times their size",
            f"depth is not registered to colour, whose focal length is about {scale:.2f} times that "
            "of depth: record the aligned stream, or give both cameras with --camera, "
            "--depth-camera and --colour-from-depth",
            3,
        )
    if max(abs(dx), abs(dy)) >= 3 and best > CLEARLY * near:
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
    if len(ys) < FEWEST_EDGES:
        return float("nan")
    around = np.max(
        [image[ys + 2 + dy, xs + 2 + dx] for dy in (-1, 0, 1) for dx in (-1, 0, 1)], axis=0
    )
    return float(around.mean() / (image.mean() + 1e-6))


def time_scores(sample: Sample) -> NDArray[np.float64]:
    """Frames in motion x fits of their image with the depth of -REACH to REACH frames later."""
    scores: list[list[float]] = []
    for group in sample.groups:
        images = [image_edges(frame) for frame in group]
        depths = [depth_edges(frame) for frame in group]
        for i in range(REACH, len(group) - REACH):
            row = [fit_at(images[i], depths[i + k]) for k in range(-REACH, REACH + 1)]
            if np.isfinite(row).all() and max(row) > 1.03 * min(row):  # the camera moves
                scores.append(row)
    return np.array(scores).reshape(-1, 2 * REACH + 1)


def peak(values: NDArray[np.float64]) -> float:
    """Index of the largest value, between samples by a parabola."""
    k = int(values.argmax())
    if not 0 < k < len(values) - 1:
        return k
    before, at, after = values[k - 1 : k + 2]
    return float(k + 0.5 * (before - after) / (before - 2 * at + after))


def time_offset(sample: Sample) -> Finding:
    """Depth of which neighbouring frame fits the image best, where the camera moves."""
    table = time_scores(sample)
    if len(table) < FEWEST_SCORES:
        return unknown("time_offset", "too little motion or too few jumps in depth")
    mean = table.mean(axis=0)
    best = int(mean.argmax()) - REACH
    period = float(np.median(np.diff(sample.stamps_ns))) * 1e-9
    offset = (peak(mean) - REACH) * period + 1e-9 * sample.depth_delay_ns
    measured = f"depth of {best:+d} frames fits best, stamped {1000 * offset:+.0f} ms from colour"
    wins = float((table.argmax(axis=1) == best + REACH).mean())
    is_off = best != 0 and abs(offset) > LEAST_DELAY * period
    if is_off and wins > 0.5 and mean[best + REACH] > 1.01 * mean[REACH]:
        return Finding(
            "time_offset",
            "fault",
            measured,
            f"move the stamps of depth by {-offset:+.3f} s, or synchronize the streams",
            2,
        )
    return ok("time_offset", measured)

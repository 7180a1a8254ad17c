# SPDX-License-Identifier: MIT
"""Faults planted in good sequences: what the doctor is to find. Used by the tests and by
benchmarks/doctor.py."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import edvo


class Memory(edvo.Source):
    """Frames from a list."""

    def __init__(
        self, camera: edvo.Camera, frames: list[edvo.Frame], truth: edvo.Trajectory | None = None
    ) -> None:
        super().__init__()
        self.camera = camera
        self.name = self.origin = "memory"
        self.list = frames
        self.frames = len(frames)
        self.ground_truth = truth

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(self.list)


def changed(frames: list[edvo.Frame], **changes: Callable[[Any], Any]) -> list[edvo.Frame]:
    """The frames with functions applied to fields: depth=lambda depth: ..."""
    return [
        replace(frame, **{name: change(getattr(frame, name)) for name, change in changes.items()})
        for frame in frames
    ]


Plant = Callable[[Memory], Memory]


@dataclass(frozen=True)
class Fault:
    name: str  # what was done
    finding: str  # that must name it
    plant: Plant
    needs_truth: bool = False  # can be seen only against ground truth


def of_images(**changes: Callable[[Any], Any]) -> Plant:
    return lambda good: Memory(good.camera, changed(good.list, **changes), good.ground_truth)


def of_frames(change: Callable[[list[edvo.Frame]], list[edvo.Frame]]) -> Plant:
    return lambda good: Memory(good.camera, change(good.list), good.ground_truth)


def of_camera(factor: float) -> Plant:
    def plant(good: Memory) -> Memory:
        c = good.camera
        wrong = edvo.Camera(
            factor * c.fx, factor * c.fy, factor * c.cx, factor * c.cy, c.width, c.height, c.distortion
        )
        return Memory(wrong, good.list, good.ground_truth)

    return plant


def noisy(depth: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(0)
    return np.where(rng.random(depth.shape) < 0.1, depth * 1.5, depth).astype(np.float32)


def with_border(share: float, value: Any) -> Callable[[np.ndarray], np.ndarray]:
    def change(image: np.ndarray) -> np.ndarray:
        image = image.copy()
        image[:, : int(share * image.shape[1])] = value
        return image

    return change


def in_8_bits(depth: np.ndarray) -> np.ndarray:
    """Of 10 m."""
    step = np.float32(10 / 255)
    return np.asarray(np.round(depth / step) * step)


def with_far_plane(depth: np.ndarray) -> np.ndarray:
    far = np.nanquantile(depth, 0.8)
    return np.where(np.isnan(depth) | (depth > far), 13.1, depth).astype(np.float32)


def seen_wider(depth: np.ndarray) -> np.ndarray:
    """By a camera of 0.7 times the focal length."""
    height, width = depth.shape
    y = np.rint((np.arange(height) - (height - 1) / 2) / 0.7 + (height - 1) / 2).astype(int)
    x = np.rint((np.arange(width) - (width - 1) / 2) / 0.7 + (width - 1) / 2).astype(int)
    inside = ((y >= 0) & (y < height))[:, None] & ((x >= 0) & (x < width))
    seen = depth[np.ix_(np.clip(y, 0, height - 1), np.clip(x, 0, width - 1))]
    return np.where(inside, seen, np.float32(np.nan))


def late_depth(frames: list[edvo.Frame]) -> list[edvo.Frame]:
    """By two frames."""
    return [replace(a, depth=b.depth) for a, b in zip(frames[2:], frames)]


def pumped(frames: list[edvo.Frame]) -> list[edvo.Frame]:
    """A quarter darker, two frames on and two off."""
    return [
        replace(f, rgb=(f.rgb * (1.0 if i % 4 < 2 else 0.75)).astype(np.uint8))
        for i, f in enumerate(frames)
    ]


def doubled(frames: list[edvo.Frame]) -> list[edvo.Frame]:
    return [replace(f, rgb=frames[i // 2 * 2].rgb) for i, f in enumerate(frames)]


def disordered(frames: list[edvo.Frame]) -> list[edvo.Frame]:
    swapped = frames.copy()
    swapped[10], swapped[11] = swapped[11], swapped[10]
    return swapped


def in_seconds_of_milliseconds(frames: list[edvo.Frame]) -> list[edvo.Frame]:
    first = frames[0].stamp_ns
    return [replace(f, stamp_ns=first + 1000 * (f.stamp_ns - first)) for f in frames]


def mirrored(frames: list[edvo.Frame]) -> list[edvo.Frame]:
    return changed(
        frames,
        rgb=lambda image: np.ascontiguousarray(image[:, ::-1]),
        depth=lambda depth: np.ascontiguousarray(depth[:, ::-1]),
    )


def other_clock(good: Memory) -> Memory:
    truth = good.ground_truth
    assert truth is not None
    late = edvo.Trajectory(truth.stamps_ns + 3600 * 10**9, truth.values)
    return Memory(good.camera, good.list, late)


def two_poses(good: Memory) -> Memory:
    """Far apart, and around all frames."""
    truth = good.ground_truth
    assert truth is not None
    first, last = truth.stamps_ns[0] - 50 * 10**9, truth.stamps_ns[-1] + 50 * 10**9
    return Memory(good.camera, good.list, edvo.Trajectory(np.array([first, last]), truth.values[:2]))


FAULTS = [
    Fault("depth / 50", "depth_scale", of_images(depth=lambda z: z / np.float32(50))),
    Fault("depth x 10", "depth_scale", of_images(depth=lambda z: z * np.float32(10))),
    Fault("depth / 2", "scale", of_images(depth=lambda z: z / np.float32(2)), needs_truth=True),
    Fault("millimetres in floats", "depth_in_millimetres", of_images(depth=lambda z: z * np.float32(1000))),
    Fault("no depth", "depth_missing", of_images(depth=lambda z: z * np.float32(np.nan))),
    Fault("depth in 8 bits", "depth_levels", of_images(depth=in_8_bits)),
    Fault("none as far plane", "far_plane", of_images(depth=with_far_plane)),
    Fault("speckles", "speckles", of_images(depth=noisy)),
    Fault("depth of part of the image", "empty_borders", of_images(depth=with_border(0.2, np.nan))),
    Fault("depth moved by 8 px", "registration", of_images(depth=lambda z: np.roll(z, 8, axis=1))),
    Fault("depth mirrored", "registration", of_images(depth=lambda z: np.ascontiguousarray(z[:, ::-1]))),
    Fault("depth upside down", "registration", of_images(depth=lambda z: np.ascontiguousarray(z[::-1]))),
    Fault("depth of a wider view", "registration", of_images(depth=seen_wider)),
    Fault("depth two frames late", "time_offset", of_frames(late_depth)),
    Fault("camera of twice the size", "intrinsics", of_camera(2)),
    Fault("camera of half the size", "intrinsics", of_camera(0.5)),
    Fault("a black border", "dark_borders", of_images(rgb=with_border(0.06, 0))),
    Fault("five of seven frames dropped", "frame_gaps", of_frames(lambda f: [x for i, x in enumerate(f) if i % 7 < 2])),
    Fault("frames out of order", "frame_gaps", of_frames(disordered)),
    Fault("each image twice", "doubled_frames", of_frames(doubled)),
    Fault("stamps in milliseconds", "stamp_unit", of_frames(in_seconds_of_milliseconds)),
    Fault("another clock of the truth", "ground_truth_clock", other_clock),
    Fault("two poses of truth", "ground_truth_clock", two_poses),
    Fault("pumping exposure", "exposure", of_frames(pumped)),
    Fault("mirrored", "mirrored", of_frames(mirrored), needs_truth=True),
]  # fmt: skip


def findings_of(source: edvo.Source, with_motion: bool) -> set[str]:
    """Names of the faults that the doctor finds."""
    found = edvo.diagnose(source, motion_too=with_motion)
    return {finding.fault for finding in found if finding.verdict == "fault"}

# SPDX-License-Identifier: MIT
"""Faults that show in the camera's path against ground truth: a mirrored image, a wrong scale."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from edvo.doctor.finding import Finding, ok, unknown
from edvo.doctor.sample import Sample, readable
from edvo.errors import Error
from edvo.evaluation import evaluate
from edvo.odometry import Odometry
from edvo.sources.base import Source

FRAMES = 150
STEP = 15  # frames, over which motions are compared
SCALE_TOLERANCE = 0.08
LEAST_TURN = 0.02  # [rad], about a second axis
Points = NDArray[np.float64]


@dataclass(frozen=True)
class Paths:
    """Matched poses of the first frames."""

    truth: NDArray[np.float64]  # N x 4 x 4
    estimate: NDArray[np.float64]  # N x 4 x 4
    scale: float  # that fits the estimate to the truth
    error: float  # RMSE [m] without that scale
    scaled_error: float  # and with it


def track(source: Source, sample: Sample) -> Paths | str:
    """Why there is nothing to compare, if so."""
    truth = sample.ground_truth
    if truth is None:
        return "needs ground truth"
    odometry = Odometry(source.camera)
    try:
        for frame in readable(islice(source._pending(), FRAMES), []):
            odometry.process_ns(frame.stamp_ns, frame.decimals, frame.rgb, frame.depth)
        estimate = odometry.trajectory()
        plain = evaluate(truth, estimate)
        scaled = evaluate(truth, estimate, align="sim3")
    except (Error, ValueError) as error:
        return f"no path to compare: {error}"
    if len(plain.matches) < 2 * STEP:
        return "too few frames were tracked"
    return Paths(
        truth.poses[plain.matches[:, 0]],
        estimate.poses[plain.matches[:, 1]],
        scaled.scale,
        plain.ate.rmse,
        scaled.ate.rmse,
    )


def residual(truth: Points, estimate: Points, mirrored: bool) -> float:
    """RMSE [m] after the best rotation (or reflection) and translation."""
    a, b = truth - truth.mean(axis=0), estimate - estimate.mean(axis=0)
    u, s, vt = np.linalg.svd(a.T @ b)
    sign = float(np.sign(np.linalg.det(u @ vt)))
    s[-1] *= -sign if mirrored else sign
    total = (a * a).sum() + (b * b).sum() - 2 * s.sum()
    return float(np.sqrt(max(total, 0) / len(a)))


def turns_and_steps(poses: NDArray[np.float64]) -> tuple[Points, Points]:
    """Rotation vectors [rad] (to first order) and translations [m] over STEP frames, in the camera."""
    relative = np.linalg.inv(poses[:-STEP]) @ poses[STEP:]
    skew = 0.5 * (relative[:, :3, :3] - relative[:, :3, :3].transpose(0, 2, 1))
    turns = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    return turns, relative[:, :3, 3]


def handedness(paths: Paths) -> float | None:
    """Correlation of translations in axes that fit the rotations: 1, or -1 in a mirror.

    A mirror maps rotation vectors by a rotation, and translations by its negative.
    """
    turns, steps = turns_and_steps(paths.truth)
    own_turns, own_steps = turns_and_steps(paths.estimate)
    spread = np.sqrt(np.linalg.svd(turns, compute_uv=False) ** 2 / len(turns))
    if spread[1] < LEAST_TURN:
        return None
    u, _, vt = np.linalg.svd(turns.T @ own_turns)
    fit = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    turned = own_steps @ fit.T
    norm = np.sqrt((steps * steps).sum() * (turned * turned).sum())
    return float((steps * turned).sum() / norm) if norm > 0 else None


def mirrored(paths: Paths | str, sample: Sample) -> Finding:
    if isinstance(paths, str):
        return unknown("mirrored", f"residuals alone cannot tell; {paths}")
    if sample.is_reference_only:
        return unknown("mirrored", "residuals alone cannot tell; the reference is no ground truth")
    a, b = paths.truth[:, :3, 3], paths.estimate[:, :3, 3]
    spread = np.sqrt(np.linalg.svd(a - a.mean(axis=0), compute_uv=False) ** 2 / len(a))
    plain, turned = residual(a, b, False), residual(a, b, True)
    measured = f"error {1000 * plain:.0f} mm, mirrored {1000 * turned:.0f} mm"
    sign = handedness(paths)
    if sign is not None:
        measured += f"; translation against rotation {sign:+.2f}"
    # A path in a plane looks the same in a mirror: then translations against rotations decide.
    is_solid = spread[-1] > 0.01
    if (is_solid and turned < 0.5 * plain) or (sign is not None and sign < -0.5):
        return Finding(
            "mirrored",
            "fault",
            measured,
            "the image is mirrored against the ground truth: flip it, or negate fy (ICL-NUIM)",
            3,
        )
    if (is_solid and plain < 0.5 * turned) or (sign is not None and sign > 0.5):
        return ok("mirrored", measured)
    return unknown("mirrored", f"the path is flat or short; {measured}")


def scale(paths: Paths | str, sample: Sample) -> Finding:
    if isinstance(paths, str):
        return unknown("scale", paths)
    measured = f"the motion times {paths.scale:.3f} fits the ground truth best"
    if sample.is_reference_only:
        return unknown("scale", f"{measured.replace('ground truth', 'reference')}, which is no ground truth")
    is_off = abs(np.log(max(paths.scale, 1e-6))) > np.log(1 + SCALE_TOLERANCE)
    if is_off and paths.scaled_error < 0.7 * paths.error:
        units = sample.units_per_metre
        advice = f"multiply depth by {paths.scale:.3g}, or the focal length is wrong"
        if units:
            advice = f"--depth-scale {units / paths.scale:.4g} would, or the focal length is wrong"
        return Finding("scale", "fault", measured, advice, 3)
    if is_off:
        return unknown(
            "scale",
            f"{measured}, but not well: error {1000 * paths.scaled_error:.0f} mm with it, "
            f"{1000 * paths.error:.0f} mm without",
        )
    return ok("scale", measured)

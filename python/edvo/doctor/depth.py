# SPDX-License-Identifier: MIT
"""Faults of the depth images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from edvo.doctor.finding import Finding, ok, unknown
from edvo.doctor.sample import Sample

NEAREST, FARTHEST = 0.2, 8.0  # [m], of the median of a scene that such cameras see
TYPICAL = 2.0  # [m] indoors
MOST_SPECKLES = 0.04  # [1]; renderings with the noise of ICL-NUIM have 0.025
BASELINE = 0.075  # [m], of a Kinect
COARSEST_STEP = 5.5e-4  # [rad], of a sensor's disparities; a Kinect's are 2.2e-4
FINEST_UNIFORM = 0.004  # [m]; finer steps are those of the unit
USUAL_SCALES = (1000.0, 5000.0, 10000.0, 6553.5, 256.0, 100.0)  # [units/m]


def valid_depth(sample: Sample) -> NDArray[np.float32]:
    values = [frame.depth[np.isfinite(frame.depth) & (frame.depth > 0)] for frame in sample.frames()]
    return np.concatenate([v[::7] for v in values])


def depth_present(sample: Sample) -> Finding:
    shares = [float(np.mean(np.isfinite(frame.depth) & (frame.depth > 0))) for frame in sample.frames()]
    share = float(np.median(shares))
    if share < 0.2:
        return Finding(
            "depth_missing",
            "fault",
            f"{100 * share:.0f} % of the pixels have depth (median of the frames)",
            "less than a fifth: check the sensor's range, sunlight, or whether depth was recorded",
            3,
        )
    return ok("depth_missing", f"{100 * share:.0f} % of the pixels have depth")


def depth_scale(sample: Sample) -> Finding:
    values = valid_depth(sample)
    if values.size == 0:
        return unknown("depth_scale", "no depth")
    median = float(np.median(values))
    measured = f"median depth {median:.3g} m"
    if median > 100 and sample.units_per_metre is None:
        return Finding(
            "depth_in_millimetres",
            "fault",
            measured,
            "the floats are millimetres: divide by 1000 (--depth-scale 1000)",
            3,
        )
    if NEAREST <= median <= FARTHEST:
        return ok("depth_scale", measured)
    advice = "outside 0.2 to 8 m: check the units per metre"
    if sample.units_per_metre is not None:
        raw = median * sample.units_per_metre
        likely = min(USUAL_SCALES, key=lambda scale: abs(np.log(raw / scale / TYPICAL)))
        advice = f"--depth-scale {likely:g} would make it {raw / likely:.3g} m"
    return Finding("depth_scale", "fault", measured, advice, 3)


def depth_levels(sample: Sample) -> Finding:
    """8-bit, colour-mapped or JPEG depth has few levels."""
    if any(file.suffix.lower() in (".jpg", ".jpeg") for file in sample.depth_files):
        return Finding(
            "depth_levels",
            "fault",
            f"depth is stored as JPEG ({sample.depth_files[0].name})",
            "JPEG blends depths at edges: record 16-bit PNG",
            3,
        )
    counts, pictures = [], []
    for frame in sample.frames():
        levels = np.unique(frame.depth[np.isfinite(frame.depth) & (frame.depth > 0)])
        if np.count_nonzero(np.isfinite(frame.depth)) > 1000 and len(levels) > 1:
            counts.append(len(levels))
            pictures.append(is_picture(levels))
    if not counts:
        return unknown("depth_levels", "no depth" if valid_depth(sample).size == 0 else "one value")
    median = int(np.median(counts))
    measured = f"{median} different depths in an image"
    if median <= 256 and np.mean(pictures) > 0.5:
        return Finding(
            "depth_levels",
            "fault",
            measured,
            "8-bit or colour-mapped depth, a picture of depth: record the sensor's 16-bit images",
            3,
        )
    return ok("depth_levels", measured)


def is_picture(levels: NDArray[np.float32]) -> bool:
    """Depths of one image, sorted: their distances are not those of a sensor's disparities.

    Stereo and structured light have few depths too, but their distances are fine and grow with the
    square of depth; those of 8-bit depth are coarse, or alike near and far.
    """
    near, gaps = levels[:-1], np.diff(levels)
    if float(np.median(gaps / near**2)) * BASELINE > COARSEST_STEP:
        return True
    low, high = np.quantile(gaps, [0.1, 0.9])
    is_wide = float(levels[-1]) > 1.5 * float(levels[0])
    return bool(is_wide and low > FINEST_UNIFORM and high < 1.5 * low)


def far_plane(sample: Sample) -> Finding:
    """Pixels without a measurement that carry a number: a shell around the scene."""
    shares, places = [], []
    for frame in sample.frames():
        values = frame.depth[np.isfinite(frame.depth) & (frame.depth > 0)]
        if values.size < 1000:
            continue
        largest = float(values.max())
        at_end = values >= largest * 0.9999
        beside = (values >= largest * 0.97) & ~at_end
        # A real wall at the end of the range spreads over its noise and its slope.
        shares.append(float(at_end.mean() - beside.mean()))
        places.append(largest)
    if not shares:
        return unknown("far_plane", "no depth")
    share, place = float(np.median(shares)), float(np.median(places))
    same = float(np.std(places)) < 1e-3 * place
    measured = f"{100 * max(share, 0):.1f} % of the depths are the largest one, {place:.3g} m"
    if share > 0.01 and same:
        return Finding(
            "far_plane",
            "fault",
            measured,
            "pixels without a measurement carry a number: set them to 0 before recording",
            2,
        )
    return ok("far_plane", measured)


def speckles(sample: Sample) -> Finding:
    """Pixels unlike all four neighbours."""
    shares = []
    for frame in sample.frames():
        z = frame.depth
        middle = z[1:-1, 1:-1]
        neighbours = np.stack([z[:-2, 1:-1], z[2:, 1:-1], z[1:-1, :-2], z[1:-1, 2:]])
        with np.errstate(invalid="ignore"):
            apart = np.abs(neighbours - middle) > 0.05 * middle
            known = np.isfinite(neighbours).sum(axis=0) >= 3
            alone = known & (apart | ~np.isfinite(neighbours)).all(axis=0) & (middle > 0)
            shares.append(float(alone.sum() / max(1, int((known & (middle > 0)).sum()))))
    share = float(np.median(shares))
    measured = f"{100 * share:.2f} % of the depths are unlike all their neighbours"
    if share > MOST_SPECKLES:
        return Finding(
            "speckles",
            "fault",
            measured,
            "flying pixels: use the sensor's spatial filter or a median of 3 x 3 pixels",
            1,
        )
    return ok("speckles", measured)


Borders = tuple[int, int, int, int]  # left, right [columns], top, bottom [rows]


def borders_of(mask: NDArray[np.bool_]) -> Borders:
    """Beside what is true; something must be."""
    rows, columns = np.asarray(mask.any(axis=1)), np.asarray(mask.any(axis=0))
    return (
        int(np.argmax(columns)), int(np.argmax(columns[::-1])),
        int(np.argmax(rows)), int(np.argmax(rows[::-1])),
    )  # fmt: skip


def unseen_borders(sample: Sample, metres: float) -> Borders:
    """Where the depth camera, of which depth is registered here, does not look."""
    if sample.registration is None:
        return 0, 0, 0, 0
    camera = sample.registration.depth
    wall = np.full((camera.height, camera.width), metres, np.float32)
    seen = np.nan_to_num(sample.registration(wall)) > 0
    return borders_of(seen) if seen.any() else (0, 0, 0, 0)


def empty_borders(sample: Sample) -> Finding:
    ever: NDArray[np.bool_] = np.zeros(next(iter(sample.frames())).depth.shape, bool)
    distances = []
    for frame in sample.frames():
        has_depth = np.isfinite(frame.depth) & (frame.depth > 0)
        if frame.depth.shape == ever.shape and has_depth.any():
            ever = np.asarray(ever | has_depth)
            distances.append(float(np.median(frame.depth[has_depth])))
    if not ever.any():
        return unknown("empty_borders", "no depth")
    height, width = ever.shape
    found = borders_of(ever)
    left, right, top, bottom = found
    measured = f"never depth in {left} columns left, {right} right, {top} rows above, {bottom} below"
    unseen = unseen_borders(sample, float(np.median(distances)))
    if any(unseen):
        measured += ", of which the depth camera does not see {}, {}, {}, {}".format(*unseen)
    left, right, top, bottom = (max(0, a - b) for a, b in zip(found, unseen))
    if max(left, right) > 0.08 * width or max(top, bottom) > 0.08 * height:
        return Finding(
            "empty_borders",
            "fault",
            measured,
            "depth covers part of the image: is it of another size, or another field of view?",
            1,
        )
    return ok("empty_borders", measured)

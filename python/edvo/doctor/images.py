# SPDX-License-Identifier: MIT
"""Faults of the colour images, of time and of the camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from edvo.doctor.finding import Finding, ok, unknown
from edvo.doctor.sample import Gray, Sample, to_gray

SHORT = 100  # frames

def intrinsics(sample: Sample) -> Finding:
    camera = sample.camera
    height, width = next(iter(sample.frames())).rgb.shape[:2]
    off_x = (camera.cx - (width - 1) / 2) / width
    off_y = (camera.cy - (height - 1) / 2) / height
    view = float(np.degrees(2 * np.arctan(width / 2 / abs(camera.fx))))
    measured = (
        f"principal point {100 * off_x:+.0f} % and {100 * off_y:+.0f} % off the middle, "
        f"{view:.0f} deg wide"
    )
    if max(abs(off_x), abs(off_y)) > 0.1 or not 30 <= view <= 110:
        return Finding(
            "intrinsics",
            "fault",
            measured,
            f"the calibration seems to be of images of another size than {width} x {height}: "
            "scale it, or give the right one with --camera",
            3,
        )
    ratio = abs(camera.fy / camera.fx)
    if not 0.9 <= ratio <= 1.1:
        return Finding(
            "intrinsics",
            "fault",
            f"fy / fx is {ratio:.2f}",
            "pixels are not square: were the images resized unequally?",
            2,
        )
    return ok("intrinsics", measured)


def frame_gaps(sample: Sample) -> Finding:
    stamps = sample.stamps_ns
    if len(stamps) < 4:
        return unknown("frame_gaps", "too few frames")
    steps = np.diff(stamps)
    if (steps <= 0).any():
        return Finding(
            "frame_gaps",
            "fault",
            f"{int((steps <= 0).sum())} frames not later than the one before",
            "sort the frames by their stamps",
            3,
        )
    period = float(np.median(steps))
    gaps = int((steps > 1.5 * period).sum())
    longest = float(steps.max()) * 1e-9
    measured = f"{gaps} of {len(steps)} gaps longer than 1.5 periods, the longest {longest:.2f} s"
    if period < 1e6:
        return Finding(
            "stamp_unit",
            "fault",
            f"{period:.3g} ns from frame to frame",
            "the stamps are not seconds: divide them",
            3,
        )
    if period > 2e9:
        return Finding(
            "stamp_unit",
            "fault",
            f"{period * 1e-9:.3g} s from frame to frame",
            "stamps in milliseconds or nanoseconds? They must be seconds",
            3,
        )
    # Recorders drop single frames while they start: of a short recording these are a large share.
    most = 0.08 if len(steps) > SHORT else 0.3
    if gaps > most * len(steps) or longest > 1.0:
        return Finding(
            "frame_gaps",
            "fault",
            measured,
            "frames were dropped: record with less load, or to a faster disk",
            2,
        )
    return ok("frame_gaps", measured)


def doubled_frames(sample: Sample) -> Finding:
    equal, pairs = 0, 0
    for a, b in sample.pairs():
        pairs += 1
        equal += bool(np.array_equal(a.rgb[::4, ::4], b.rgb[::4, ::4]))
    if pairs == 0:
        return unknown("doubled_frames", "too few frames")
    measured = f"{equal} of {pairs} images equal the one before"
    if equal > 0.05 * pairs:
        return Finding(
            "doubled_frames",
            "fault",
            measured,
            "the recorder repeats images: leave them out, or lower its frame rate",
            2,
        )
    return ok("doubled_frames", measured)


def small(gray: Gray) -> Gray:
    height, width = gray.shape[0] // 16 * 16, gray.shape[1] // 16 * 16
    blocks = gray[:height, :width].reshape(height // 16, 16, width // 16, 16)
    return np.asarray(blocks.mean(axis=(1, 3)))


def exposure(sample: Sample) -> Finding:
    gains = []
    for a, b in sample.pairs():
        x, y = small(to_gray(a.rgb)), small(to_gray(b.rgb))
        fair = (x > 15) & (x < 240) & (y > 15) & (y < 240)
        if fair.sum() >= 30:
            gains.append(float(np.median(y[fair] / x[fair])))
    if not gains:
        return unknown("exposure", "too dark or too bright everywhere")
    changes = np.abs(np.log(gains))
    share = float((changes > np.log(1.1)).mean())
    measured = f"brightness changes by up to {100 * (np.exp(changes.max()) - 1):.0f} % a frame"
    if share > 0.1:
        return Finding(
            "exposure",
            "fault",
            f"{measured}, by more than 10 % in {100 * share:.0f} % of the frames",
            "fix the camera's exposure and gain (and its white balance)",
            1,
        )
    return ok("exposure", measured)


def sharpness(gray: Gray) -> float:
    laplacian = (
        gray[1:-1, 2:] + gray[1:-1, :-2] + gray[2:, 1:-1] + gray[:-2, 1:-1] - 4 * gray[1:-1, 1:-1]
    )
    return float(np.mean(np.abs(laplacian)))


def blur(sample: Sample) -> Finding:
    """Frames much less sharp than their neighbours: motion blur."""
    blurred, count = 0, 0
    for group in sample.groups:
        values = np.array([sharpness(to_gray(frame.rgb)) for frame in group])
        if len(values) < 4:
            continue
        count += len(values)
        blurred += int((values < 0.5 * np.max(values)).sum())
    if count == 0:
        return unknown("blur", "too few frames")
    share = blurred / count
    measured = f"{100 * share:.0f} % of the images are half as sharp as a neighbour"
    if share > 0.3:
        return Finding(
            "blur", "fault", measured, "move slower, or shorten the exposure (more light)", 1
        )
    return ok("blur", measured)


def dark_borders(sample: Sample) -> Finding:
    """Rectified images have black borders, which are no scene."""
    brightest = np.max([to_gray(frame.rgb) for frame in sample.frames()][::3], axis=0)
    dark = brightest < 3
    height, width = dark.shape
    rows, columns = ~dark.all(axis=1), ~dark.all(axis=0)
    if not rows.any():
        return Finding("dark_borders", "fault", "all images are black", "is the lens covered?", 3)
    widths = [
        np.argmax(columns) / width,
        np.argmax(columns[::-1]) / width,
        np.argmax(rows) / height,
        np.argmax(rows[::-1]) / height,
    ]
    widest = float(max(widths))
    corners = float(dark.mean())
    measured = f"{100 * corners:.1f} % of the pixels are always black"
    if widest > 0.02 or corners > 0.03:
        return Finding(
            "dark_borders",
            "fault",
            measured,
            "borders without an image (rectified?): crop them, and take their size off cx and cy",
            1,
        )
    return ok("dark_borders", measured)


LONGEST_GAP = 3 * 10**9  # [ns], of poses that one can be interpolated between


def covered_share(stamps_ns: NDArray[np.int64], truth_ns: NDArray[np.int64]) -> float:
    """Of stamps: those between two poses of the truth that are not far apart."""
    after = np.searchsorted(truth_ns, stamps_ns)
    inside = (after > 0) & (after < len(truth_ns))
    at = np.clip(after, 1, max(1, len(truth_ns) - 1))
    gaps = truth_ns[np.minimum(at, len(truth_ns) - 1)] - truth_ns[at - 1]
    return float((inside & (gaps <= LONGEST_GAP) | np.isin(stamps_ns, truth_ns)).mean())


def ground_truth_clock(sample: Sample) -> Finding:
    truth = sample.ground_truth
    if truth is None or len(truth) == 0:
        return unknown("ground_truth_clock", "no ground truth")
    first, last = int(sample.stamps_ns[0]), int(sample.stamps_ns[-1])
    begin, end = int(truth.stamps_ns[0]), int(truth.stamps_ns[-1])
    overlap = covered_share(sample.stamps_ns, truth.stamps_ns)
    name = "the reference" if sample.is_reference_only else "ground truth"
    measured = f"{name} covers {100 * max(overlap, 0):.0f} % of the frames' time"
    if overlap > 0.3:
        return ok("ground_truth_clock", measured)
    if min(last, end) - max(first, begin) > 0.3 * (last - first):
        advice = f"it has {len(truth)} poses with gaps between them, where nothing can be compared"
        return Finding("ground_truth_clock", "fault", measured, advice, 1)
    ratio = (begin + end) / max(1, first + last)
    advice = f"its clock is {(begin - first) * 1e-9:+.3f} s off: edvo eval --offset"
    for factor, unit in ((1e-9, "too small"), (1e3, "milliseconds"), (1e6, "microseconds")):
        if 0.3 * factor < ratio < 3 * factor:
            advice = f"its stamps are {unit if factor > 1 else 'of another unit'}, not seconds"
    return Finding("ground_truth_clock", "fault", measured, advice, 2)

# SPDX-License-Identifier: MIT
"""Is it my input? Measures the usual faults of RGB-D recordings and says how to mend them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from edvo.doctor import depth, edges, images, motion
from edvo.doctor.finding import Finding
from edvo.doctor.sample import QUICK, THOROUGH, take
from edvo.sources import Source, open_source

__all__ = ["Finding", "diagnose", "gravest"]

MOST = 3  # findings that a run prints
GRAVE = 2  # and from which gravity

TESTS = (
    depth.depth_present,
    depth.depth_scale,
    depth.depth_levels,
    depth.far_plane,
    depth.speckles,
    depth.empty_borders,
    edges.registration,
    edges.time_offset,
    images.intrinsics,
    images.frame_gaps,
    images.doubled_frames,
    images.exposure,
    images.blur,
    images.dark_borders,
    images.ground_truth_clock,
)


def diagnose(
    source: Source | str | Path, *, motion_too: bool = True, quick: bool = False, **options: Any
) -> list[Finding]:
    """All findings, the gravest first; those with verdict "fault" are faults.

    ``source``: a ``Source`` or a path with the options of ``open_source``. ``motion_too``: tracks
    the first frames and compares the path with ground truth, if there is any. ``quick``: looks at
    24 frames instead of 64.
    """
    opened = source if isinstance(source, Source) else open_source(source, **options)
    sample = take(opened, QUICK if quick else THOROUGH)
    findings = [test(sample) for test in TESTS]
    if sample.unreadable:
        findings.append(
            Finding(
                "unreadable",
                "fault",
                f"{len(sample.unreadable)} images cannot be read, the first: {sample.unreadable[0]}",
                "record or unpack them again",
                2,
            )
        )
    if motion_too:
        paths = motion.track(opened, sample)
        findings += [motion.mirrored(paths, sample), motion.scale(paths, sample)]
    return sorted(findings, key=lambda finding: -finding.gravity)


def gravest(source: Source) -> list[Finding]:
    """What a run prints before it begins: at most three grave faults.

    A quick look, and a thorough one only if that finds something. Of a live source nothing, as its
    frames do not come again. Never raises: the run goes on.
    """
    if source.is_live:
        return []
    faults: list[Finding] = []
    try:
        for quick in (True, False):
            findings = diagnose(source, motion_too=False, quick=quick)
            faults = [f for f in findings if f.verdict == "fault" and f.gravity >= GRAVE]
            if not faults:
                break
    except Exception:  # noqa: BLE001: what is wrong with the source is said by the run itself
        return []
    return faults[:MOST]

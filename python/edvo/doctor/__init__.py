# SPDX-License-Identifier: MIT
"""Is it my input? Measures the usual faults of RGB-D recordings and says how to mend them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from edvo.doctor import depth, edges, images, motion
from edvo.doctor.finding import Finding
from edvo.doctor.sample import take
from edvo.sources import Source, open_source

__all__ = ["Finding", "diagnose"]

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


def diagnose(source: Source | str | Path, *, motion_too: bool = True, **options: Any) -> list[Finding]:
    """All findings, the gravest first; those with verdict "fault" are faults.

    ``source``: a ``Source`` or a path with the options of ``open_source``. ``motion_too``: tracks
    the first frames and compares the path with ground truth, if there is any.
    """
    opened = source if isinstance(source, Source) else open_source(source, **options)
    sample = take(opened)
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
        findings += [motion.mirrored(paths), motion.scale(paths, sample)]
    return sorted(findings, key=lambda finding: -finding.gravity)

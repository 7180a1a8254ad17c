# SPDX-License-Identifier: MIT
"""The frames that the doctor looks at, and what it computes of them once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error
from edvo.registration import DepthRegistration
from edvo.sources.bag import BagSource
from edvo.sources.base import Arrays, Frame, Source
from edvo.sources.folder import FolderSource
from edvo.sources.listed import ListedSource
from edvo.trajectory import Trajectory

Gray = NDArray[np.float32]


@dataclass(frozen=True)
class Size:
    groups: int  # runs of consecutive frames, spread over the sequence
    length: int  # frames of each
    streamed: int  # frames of a recording that can only be read from its start


THOROUGH = Size(groups=8, length=8, streamed=90)
QUICK = Size(groups=6, length=4, streamed=24)


def to_gray(rgb: NDArray[np.uint8]) -> Gray:
    return np.asarray(rgb.astype(np.float32) @ np.array([0.299, 0.587, 0.114], np.float32))


@dataclass
class Sample:
    camera: Camera
    groups: list[list[Frame]]  # consecutive frames each
    stamps_ns: NDArray[np.int64]  # of all frames, or of those read
    ground_truth: Trajectory | None
    is_reference_only: bool = False  # that is another estimate
    depth_delay_ns: int = 0  # median of depth's stamps less colour's
    depth_files: list[Path] = field(default_factory=list)
    unreadable: list[str] = field(default_factory=list)
    missing: int = 0  # frames of the list whose images are not there
    units_per_metre: float | None = None  # None = not known here
    registration: DepthRegistration | None = None  # of depth of a camera of its own

    def frames(self) -> Iterator[Frame]:
        for group in self.groups:
            yield from group

    def pairs(self) -> Iterator[tuple[Frame, Frame]]:
        for group in self.groups:
            yield from zip(group, group[1:])


def starts(count: int, size: Size) -> list[int]:
    if count <= size.groups * size.length:
        return list(range(0, count, size.length))
    return [round(i * (count - size.length) / (size.groups - 1)) for i in range(size.groups)]


def readable(
    pending: Iterable[tuple[int, int, Callable[[], Arrays]]], unreadable: list[str]
) -> Iterator[Frame]:
    """What can be read of ``Source._pending()``; of the rest the reasons are appended."""
    for stamp_ns, decimals, load in pending:
        try:
            yield Frame(stamp_ns, *load(), decimals)
        except (Error, TypeError, ValueError) as error:
            unreadable.append(str(error))


def take(source: Source, size: Size = THOROUGH) -> Sample:
    unreadable: list[str] = []
    sample = Sample(
        source.camera, [], np.zeros(0, np.int64), source.ground_truth, source.is_reference_only
    )
    sample.depth_delay_ns = source.depth_delay_ns
    own = getattr(source, "registration", None) or getattr(source, "_registration", None)
    sample.registration = own
    if isinstance(source, (FolderSource, ListedSource)):
        for start in starts(len(source), size):
            group: list[Frame] = []
            for index in range(start, min(start + size.length, len(source))):
                try:
                    group.append(source[index])
                except Error as error:
                    unreadable.append(str(error))
            sample.groups.append(group)
    else:
        pending = list(islice(source._pending(), size.streamed))
        frames = list(readable(pending, unreadable))
        sample.groups = [
            frames[i : i + size.length] for i in range(0, len(frames), size.length)
        ]
        sample.stamps_ns = np.array([stamp for stamp, _, _ in pending], np.int64)
    if isinstance(source, FolderSource):
        stamps = [source.stamps_ns(i) for i in range(len(source))]
        sample.stamps_ns = np.array([colour for colour, _ in stamps], np.int64)
        sample.depth_delay_ns = int(np.median([depth - colour for colour, depth in stamps]))
        sample.depth_files = [source.files(0)[1]]
        sample.units_per_metre = source.units_per_metre
    elif isinstance(source, BagSource):
        sample.stamps_ns = source.stamps_ns
        sample.units_per_metre = source.units_per_metre
    elif isinstance(source, ListedSource):
        sample.stamps_ns = np.array([entry.stamp_ns for entry in source.entries], np.int64)
    sample.unreadable = unreadable
    sample.groups = [group for group in sample.groups if group]
    if not sample.groups:
        reason = unreadable[0] if unreadable else "it has no frames"
        raise Error(f"{source.origin}: no frame can be read: {reason}", code=3)
    return sample

# SPDX-License-Identifier: MIT
"""Where frames come from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Frame:
    """One colour image and its registered depth, as the sensor has them (not undistorted)."""

    stamp_ns: int  # of the colour image [ns]
    rgb: NDArray[np.uint8]  # H x W x 3, RGB
    depth: NDArray[np.float32]  # H x W, [m], NaN or 0 = none
    decimals: int = 9  # digits of a second that files keep


class Source(ABC):
    """A sequence of frames in the order of their stamps; iterate over it.

    Subclass it for a sensor or a format of your own: set the attributes and write ``__iter__``.
    """

    name: str = "sequence"  # short
    origin: str = ""  # where frames are read from, and as what
    camera: Camera
    camera_origin: str = "as given"
    frames: int | None = None  # None = not known
    ground_truth: Trajectory | None = None
    notes: list[str]  # what was found and chosen, and why
    warnings: list[str]  # what looks wrong but stops nothing

    def __init__(self) -> None:
        self.notes = []
        self.warnings = []

    @abstractmethod
    def __iter__(self) -> Iterator[Frame]:
        """Yields the frames. May be called again: then it begins anew (a live camera goes on)."""


def metres(depth: NDArray[Any], units_per_metre: float) -> NDArray[np.float32]:
    """Depth in units as metres; 0 and, of 16-bit images, 65535 become NaN."""
    values = depth.astype(np.float32) / np.float32(units_per_metre)
    values[~(values > 0) | ~np.isfinite(values)] = np.nan
    if depth.dtype == np.uint16:
        values[depth == 65535] = np.nan
    return values

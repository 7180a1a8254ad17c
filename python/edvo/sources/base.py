# SPDX-License-Identifier: MIT
"""Where frames come from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera, as_tuple
from edvo.errors import Error
from edvo.images import check_depth, check_rgb
from edvo.sources.waiting import SILENCE, awaited
from edvo.trajectory import Trajectory

Arrays = tuple[NDArray[np.uint8], NDArray[np.float32]]


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
    What ``__iter__`` raises ends a run; a frame whose arrays do not fit the camera is skipped. A
    frame is copied before the next one is asked for: the same arrays may be filled again.
    """

    name: str = "sequence"  # short, also names the run's folder
    origin: str = ""  # where frames are read from, and as what
    camera: Camera
    camera_origin: str = "as given"
    depth_origin: str = "in metres"
    depth_delay_ns: int = 0  # median of depth's stamps less colour's
    frames: int | None = None  # None = not known
    is_live: bool = False  # a sensor that does not wait: who is late gets the newest frame
    ground_truth: Trajectory | None = None
    ground_truth_origin: str = "ground truth"
    is_reference_only: bool = False  # ground_truth is another estimate: compared with, not believed
    notes: list[str]  # what was found and chosen, and why
    warnings: list[str]  # what looks wrong but stops nothing

    def __init__(self) -> None:
        self.notes = []
        self.warnings = []

    @abstractmethod
    def __iter__(self) -> Iterator[Frame]:
        """Yields the frames. May be called again: then it begins anew (a live camera goes on)."""

    def stop(self) -> None:
        """Of a live source: ends the wait for a frame. Called by another thread."""

    def _native(self) -> Any:
        """A ``_core.FolderSource``, where C++ reads the frames without Python."""
        return None

    def _pending(self) -> Iterator[tuple[int, int, Callable[[], Arrays]]]:
        """Stamp [ns], decimals and what loads the arrays of each frame."""
        for frame in self:
            if not isinstance(frame, Frame):
                raise TypeError(
                    f"{type(self).__name__}: __iter__ gave {type(frame).__name__}, but edvo.Frame is "
                    "expected"
                )
            yield frame.stamp_ns, frame.decimals, self._loader(lambda frame=frame: frame)  # type: ignore[misc]

    def _awaited(
        self, should_stop: Callable[[], bool]
    ) -> Iterator[tuple[int, int, Callable[[], Arrays]]]:
        """``_pending``, but a frame that does not come is waited for only until this says so, and
        one of a live source ``SILENCE``."""
        return awaited(self._pending(), should_stop, self.name, self._patience())

    def _patience(self) -> float | None:
        return SILENCE if self.is_live else None

    def _loader(self, read: Callable[[], Frame]) -> Callable[[], Arrays]:
        def load() -> Arrays:
            frame = read()
            width, height = self.camera.width, self.camera.height
            return check_rgb(frame.rgb, width, height), check_metres(frame.depth, width, height)

        return load

    def _describe(self) -> dict[str, Any]:
        truth = self.ground_truth
        return {
            "name": self.name,
            "origin": self.origin or self.name,
            "camera": as_tuple(self.camera),
            "camera_origin": self.camera_origin,
            "depth_scale": 0.0,
            "depth_origin": self.depth_origin,
            "is_depth_assumed": False,
            "frames": self.frames,
            "is_live": self.is_live,
            "ground_truth": None if truth is None or len(truth) == 0 else truth._arrays(),
            "ground_truth_origin": self.ground_truth_origin,
            "notes": list(self.notes),
            "warnings": list(self.warnings),
        }


def require_size(frame: Frame, camera: Camera, what: object) -> Frame:
    """Raises edvo.Error where an image in a file has another size than those before it."""
    size = (camera.height, camera.width)
    for image in (frame.rgb, frame.depth):
        if image.shape[:2] != size:
            raise Error(
                f"{what}: image of {image.shape[1]} x {image.shape[0]} px, but the camera has "
                f"{size[1]} x {size[0]}",
                code=3,
            )
    return frame


def check_metres(depth: Any, width: int, height: int) -> NDArray[np.float32]:
    image = check_depth(depth, width, height)
    if image.dtype != np.float32:
        raise TypeError("depth: a source gives float32 in metres (edvo.sources.metres converts)")
    return image


def metres(depth: NDArray[Any], units_per_metre: float) -> NDArray[np.float32]:
    """Depth in units as metres; 0 and, of 16-bit images, 65535 become NaN."""
    values = depth.astype(np.float32) / np.float32(units_per_metre)
    values[~(values > 0) | ~np.isfinite(values)] = np.nan
    if depth.dtype == np.uint16:
        values[depth == 65535] = np.nan
    return values

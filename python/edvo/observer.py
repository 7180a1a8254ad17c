# SPDX-License-Identifier: MIT
"""Who watches a run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera, from_tuple
from edvo.odometry import FrameResult, result_from
from edvo.trajectory import Trajectory

if TYPE_CHECKING:
    from edvo.runner import Run


@dataclass(frozen=True, eq=False)
class SourceInfo:
    """What a source knows before its first frame."""

    name: str
    origin: str  # where frames are read from, and as what
    camera: Camera
    frames: int | None  # None = not known
    ground_truth: Trajectory | None
    notes: list[str]
    warnings: list[str]


class Image(Protocol):
    """The image that a result was made from; its arrays are made when asked for.

    ``rgb`` and ``depth`` belong together, and ``recorded_rgb`` and ``recorded_depth`` do."""

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """H x W x 3, RGB, undistorted: of a pinhole with the camera's matrix"""

    @property
    def depth(self) -> NDArray[np.float32]:
        """H x W, undistorted [m], NaN = none"""

    @property
    def recorded_rgb(self) -> NDArray[np.uint8]:
        """H x W x 3, RGB, as the camera has it"""

    @property
    def recorded_depth(self) -> NDArray[np.float32]:
        """H x W, as the camera has it [m], NaN = none"""


@dataclass(frozen=True, eq=False)
class KeyframePose:
    """Where a keyframe is, as known now."""

    id: int
    stamp_ns: int
    segment: int
    pose: NDArray[np.float64]  # 4 x 4, world_from_camera


@dataclass(frozen=True, eq=False)
class Keyframe(KeyframePose):
    """A new keyframe with what it was made from, undistorted."""

    rgb: NDArray[np.uint8]  # H x W x 3
    depth: NDArray[np.float32]  # H x W, [m], NaN = none
    points: NDArray[np.float32]  # N x 3, selected pixels in its camera [m]
    colours: NDArray[np.uint8]  # N x 3, RGB


class Observer:
    """Watches a run: subclass it and override what is of interest.

    A run goes on when a method returns, so that slow ones belong in a thread of their own. Nothing
    that an observer does changes a result; what it raises ends the run, which keeps its results so
    far: it is the cause of the ``edvo.Error`` of ``edvo.run``.
    """

    def begin(self, source: SourceInfo) -> None:
        """Before the first frame."""

    def frame(self, result: FrameResult, image: Image) -> None:
        """A frame was processed: tracked or lost."""

    def skipped(self, index: int, stamp: str, reason: str) -> None:
        """A frame could not be read or used."""

    def keyframe(self, keyframe: Keyframe) -> None:
        """A frame became a keyframe."""

    def map_changed(self, keyframes: list[KeyframePose]) -> None:
        """Keyframes came or moved: all of them, by id."""

    def warning(self, text: str) -> None:
        """Something looks wrong but stops nothing."""

    def end(self, run: Run) -> None:
        """After the last frame, also of a run that was stopped or ended in an error."""

    # What C++ calls; keyframes and maps only for those who override them, as they cost time.

    def _wants_keyframes(self) -> bool:
        return type(self).keyframe is not Observer.keyframe

    def _wants_map(self) -> bool:
        return type(self).map_changed is not Observer.map_changed

    def _begin(self, fields: dict[str, Any]) -> None:
        self.begin(source_info(fields))

    def _frame(self, fields: dict[str, Any], image: Image) -> None:
        self.frame(result_from(fields), image)

    def _keyframe(self, fields: dict[str, Any]) -> None:
        self.keyframe(Keyframe(**fields))

    def _map_changed(self, keyframes: list[dict[str, Any]]) -> None:
        self.map_changed([KeyframePose(**fields) for fields in keyframes])

    def _end(self, fields: dict[str, Any]) -> None:
        from edvo.runner import run_from

        self.end(run_from(fields))


def require_observers(observers: object) -> list[Observer]:
    """Of an iterable; TypeError unless all are instances of ``Observer``."""
    if not isinstance(observers, Iterable):
        raise TypeError(f"observers: a list is expected, got {type(observers).__name__}")
    given = list(observers)
    for observer in given:
        if isinstance(observer, type):
            raise TypeError(
                f"observers: {observer.__name__} is a class; give an instance, "
                f"{observer.__name__}()"
            )
        if not isinstance(observer, Observer):
            raise TypeError(
                f"observers: instances of edvo.Observer are expected, got {type(observer).__name__}"
            )
    return given


def source_info(fields: dict[str, Any]) -> SourceInfo:
    truth = fields["ground_truth"]
    return SourceInfo(
        name=fields["name"],
        origin=fields["origin"],
        camera=from_tuple(fields["camera"]),
        frames=fields["frames"],
        ground_truth=None if truth is None else Trajectory._from_arrays(truth),
        notes=fields["notes"],
        warnings=fields["warnings"],
    )

# SPDX-License-Identifier: MIT
"""Options, the odometry and what it says about each frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.camera import Camera, as_tuple
from edvo.detector import EdgeDetector, require_detector
from edvo.errors import Error
from edvo.images import Mask, check_depth, check_rgb, visible_pixels
from edvo.stamp import Seconds, nanoseconds
from edvo.trajectory import Trajectory

Value = bool | int | float | str


def spelled(name: str, value: Value) -> str:
    """One option as the program's ``--set`` takes it."""
    if isinstance(value, bool):
        return f"{name}={'true' if value else 'false'}"
    if isinstance(value, str):
        return f'{name}="{value}"'
    return f"{name}={value!r}"


@dataclass(frozen=True, init=False)
class Options:
    """Options of the odometry: a method's, and what differs from them.

    ``Options("canny+corner", **{"keyframes.period": 30})``; ``edvo config`` prints every option
    with its meaning and range. Raises ``edvo.Error`` (code 4) for unknown names and values out of
    range.
    """

    method: str
    changes: tuple[str, ...]  # "group.field=value"
    toml: str  # all options, as edvo run --config reads them

    def __init__(self, method: str = _core.default_method, **options: Value) -> None:
        changes = tuple(spelled(name, value) for name, value in options.items())
        object.__setattr__(self, "method", method)
        object.__setattr__(self, "changes", changes)
        object.__setattr__(self, "toml", _core.options_toml(method, list(changes)))


@dataclass(frozen=True)
class LevelStats:
    """The alignment at one level of the image pyramid."""

    level: int  # 0 = full size
    iterations: int
    points: int  # residuals
    cost: float  # mean robust cost at the end [residual sigmas squared]
    converged: bool


@dataclass(frozen=True, eq=False)
class FrameResult:
    """What the odometry says about one frame."""

    stamp_ns: int
    status: str  # "first", "tracked", "lost", "restarted" or "relocalized"
    loss_cause: str  # why it is lost; "none" if it is not
    segment: int  # poses of different segments do not belong together
    pose: NDArray[np.float64]  # 4 x 4, world_from_camera as known now; if lost, the last good one
    keyframe: int  # that the frame was aligned to, -1 = there is none yet
    keyframe_from_camera: NDArray[np.float64]  # 4 x 4
    # 6 x 6, inverse covariance of xi in keyframe_from_camera * exp(xi), xi = (rho [m], phi [rad])
    information: NDArray[np.float64]
    points: int  # residuals of the finest level
    inlier_ratio: float  # [0..1] of the points in view
    overlap: float  # [0..1] of the keyframe's points in view
    rms: float  # photometric, of inliers [grey levels]
    readout_seconds: float  # of a rolling shutter as estimated so far [s], 0 = global
    ego_share: float  # [0..1] of the image: moves along with the camera, and is left out
    new_keyframe: str | None  # why the frame became a keyframe; None if it did not
    levels: tuple[LevelStats, ...]  # coarse to fine
    milliseconds: dict[str, float]  # where the time went [ms]

    @property
    def stamp(self) -> float:
        """[s]"""
        return self.stamp_ns * 1e-9

    @property
    def ok(self) -> bool:
        """The pose is an estimate, not a guess."""
        return self.status in ("first", "tracked", "relocalized")


def result_from(fields: dict[str, Any]) -> FrameResult:
    levels = tuple(LevelStats(**level) for level in fields.pop("levels"))
    return FrameResult(levels=levels, **fields)


class Tracker:
    """What ``Odometry`` and ``Slam`` have in common. Several threads may use one: its calls wait for
    each other. Only its own detector may not call it (``edvo.Error``, code 2)."""

    _make: Any  # of _core
    _more: dict[str, Any] = {}  # arguments of its own

    def __init__(
        self,
        camera: Camera,
        options: Options | None = None,
        *,
        method: str = _core.default_method,
        depth_scale: float | None = None,
        detector: EdgeDetector | None = None,
        mask: Mask | None = None,
        **changes: Value,
    ) -> None:
        if options is not None and (changes or method != _core.default_method):
            raise ValueError("give options, or a method and keywords, not both")
        require_detector(detector)
        self.camera = camera
        self.options = options if options is not None else Options(method, **changes)
        self.depth_scale = depth_scale
        self.detector = detector
        hidden = None if mask is None else visible_pixels(mask, camera.width, camera.height) == 0
        self._hidden = hidden
        self.reset()

    def process(
        self,
        stamp: Seconds,
        rgb: NDArray[np.uint8],
        depth: NDArray[Any],
        depth_scale: float | None = None,
    ) -> FrameResult:
        """Tracks one image; other Python threads run meanwhile.

        ``stamp`` in seconds, later than the one before. ``rgb``: H x W x 3, uint8, RGB. ``depth``:
        H x W, registered to ``rgb``; float32 in metres (NaN or 0 = none), or uint16 with
        ``depth_scale`` units per metre (0 and 65535 = none); where a masked array is masked, there is
        none. Raises TypeError and ValueError for arrays that do not fit, also for floats with a scale
        other than 1, ``edvo.Error`` for images out of order; then nothing has changed.
        """
        return self.process_ns(*nanoseconds(stamp), rgb, depth, depth_scale)

    def process_ns(
        self,
        stamp_ns: int,
        decimals: int,
        rgb: NDArray[np.uint8],
        depth: NDArray[Any],
        depth_scale: float | None = None,
    ) -> FrameResult:
        """The same with a stamp in nanoseconds and the decimals that files keep of it."""
        width, height = self.camera.width, self.camera.height
        rgb = check_rgb(rgb, width, height)
        depth = check_depth(depth, width, height)
        if self._hidden is not None:
            depth = np.where(self._hidden, depth.dtype.type(0), depth)
        try:
            if depth.dtype == np.uint16:
                scale = self._units_per_metre(depth_scale)
                fields = self._core.process_units(stamp_ns, decimals, rgb, depth, scale)
            else:
                self._require_metres(depth_scale)
                fields = self._core.process_metres(stamp_ns, decimals, rgb, depth)
        except Error as error:
            raise_cause(error, self.detector)
        return result_from(fields)

    def _require_metres(self, given: float | None) -> None:
        scale = given if given is not None else self.depth_scale
        if scale not in (None, 1):
            raise ValueError(
                f"depth: float32 is in metres, but depth_scale is {scale}; give uint16, or metres "
                "without depth_scale"
            )

    def _units_per_metre(self, given: float | None) -> float:
        scale = given if given is not None else self.depth_scale
        if scale is None:
            raise ValueError(
                "depth: uint16 needs depth_scale, its units per metre (1000: millimetres, "
                "5000: TUM)"
            )
        if not scale > 0:
            raise ValueError(f"depth_scale {scale}: must be positive")
        return scale

    def finish(self, threads: int = 2) -> None:
        """Refines the last keyframes to the end, and all of a segment together: once after the last
        image. The result is the same for any number of threads."""
        self._core.finish(threads)

    def reset(self) -> None:
        """As if no image had come."""
        self._core = self._make(
            as_tuple(self.camera),
            self.options.method,
            list(self.options.changes),
            self.detector,
            **self._more,
        )

    def trajectory(self) -> Trajectory:
        """The best present estimate of every tracked frame; later frames may still change it."""
        return Trajectory._from_arrays(self._core.trajectory())

    def keyframes(self) -> Trajectory:
        """The keyframes' poses."""
        return Trajectory._from_arrays(self._core.keyframes())

    def segments(self) -> list[Trajectory]:
        """The trajectory in parts between which no motion is known."""
        whole = self.trajectory()
        return [whole.of_segment(segment) for segment in np.unique(whole.segments).tolist()]


class Odometry(Tracker):
    """RGB-D images in, poses out. The world is the camera frame of the first usable image.

    ``options``: an ``Options``, or keywords "group.field" over those of ``method``::

        odometry = edvo.Odometry(camera, **{"keyframes.period": 30})

    ``detector``: an ``EdgeDetector`` instead of what the options name. ``mask``: as ``edvo.run`` has it.
    """

    _make = _core.Odometry


@dataclass(frozen=True, eq=False)
class Link:
    """What became of two keyframes that might show the same place. What was not reached is zero."""

    first: int  # keyframe
    second: int  # keyframe
    status: str  # "accepted", or which step refused it (docs/slam.md)
    similarity: float  # of the places' codes [0..1]
    matches: int  # corners
    inliers: int  # of them
    translation_difference: float  # of both directions [m]
    rotation_difference: float  # [rad]
    overlap: float  # the smaller of both directions [0..1]
    correlation: float  # the smaller of both directions
    seen_through: float  # the larger of both directions [0..1]
    cycle_chi_square: float
    first_from_second: NDArray[np.float64]  # 4 x 4
    information: NDArray[np.float64]  # 6 x 6, of xi in first_from_second * exp(xi)

    @property
    def accepted(self) -> bool:
        return self.status == "accepted"


class Slam(Tracker):
    """``Odometry`` whose keyframes are joined by the places that they show again.

    While images come it is the odometry. ``finish`` looks for keyframes of the same place, joins
    segments, closes loops and refines all keyframes together; ``edvo.run`` does the same. Methods
    without keyframes (the dense one) have nothing to join: ``edvo.Error``, code 4.

    ``map``: a saved map (docs/maps.md) in which ``finish`` looks for this run; segments that are found
    (``map_segments``) are moved into its frame. ``keep_colour``: in the map that ``save_map`` writes.
    """

    _make = _core.Slam

    def __init__(
        self,
        camera: Camera,
        options: Options | None = None,
        *,
        map: str | Path | None = None,
        keep_colour: bool = False,
        **others: Any,
    ) -> None:
        self._more = {"keep_colour": keep_colour, "map": None if map is None else Path(map)}
        super().__init__(camera, options, **others)

    def map_segments(self) -> list[int] | None:
        """After ``finish``: which segments were found in the earlier map; None if there is none."""
        found: list[int] | None = self._core.map_segments()
        return found

    def save_map(self, file: str | Path, *, force: bool = False) -> None:
        """After ``finish``: keyframes, images and links, for ``Slam(map=...)`` and ``edvo run --map``.
        The file appears whole or not at all, and replaces a map of that name only with ``force``;
        ``edvo.Error`` if there is one or it is no map (code 7), if another program writes it
        (code 11), and if there is nothing yet to save (code 2)."""
        if not force and Path(file).is_file() and Path(file).stat().st_size > 0:
            raise Error(
                f"save_map {file}: there is such a file; give another name, or replace it with "
                "force=True",
                7,
            )
        if len(self.keyframes()) == 0:
            raise Error(f"save_map {file}: nothing was tracked yet that could be saved", 2)
        self._core.save_map(Path(file))

    def links(self) -> list[Link]:
        """What the last ``finish`` found out about each candidate."""
        return [Link(**fields) for fields in self._core.links()]


def raise_cause(
    error: Error, detector: EdgeDetector | None, cause: BaseException | None = None
) -> NoReturn:
    """The error, with what a detector or else a source raised as its cause; ctrl-C as itself."""
    failure = detector._take_failure() if detector is not None else None
    cause = failure if failure is not None else cause
    if cause is not None and not isinstance(cause, Exception):
        raise cause
    raise error from cause

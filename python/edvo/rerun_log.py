# SPDX-License-Identifier: MIT
"""What the live view and that of a finished run write to Rerun in the same way."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import missing_extra
from edvo.trajectory import Trajectory

TRUTH, FINAL = [150, 150, 150], [90, 170, 255]  # colours
MOST_ROWS = 100  # frames of which poses and curves are sent together


def rerun() -> Any:
    try:
        import rerun as module
    except ImportError:
        raise missing_extra("the viewer", "rerun-sdk", "view") from None
    return module


class Log:
    """What the live view and that of a finished run write in the same way."""

    def __init__(self) -> None:
        self.rr = rerun()
        self.out = self.rr.RecordingStream("edvo")

    def line(self, name: str, positions: NDArray[Any], colour: list[int]) -> None:
        if len(positions):
            self.out.log(name, self.rr.LineStrips3D([positions], colors=[colour]))

    def lines(self, name: str, trajectory: Trajectory, colour: list[int]) -> None:
        """One for each segment."""
        parts = [
            trajectory.positions[trajectory.segments == segment]
            for segment in np.unique(trajectory.segments)
        ]
        if parts:
            self.out.log(name, self.rr.LineStrips3D(parts, colors=[colour]))

    def at(self, stamp_ns: int) -> None:
        self.out.set_time("stamp", timestamp=np.datetime64(stamp_ns, "ns"))

    def pose(self, name: str, pose: NDArray[np.float64]) -> None:
        self.out.log(name, self.rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))

    def frustum(self, name: str, camera: Camera, distance: float) -> None:
        self.out.log(
            name,
            self.rr.Pinhole(
                image_from_camera=camera.matrix,
                resolution=[camera.width, camera.height],
                image_plane_distance=distance,
            ),
        )

    def event(self, text: str, level: str = "INFO") -> None:
        self.out.log("events", self.rr.TextLog(text, level=level))


class Rows:
    """Poses and curves of frames, sent together: one by one they take six times as long."""

    CURVES = ("inliers/inliers", "inliers/overlap", "time/total")

    def __init__(self, log: Log) -> None:
        self._log = log
        self._stamps: list[int] = []
        self._poses: list[NDArray[np.float64]] = []
        self._curves: list[tuple[float, float, float]] = []

    def add(
        self,
        stamp_ns: int,
        pose: NDArray[np.float64],
        inliers: float,
        overlap: float,
        milliseconds: float,
    ) -> None:
        self._stamps.append(stamp_ns)
        self._poses.append(pose)
        self._curves.append((inliers, overlap, milliseconds))
        if len(self._stamps) >= MOST_ROWS:
            self.send()

    def send(self) -> None:
        if not self._stamps:
            return
        rr, out = self._log.rr, self._log.out
        stamps = np.array(self._stamps, dtype="datetime64[ns]")
        index = [rr.TimeColumn("stamp", timestamp=stamps)]
        poses, curves = np.array(self._poses), np.array(self._curves)
        transforms = rr.Transform3D.columns(translation=poses[:, :3, 3], mat3x3=poses[:, :3, :3])
        rr.send_columns("world/camera", indexes=index, columns=transforms, recording=out)
        for name, values in zip(self.CURVES, curves.T):
            scalars = rr.Scalars.columns(scalars=values)
            rr.send_columns(name, indexes=index, columns=scalars, recording=out)
        self._stamps, self._poses, self._curves = [], [], []

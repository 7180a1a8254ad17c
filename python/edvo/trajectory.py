# SPDX-License-Identifier: MIT
"""Poses in time, and the files they are kept in."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.errors import Error


FORMATS = ("tum", "kitti", "euroc", "mcap")
ENDINGS = {".tum": "tum", ".txt": "tum", ".kitti": "kitti", ".csv": "euroc", ".mcap": "mcap"}
# Stamps [ns], decimals, poses, segments: as _core has them.
Arrays = tuple[NDArray[np.int64], int, NDArray[np.float64], NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses of the camera in the world (world_from_camera), ordered by stamp.

    ``stamps_ns``: N, [ns]. ``values``: N x 7, tx ty tz [m] qx qy qz qw. ``decimals``: digits after
    the point with which a text file keeps the stamps. ``segments``: N; between poses of two
    segments no motion is known. Raises TypeError for stamps that are no integers, ValueError for
    shapes that do not fit, ``edvo.Error`` (code 3) for stamps out of order.
    """

    stamps_ns: NDArray[np.int64]
    values: NDArray[np.float64]
    decimals: int = 9
    segments: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __repr__(self) -> str:
        if len(self) == 0:
            return "Trajectory(no poses)"
        first, last = self.stamps[0], self.stamps[-1]
        segments = len(np.unique(self.segments))
        parts = f", {segments} segments" if segments > 1 else ""
        return f"Trajectory({len(self)} poses{parts}, {first:.3f} s to {last:.3f} s)"

    def __post_init__(self) -> None:
        stamps = np.ascontiguousarray(integer_stamps(self.stamps_ns), np.int64)
        values = np.ascontiguousarray(self.values, np.float64).reshape(-1, 7)
        if len(stamps) != len(values):
            raise ValueError(f"{len(stamps)} stamps, but {len(values)} poses")
        segments = np.ascontiguousarray(self.segments, np.int64)
        if len(segments) == 0:
            segments = np.zeros(len(stamps), np.int64)
        if len(segments) != len(stamps):
            raise ValueError(f"{len(stamps)} poses, but {len(segments)} segments")
        require_ascending(stamps)
        object.__setattr__(self, "stamps_ns", stamps)
        object.__setattr__(self, "segments", segments)
        object.__setattr__(self, "values", values)

    def _arrays(self) -> Arrays:
        return self.stamps_ns, self.decimals, self.values, self.segments

    @staticmethod
    def _from_arrays(arrays: Arrays) -> Trajectory:
        stamps, decimals, values, segments = arrays
        return Trajectory(stamps, values, decimals, segments)

    @property
    def stamps(self) -> NDArray[np.float64]:
        """[s]"""
        return self.stamps_ns.astype(np.float64) * 1e-9

    @property
    def positions(self) -> NDArray[np.float64]:
        """N x 3, [m]"""
        return self.values[:, :3]

    @property
    def quaternions(self) -> NDArray[np.float64]:
        """N x 4, qx qy qz qw"""
        return self.values[:, 3:]

    @property
    def poses(self) -> NDArray[np.float64]:
        """N x 4 x 4, homogeneous"""
        x, y, z, w = self.quaternions.T
        matrices = np.zeros((len(self), 4, 4))
        matrices[:, 0, 0] = 1 - 2 * (y * y + z * z)
        matrices[:, 0, 1] = 2 * (x * y - w * z)
        matrices[:, 0, 2] = 2 * (x * z + w * y)
        matrices[:, 1, 0] = 2 * (x * y + w * z)
        matrices[:, 1, 1] = 1 - 2 * (x * x + z * z)
        matrices[:, 1, 2] = 2 * (y * z - w * x)
        matrices[:, 2, 0] = 2 * (x * z - w * y)
        matrices[:, 2, 1] = 2 * (y * z + w * x)
        matrices[:, 2, 2] = 1 - 2 * (x * x + y * y)
        matrices[:, :3, 3] = self.positions
        matrices[:, 3, 3] = 1
        return matrices

    def of_segment(self, segment: int) -> Trajectory:
        """The poses of one segment."""
        chosen = self.segments == segment
        return Trajectory(
            self.stamps_ns[chosen], self.values[chosen], self.decimals, self.segments[chosen]
        )

    @staticmethod
    def from_poses(
        stamps_ns: NDArray[np.int64], poses: NDArray[np.float64], decimals: int = 9
    ) -> Trajectory:
        """From N x 4 x 4 rigid matrices world_from_camera [m].

        ``stamps_ns``: N integers [ns], ascending; of seconds they are
        ``numpy.round(seconds * 1e9).astype(numpy.int64)``. ``decimals``: digits of a second that files
        keep. Raises TypeError for stamps that are no integers, ValueError for shapes and matrices
        that do not fit, ``edvo.Error`` (code 3) for stamps out of order.
        """
        times = integer_stamps(stamps_ns)
        poses = np.asarray(poses, np.float64)
        if poses.shape != (len(times), 4, 4):
            raise ValueError(
                f"poses: shape ({len(times)}, 4, 4) is expected for {len(times)} stamps, got "
                f"{poses.shape}"
            )
        require_rigid(poses)
        values = np.empty((len(poses), 7))
        values[:, :3] = poses[:, :3, 3]
        for i, pose in enumerate(poses):
            values[i, 3:] = quaternion(pose[:3, :3])
        return Trajectory(times.astype(np.int64), values, decimals)

    @staticmethod
    def read(file: str | Path) -> Trajectory:
        """A text file, one "stamp [s] tx ty tz [m] qx qy qz qw" a line (TUM), EuRoC's csv, or a run's
        folder, whose trajectory.tum it is. Raises ``edvo.Error`` (code 3) naming the line."""
        place = Path(file)
        arrays, _ = _core.read_trajectory(place / "trajectory.tum" if place.is_dir() else place)
        return Trajectory._from_arrays(arrays)

    def write(self, file: str | Path, format: str | None = None) -> None:
        """Writes a file, or replaces it: as "tum", "kitti" (3 x 4 matrices, no stamps), "euroc" (csv)
        or "mcap" (ROS 2: TF and a path; needs edvo[ros]). None: as its name ends, with .tum or .txt,
        .kitti, .csv, .mcap; only "tum" tells segments apart. ``edvo.Error`` (code 2) with another
        ending, (code 3) with a pose that is not finite, (code 7) if it cannot be written."""
        if format is None:
            format = format_of(file)
        if format not in FORMATS:
            raise ValueError(f"format {format!r}: unknown, one of {', '.join(FORMATS)}")
        require_finite(self)
        try:
            getattr(self, f"_write_{format}")(Path(file))
        except OSError as error:
            raise Error(f"{file}: cannot be written: {error.strerror}", 7) from None

    def _write_mcap(self, file: Path) -> None:
        from edvo.mcap_file import write_path

        write_path(file, self)

    def _write_tum(self, file: Path) -> None:
        _core.write_trajectory(file, *self._arrays())

    def _write_kitti(self, file: Path) -> None:
        rows = self.poses[:, :3, :].reshape(-1, 12)
        lines = (" ".join(repr(float(value)) for value in row) for row in rows)
        file.write_text("".join(line + "\n" for line in lines), encoding="utf-8")

    def _write_euroc(self, file: Path) -> None:
        header = (
            "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], "
            "q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
        )
        lines = [header]
        for stamp, (tx, ty, tz, qx, qy, qz, qw) in zip(self.stamps_ns, self.values.tolist()):
            lines.append(",".join([str(stamp), *map(repr, (tx, ty, tz, qw, qx, qy, qz))]) + "\n")
        file.write_text("".join(lines), encoding="utf-8")


def require_finite(trajectory: Trajectory) -> None:
    bad = np.flatnonzero(~np.isfinite(trajectory.values).all(axis=1))
    if len(bad):
        i = int(bad[0])
        raise Error(
            f"pose {i} at {trajectory.stamps[i]:.6f} s is not finite: "
            f"{trajectory.values[i].tolist()}; leave lost poses out",
            3,
        )


def integer_stamps(stamps_ns: object) -> NDArray[Any]:
    times = np.asarray(stamps_ns)
    if times.size and times.dtype.kind not in "iu":
        raise TypeError(
            f"stamps_ns: integers in nanoseconds are expected, got {times.dtype}; of seconds "
            "they are numpy.round(seconds * 1e9).astype(numpy.int64)"
        )
    return times


def require_ascending(stamps_ns: NDArray[np.int64]) -> None:
    late = np.flatnonzero(np.diff(stamps_ns) <= 0)
    if len(late):
        i = int(late[0]) + 1
        raise Error(
            f"stamps_ns[{i}]: {stamps_ns[i]} is not later than {stamps_ns[i - 1]} before it; sort "
            "the poses by stamp, each stamp once",
            3,
        )


RIGID_TOLERANCE = 1e-2  # of R' R - 1; files with few digits have up to 1e-3


def require_rigid(poses: NDArray[np.float64]) -> None:
    turns = poses[:, :3, :3]
    with np.errstate(invalid="ignore"):
        errors = np.abs(np.swapaxes(turns, 1, 2) @ turns - np.eye(3)).max(axis=(1, 2), initial=0)
        rigid = (errors < RIGID_TOLERANCE) & (np.linalg.det(turns) > 0)
        rigid &= np.isfinite(poses[:, :3, 3]).all(axis=1)
        rigid &= np.abs(poses[:, 3] - [0, 0, 0, 1]).max(axis=1, initial=0) < RIGID_TOLERANCE
    if not rigid.all():
        i = int(np.flatnonzero(~rigid)[0])
        raise ValueError(
            f"poses[{i}]: no rigid motion: a rotation and a finite translation over the row 0 0 0 1 "
            f"are expected, got {poses[i].round(4).tolist()}; leave lost poses out"
        )


def format_of(file: str | Path) -> str:
    """The format that a file's name says; TUM's without an ending."""
    ending = Path(file).suffix.lower()
    if ending and ending not in ENDINGS:
        known = ", ".join(f"{name} ({format})" for name, format in ENDINGS.items())
        raise Error(f"{file}: no known format; it may end in {known}, or give the format", 2)
    return ENDINGS.get(ending, "tum")


def quaternion(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """qx qy qz qw of the rotation nearest to a 3 x 3 matrix (qw >= 0)."""
    u, _, vt = np.linalg.svd(rotation)
    m = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    # The eigenvector of Bar-Itzhack's matrix: stable for every rotation.
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    q = np.linalg.eigh(k)[1][:, -1]
    return np.asarray(q if q[3] >= 0 else -q)

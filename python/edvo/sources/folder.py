# SPDX-License-Identifier: MIT
"""Folders and archives that the C++ library reads."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from edvo import _core
from edvo.camera import Camera, from_tuple
from edvo.sources.base import Frame, Source
from edvo.trajectory import Trajectory


def cache_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "edvo"


class FolderSource(Source):
    """TUM, ICL-NUIM, ETH3D, Bonn, 7-Scenes, BundleFusion, ScanNet, Replica, Open3D's and Redwood's
    recorders, association files and folders of numbered images; also as .tgz or .zip."""

    def __init__(
        self,
        path: str | Path,
        *,
        camera: Camera | str | Path | None = None,
        depth_scale: float | None = None,
    ) -> None:
        super().__init__()
        self._dataset = _core.open_dataset(Path(path), depth_scale, cache_folder())
        self.name = self._dataset.name
        self.origin = f"{path} ({self._dataset.layout})"
        self.frames = len(self._dataset)
        self.units_per_metre: float = self._dataset.units_per_metre
        self.notes += self._dataset.notes
        self.warnings += self._dataset.warnings
        if isinstance(camera, Camera):
            self.camera = camera
        else:
            file = None if camera is None else Path(camera)
            values, self.camera_origin = self._dataset.camera(file)
            self.camera = from_tuple(values)
        self.ground_truth = self._read_ground_truth()

    def _read_ground_truth(self) -> Trajectory | None:
        stamps, decimals, values = self._dataset.poses()
        if len(stamps):
            return Trajectory(stamps, values, decimals)
        if self._dataset.ground_truth is None:
            return None
        (stamps, decimals, values), warnings = _core.read_trajectory(self._dataset.ground_truth)
        self.warnings += warnings
        return Trajectory(stamps, values, decimals)

    def __len__(self) -> int:
        return len(self._dataset)

    def __getitem__(self, index: int) -> Frame:
        stamp_ns, decimals, rgb, depth = self._dataset.read(index)
        return Frame(stamp_ns, rgb, depth, decimals)

    def __iter__(self) -> Iterator[Frame]:
        for index in range(len(self)):
            yield self[index]

    def stamps_ns(self, index: int) -> tuple[int, int]:
        """Of the colour and of the depth image."""
        return self._dataset.stamp(index)[0], self._dataset.depth_stamp_ns(index)

    def files(self, index: int) -> tuple[Path, Path]:
        """The colour and the depth image."""
        colour, depth = self._dataset.files(index)
        return Path(colour), Path(depth)

# SPDX-License-Identifier: MIT
"""Folders and archives that the C++ library reads."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.camera import Camera, from_tuple
from edvo.registration import DepthRegistration
from edvo.sources.base import Arrays, Frame, Source
from edvo.sources.depth_cameras import read_depth_camera
from edvo.trajectory import Trajectory


def cache_folder() -> Path:
    """Where archives are unpacked and downloads kept; as the C++ program has it."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):
        base = os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "edvo"


class FolderSource(Source):
    """TUM, ICL-NUIM, ETH3D, Bonn, 7-Scenes, BundleFusion, ScanNet, Replica, Open3D's and Redwood's
    recorders, association files and folders of numbered images; also as .tgz or .zip.

    ``depth_camera``: of depth that is not registered to colour, of whatever size."""

    def __init__(
        self,
        path: str | Path,
        *,
        camera: Camera | str | Path | None = None,
        camera_size: tuple[int, int] = (0, 0),
        depth_scale: float | None = None,
        depth_camera: Camera | str | Path | None = None,
        colour_from_depth: NDArray[np.float64] | None = None,
    ) -> None:
        super().__init__()
        file = None if camera is None or isinstance(camera, Camera) else Path(camera)
        own = as_file(camera) if isinstance(camera, Camera) else None
        try:
            chosen = own if own is not None else file
            self._folder = _core.FolderSource(
                Path(path), chosen, camera_size, depth_scale, depth_camera is None, cache_folder()
            )
        finally:
            if own is not None:
                own.unlink()
        self._info: dict[str, Any] = self._folder.info()
        self.name = self._info["name"]
        self.origin = self._info["origin"]
        self.frames = len(self._folder)
        self.units_per_metre: float = self._info["depth_scale"]
        self.depth_origin = self._info["depth_origin"]
        self.notes += self._info["notes"]
        self.warnings += self._info["warnings"]
        self.camera = from_tuple(self._info["camera"])
        self.camera_origin = "as given" if own is not None else self._info["camera_origin"]
        if self._info["ground_truth"] is not None:
            self.ground_truth = Trajectory._from_arrays(self._info["ground_truth"])
            self.ground_truth_origin = self._info["ground_truth_origin"]
        self.registration: DepthRegistration | None = None
        if depth_camera is not None:
            own_depth = read_depth_camera(depth_camera, self._folder.depth_size)
            self.registration = DepthRegistration(own_depth, self.camera, colour_from_depth)
            self.notes.append("depth is registered to colour here")

    def _native(self) -> Any:
        is_own = type(self).__iter__ is FolderSource.__iter__ and self.registration is None
        return self._folder if is_own else None

    def _describe(self) -> dict[str, Any]:
        fields = super()._describe()
        fields["depth_scale"] = self.units_per_metre
        fields["is_depth_assumed"] = self._info["is_depth_assumed"]
        return fields

    def __len__(self) -> int:
        return len(self._folder)

    def __getitem__(self, index: int) -> Frame:
        stamp_ns, decimals, rgb, depth = self._folder.read(index)
        if self.registration is not None:
            depth = self.registration(depth)
        return Frame(stamp_ns, rgb, depth, decimals)

    def __iter__(self) -> Iterator[Frame]:
        for index in range(len(self)):
            yield self[index]

    def _pending(self) -> Iterator[tuple[int, int, Callable[[], Arrays]]]:
        if type(self).__iter__ is not FolderSource.__iter__:
            yield from super()._pending()
            return
        # Read where it is needed: a damaged image costs its own frame only.
        for index in range(len(self)):
            stamp_ns, decimals = self._folder.stamp(index)
            yield stamp_ns, decimals, self._loader(partial(self.__getitem__, index))

    def stamps_ns(self, index: int) -> tuple[int, int]:
        """Of the colour and of the depth image."""
        return self._folder.stamp(index)[0], self._folder.depth_stamp_ns(index)

    def files(self, index: int) -> tuple[Path, Path]:
        """The colour and the depth image."""
        colour, depth = self._folder.files(index)
        return Path(colour), Path(depth)


def as_file(camera: Camera) -> Path:
    """The camera in a file of its own, for readers that want one; to be removed by the caller."""
    import tempfile

    handle, name = tempfile.mkstemp(prefix="edvo-camera-", suffix=".toml")
    with os.fdopen(handle, "w", encoding="utf-8") as stream:
        stream.write(camera.to_toml())
    return Path(name)

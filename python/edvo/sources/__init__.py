# SPDX-License-Identifier: MIT
"""Where frames come from: folders, archives, ROS bags, phones; ``open_source`` guesses which."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error
from edvo.sources.archives import is_for_python, recording_in
from edvo.sources.azure import AzureSource
from edvo.sources.bag import BagSource
from edvo.sources.bag_reader import is_bag
from edvo.sources.base import Frame, Source
from edvo.sources.folder import FolderSource
from edvo.sources.listed import ListedSource
from edvo.sources.live import LiveSource
from edvo.sources.oak import OakSource
from edvo.sources.openni import OpenNiSource
from edvo.sources.pairs import (
    is_nyu_raw,
    needs_python,
    open_pairs,
    refuse_nyu_raw,
)
from edvo.sources.phones import StraySource, is_record3d, is_stray, open_record3d
from edvo.sources.realsense import RealSenseSource

__all__ = [
    "AzureSource",
    "BagSource",
    "FolderSource",
    "Frame",
    "ListedSource",
    "LiveSource",
    "OakSource",
    "OpenNiSource",
    "RealSenseSource",
    "Source",
    "open_source",
    "read_by_core",
]


CAMERAS: dict[str, Callable[[str, Camera | str | Path | None], LiveSource]] = {
    "realsense": RealSenseSource,
    "oak": OakSource,
    "openni": OpenNiSource,
}
CAMERA = "camera:"  # camera:realsense, camera:oak/SERIAL


def open_camera(name: str, camera: Camera | str | Path | None) -> LiveSource:
    kind, _, serial = name.removeprefix(CAMERA).partition("/")
    if kind not in CAMERAS:
        raise Error(f"{name}: no such camera; known: {', '.join(CAMERA + k for k in CAMERAS)}", code=2)
    return CAMERAS[kind](serial, camera)


def read_by_core(path: str | Path) -> bool:
    """The C++ program opens it, or says why not."""
    place = Path(path)
    if str(path).startswith(CAMERA):
        return False
    return not (is_python_place(place) or is_for_python(place))


def is_python_place(place: Path) -> bool:
    """A recording that only Python reads."""
    if is_bag(place) or is_record3d(place) or place.suffix == ".mkv":
        return True
    return place.is_dir() and (is_stray(place) or is_nyu_raw(place) or needs_python(place))


def open_source(
    path: str | Path,
    *,
    camera: Camera | str | Path | None = None,
    camera_size: tuple[int, int] = (0, 0),
    depth_scale: float | None = None,
    depth_camera: Camera | str | Path | None = None,
    colour_from_depth: NDArray[np.float64] | None = None,
    colour_topic: str | None = None,
    depth_topic: str | None = None,
) -> Source:
    """Opens a recording or a camera; what was recognised and chosen is in ``source.notes``.

    ``path``: a folder, an archive, a bag, a phone's recording, or ``camera:realsense``,
    ``camera:oak``, ``camera:openni`` (with /SERIAL, if there are several).
    ``camera`` and ``depth_camera``: a ``Camera`` or a calibration file. ``camera_size``: width and
    height of the images that ``camera`` was calibrated with, if these are of another size.
    ``depth_scale``: units per metre. ``colour_from_depth``: 4 x 4, for depth that is not registered to colour. Topics are for
    bags. Raises ``edvo.Error`` in one sentence if the recording cannot be opened.
    """
    if str(path).startswith(CAMERA):
        others = (depth_scale, depth_camera, colour_from_depth, colour_topic, depth_topic)
        if any(value is not None for value in others):
            raise Error(f"{path}: says its units itself; only --camera fits it", code=2)
        return open_camera(str(path), camera)
    place = Path(path)
    if is_for_python(place):
        source = open_source(
            recording_in(place, is_python_place),
            camera=camera,
            camera_size=camera_size,
            depth_scale=depth_scale,
            depth_camera=depth_camera,
            colour_from_depth=colour_from_depth,
            colour_topic=colour_topic,
            depth_topic=depth_topic,
        )
        source.name = place.stem
        source.notes.append(f"unpacked from {path}")
        return source
    registration: dict[str, Any] = {
        "depth_camera": depth_camera,
        "colour_from_depth": colour_from_depth,
    }
    if depth_camera is None and colour_from_depth is not None:
        raise Error("colour_from_depth (--colour-from-depth) needs the depth camera's calibration", 2)
    if is_bag(place):
        return BagSource(
            place,
            camera=camera,
            camera_size=camera_size,
            depth_scale=depth_scale,
            colour_topic=colour_topic,
            depth_topic=depth_topic,
            **registration,
        )
    if colour_topic is not None or depth_topic is not None:
        raise Error(f"{path}: topics are for bags (.bag, .db3, .mcap)", code=2)
    if is_record3d(place) or (place.is_dir() and is_stray(place)):
        given = (camera, depth_scale, depth_camera, colour_from_depth)
        if any(value is not None for value in given):
            raise Error(f"{path}: says its cameras and units itself; leave them out", code=2)
        return open_record3d(place) if is_record3d(place) else StraySource(place)
    if place.suffix == ".mkv":
        if any(value is not None for value in (depth_scale, depth_camera, colour_from_depth)):
            raise Error(f"{path}: says its units and its depth camera itself; leave them out", code=2)
        return AzureSource(place, camera)
    if place.is_dir():
        if is_nyu_raw(place):
            raise refuse_nyu_raw(place)
        if needs_python(place):
            return open_pairs(place, camera, camera_size, depth_scale, **registration)
    return FolderSource(
        place, camera=camera, camera_size=camera_size, depth_scale=depth_scale, **registration
    )

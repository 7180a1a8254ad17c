# SPDX-License-Identifier: MIT
"""Where frames come from: folders, archives, ROS bags, phones; ``open_source`` guesses which."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error
from edvo.sources.bag import BagSource
from edvo.sources.bag_reader import is_bag
from edvo.sources.base import Frame, Source
from edvo.sources.folder import FolderSource
from edvo.sources.listed import ListedSource
from edvo.sources.pairs import find_folders, images_in, is_nyu_raw, open_pairs, refuse_nyu_raw
from edvo.sources.phones import StraySource, is_record3d, is_stray, open_record3d

__all__ = [
    "BagSource",
    "FolderSource",
    "Frame",
    "ListedSource",
    "Source",
    "open_source",
    "read_by_core",
]


def needs_python(path: Path) -> bool:
    """The images are in formats that only Python reads."""
    folders = find_folders(path)
    if folders is None:
        return False
    return not images_in(folders[1], (".png",)) or not images_in(
        folders[0], (".png", ".jpg", ".jpeg")
    )


def read_by_core(path: str | Path) -> bool:
    """The C++ program opens it, or says why not."""
    place = Path(path)
    if is_bag(place) or is_record3d(place) or place.suffix == ".mkv":
        return False
    if place.is_dir():
        return not (is_stray(place) or is_nyu_raw(place) or needs_python(place))
    return True


def open_source(
    path: str | Path,
    *,
    camera: Camera | str | Path | None = None,
    depth_scale: float | None = None,
    depth_camera: Camera | str | Path | None = None,
    colour_from_depth: NDArray[np.float64] | None = None,
    colour_topic: str | None = None,
    depth_topic: str | None = None,
) -> Source:
    """Opens a recording; what was recognised and chosen is in ``source.notes``.

    ``camera`` and ``depth_camera``: a ``Camera`` or a calibration file. ``depth_scale``: units per
    metre. ``colour_from_depth``: 4 x 4, for depth that is not registered to colour. Topics are for
    bags. Raises ``edvo.Error`` in one sentence if the recording cannot be opened.
    """
    place = Path(path)
    if is_bag(place):
        return BagSource(
            place,
            camera=camera,
            depth_scale=depth_scale,
            colour_topic=colour_topic,
            depth_topic=depth_topic,
        )
    if colour_topic is not None or depth_topic is not None:
        raise Error(f"{path}: topics are for bags (.bag, .db3, .mcap)", code=2)
    if is_record3d(place):
        return open_record3d(place)
    if place.suffix == ".mkv":
        raise Error(
            f"{path}: Azure Kinect's .mkv is not read; `ros2 bag record` of its driver is", code=3
        )
    if place.is_dir():
        if is_stray(place):
            return StraySource(place)
        if is_nyu_raw(place):
            raise refuse_nyu_raw(place)
        if depth_camera is not None or needs_python(place):
            return open_pairs(place, camera, depth_scale, depth_camera, colour_from_depth)
    return FolderSource(place, camera=camera, depth_scale=depth_scale)

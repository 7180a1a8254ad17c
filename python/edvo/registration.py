# SPDX-License-Identifier: MIT
"""Depth of a sensor beside the colour camera."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.camera import Camera, as_tuple
from edvo.images import check_depth


class DepthRegistration:
    """Brings depth into the image of the colour camera; occluded surfaces are left out.

    ``colour_from_depth``: 4 x 4, points of the depth camera [m] into the colour camera.
    """

    def __init__(
        self, depth: Camera, colour: Camera, colour_from_depth: NDArray[np.float64] | None = None
    ) -> None:
        pose = np.eye(4) if colour_from_depth is None else np.asarray(colour_from_depth, float)
        if pose.shape != (4, 4):
            raise ValueError(f"colour_from_depth: shape (4, 4) is expected, got {pose.shape}")
        turn = pose[:3, :3]
        if not np.isfinite(pose).all():
            raise ValueError("colour_from_depth: not all of its numbers are finite")
        if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-2 or np.linalg.det(turn) < 0:
            raise ValueError("colour_from_depth: its upper left 3 x 3 part is no rotation")
        self.depth = depth
        self.colour = colour
        self._core = _core.DepthRegistration(
            as_tuple(depth), as_tuple(colour), np.ascontiguousarray(pose)
        )

    def __call__(self, depth: NDArray[Any]) -> NDArray[np.float32]:
        """``depth``: H x W of the depth camera, float32 [m]. Returns H x W of the colour camera."""
        image = check_depth(depth, self.depth.width, self.depth.height)
        if image.dtype != np.float32:
            raise TypeError("depth: float32 in metres is expected; divide by the units per metre")
        return np.asarray(self._core.register(image))


def register_depth(
    depth: NDArray[np.float32],
    depth_camera: Camera,
    colour_camera: Camera,
    colour_from_depth: NDArray[np.float64] | None = None,
) -> NDArray[np.float32]:
    """The depth that the colour camera would have measured: once; for many images of the same
    cameras keep a ``DepthRegistration``."""
    return DepthRegistration(depth_camera, colour_camera, colour_from_depth)(depth)

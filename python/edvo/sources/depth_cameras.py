# SPDX-License-Identifier: MIT
"""Calibrations that are given for images of one size."""

from __future__ import annotations

from pathlib import Path

from edvo.camera import Camera, read_scaled
from edvo.errors import Error

Size = tuple[int, int]  # width, height [px]
FARTHEST_MIDDLE = 0.33  # of the image, of a principal point


def check_size(camera: Camera, size: Size, what: str) -> Camera:
    """The camera, if it is for images of that size. ``what``: "the camera (--camera)"."""
    if (camera.width, camera.height) != size:
        raise Error(
            f"{what} is for {camera.width} x {camera.height} px, but the images are "
            f"{size[0]} x {size[1]}; if they were resized, scale it (Camera.scaled_to)",
            code=5,
        )
    return camera


def read_depth_camera(camera: Camera | str | Path, size: Size) -> Camera:
    """For depth images of that size. Raises edvo.Error (5) for a calibration of others."""
    what = "the depth camera (--depth-camera)"
    own = check_size(read_scaled(camera, (0, 0), size), size, what)
    # A file of plain numbers says no size; the principal point shows it.
    off = max(abs((own.cx + 0.5) / size[0] - 0.5), abs((own.cy + 0.5) / size[1] - 0.5))
    if off > FARTHEST_MIDDLE:
        raise Error(
            f"{what} has its principal point at {own.cx:g}, {own.cy:g}, {100 * off:.0f} % off the "
            f"middle of depth images of {size[0]} x {size[1]} px; it seems to be calibrated for about "
            f"{2 * own.cx + 1:.0f} x {2 * own.cy + 1:.0f} px: scale it to the depth images",
            code=5,
        )
    return own

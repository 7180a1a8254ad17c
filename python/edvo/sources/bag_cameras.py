# SPDX-License-Identifier: MIT
"""Cameras of a bag: its CameraInfo, for the images that it belongs to."""

from __future__ import annotations

from typing import Any

from edvo.camera import Camera
from edvo.errors import Error
from edvo.sources import messages
from edvo.sources.depth_cameras import Size
from edvo.sources.untrusted import reading


def info_camera(message: Any, info: str, images: str, size: Size, calibrated: Size, flag: str) -> Camera:
    """Of a CameraInfo message on topic ``info``, for images of a topic and size.

    ``calibrated``: the size of the images that it is for, if the user says that they were resized;
    ``flag`` gives a calibration instead. Raises edvo.Error (5) if it is of other images.
    """
    try:
        # image_proc's rectified images have the camera of P, without distortion.
        unsized = size if calibrated == (0, 0) else calibrated
        camera = messages.camera_from(message, unsized, "image_rect" in images)
    except Error as error:
        raise Error(f"{info}: {error}; give the calibration with {flag} FILE", error.code) from None
    own = (camera.width, camera.height)
    if own == size:
        return camera
    binned = (own[0] // max(message.binning_x, 1), own[1] // max(message.binning_y, 1))
    if own == calibrated or binned == size:
        with reading(info, 5):
            return camera.scaled_to(*size)
    raise Error(
        f"CameraInfo of {info} is for {own[0]} x {own[1]} px, but the images of {images} are "
        f"{size[0]} x {size[1]}; if they were resized, --camera-size {own[0]}x{own[1]}; if they were "
        f"cropped, their own calibration with {flag} FILE",
        code=5,
    )

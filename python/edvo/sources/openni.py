# SPDX-License-Identifier: MIT
"""Kinect, Xtion, Astra and others, by OpenNI2."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error, missing_extra
from edvo.sources.base import Frame, metres
from edvo.sources.live import LiveSource

WIDTH, HEIGHT, RATE = 640, 480, 30
TOGETHER_NS = 20_000_000  # between a colour image and its depth


class OpenNiSource(LiveSource):
    """The driver registers depth to colour; the focal length is what the field of view says."""

    kind = name = "openni"

    def __init__(self, serial: str = "", camera: Camera | str | Path | None = None) -> None:
        try:
            from openni import openni2
        except ImportError:
            raise missing_extra("a camera of OpenNI2", "openni", "openni") from None
        self._ni: Any = openni2
        self._uri = serial
        super().__init__(camera)

    def _start(self) -> None:
        ni = self._ni
        try:
            ni.initialize()
        except Exception as error:
            raise Error(
                "openni: the library libOpenNI2.so is not there (Debian: apt install libopenni2-0)", 3
            ) from error
        device = ni.Device(self._uri.encode() or None)
        self._depth = device.create_depth_stream()
        self._colour = device.create_color_stream()
        if self._depth is None or self._colour is None:
            raise Error("openni: the device has no colour and depth streams", code=3)
        self._colour.configure_mode(WIDTH, HEIGHT, RATE, ni.PIXEL_FORMAT_RGB888)
        self._depth.configure_mode(WIDTH, HEIGHT, RATE, ni.PIXEL_FORMAT_DEPTH_1_MM)
        registered = ni.IMAGE_REGISTRATION_DEPTH_TO_COLOR
        if device.is_image_registration_mode_supported(registered):
            device.set_image_registration_mode(registered)
            self.notes.append("depth is registered to colour by the driver")
        else:
            self.warnings.append("the driver does not register depth to colour: expect errors")
        device.set_depth_color_sync_enabled(True)
        self._device = device
        for stream in (self._colour, self._depth):
            stream.set_mirroring_enabled(False)
            stream.start()
        focal = WIDTH / 2 / math.tan(self._colour.get_horizontal_fov() / 2)
        self.camera = Camera(focal, focal, (WIDTH - 1) / 2, (HEIGHT - 1) / 2, WIDTH, HEIGHT)
        self.warnings.append("focal length from the nominal field of view; --camera is better")
        self.origin = str(device.get_device_info().name.decode(errors="replace"))
        self.depth_origin = "millimetres"
        self._last: dict[str, tuple[int, NDArray[Any]]] = {}

    def _read(self, seconds: float) -> Frame | None:
        stream = self._ni.wait_for_any_stream([self._colour, self._depth], seconds)
        if stream is None:
            return None
        image = stream.read_frame()
        stamp_ns = int(image.timestamp) * 1000
        if stream is self._colour:
            pixels = np.array(image.get_buffer_as_uint8(), np.uint8)
            self._last["colour"] = (stamp_ns, pixels.reshape(image.height, image.width, 3))
        else:
            units = np.array(image.get_buffer_as_uint16(), np.uint16)
            self._last["depth"] = (stamp_ns, units.reshape(image.height, image.width))
        if len(self._last) < 2:
            return None
        (time, rgb), (other, depth) = self._last["colour"], self._last["depth"]
        if abs(time - other) > TOGETHER_NS:
            return None  # the other one is to come
        self._last.clear()
        return Frame(time, rgb, metres(depth, 1000.0))

    def _end(self) -> None:
        self._colour.stop()
        self._depth.stop()
        self._device.close()

# SPDX-License-Identifier: MIT
"""RealSense cameras, by Intel's driver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from edvo.camera import Camera
from edvo.errors import missing_extra
from edvo.sources.base import Frame, metres
from edvo.sources.live import LiveSource


class RealSenseSource(LiveSource):
    """Colour and depth of 640 x 480 at 30 Hz; the driver registers depth to colour."""

    kind = name = "realsense"

    def __init__(self, serial: str = "", camera: Camera | str | Path | None = None) -> None:
        try:
            import pyrealsense2
        except ImportError:
            raise missing_extra("a RealSense camera", "pyrealsense2", "realsense") from None
        self._rs: Any = pyrealsense2
        self._serial = serial
        super().__init__(camera)

    def _start(self) -> None:
        rs = self._rs
        config = rs.config()
        if self._serial:
            config.enable_device(self._serial)
        config.enable_stream(rs.stream.color, 640, 480, rs.format.rgb8, 30)
        config.enable_stream(rs.stream.depth, 640, 480, rs.format.z16, 30)
        self._pipeline = rs.pipeline()
        profile = self._pipeline.start(config)
        device = profile.get_device()
        unit = float(device.first_depth_sensor().get_depth_scale())  # [m]
        self._units = float(np.float32(1) / np.float32(unit))
        self._align = rs.align(rs.stream.color)
        video = profile.get_stream(rs.stream.color).as_video_stream_profile()
        self.camera = self._camera_of(video.get_intrinsics())
        self.origin = device.get_info(rs.camera_info.name)
        self.depth_origin = f"{self._units:g} units per metre, as the device has it"
        self.notes.append("depth is registered to colour by the driver")

    def _camera_of(self, lens: Any) -> Camera:
        k1, k2, p1, p2, k3 = (float(value) for value in lens.coeffs)
        distortion: tuple[float, ...] = (k1, k2, p1, p2, k3)
        known = (self._rs.distortion.none, self._rs.distortion.brown_conrady)
        if any(distortion) and lens.model not in known:
            self.warnings.append(
                f"the device's lens model {lens.model} is not known here: distortion is left out; "
                "--camera gives a calibration"
            )
            distortion = ()
        return Camera(lens.fx, lens.fy, lens.ppx, lens.ppy, lens.width, lens.height, distortion)

    def _read(self, seconds: float) -> Frame | None:
        arrived, frames = self._pipeline.try_wait_for_frames(int(1000 * seconds))
        if not arrived:
            return None
        frames = self._align.process(frames)
        colour, depth = frames.get_color_frame(), frames.get_depth_frame()
        if not colour or not depth:
            return None
        # The driver writes its buffers again: copies.
        rgb = np.array(colour.get_data(), np.uint8)
        units = np.array(depth.get_data(), np.uint16)
        return Frame(round(1e6 * colour.get_timestamp()), rgb, metres(units, self._units))

    def _end(self) -> None:
        self._pipeline.stop()

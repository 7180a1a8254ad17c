# SPDX-License-Identifier: MIT
"""OAK cameras, by Luxonis' driver (depthai 3)."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np

from edvo.camera import Camera
from edvo.errors import Error, missing_extra
from edvo.sources.base import Frame, metres
from edvo.sources.live import LiveSource

SIZE = (640, 400)
RATE = 30.0  # [Hz]
MILLIMETRES = 1000.0
TOGETHER = timedelta(milliseconds=20)  # between a colour image and its depth


class OakSource(LiveSource):
    """Colour, undistorted on the device, and stereo depth in its view."""

    kind = name = "oak"

    def __init__(self, serial: str = "", camera: Camera | str | Path | None = None) -> None:
        try:
            import depthai
        except ImportError:
            raise missing_extra("an OAK camera", "depthai", "oak") from None
        self._dai: Any = depthai
        self._serial = serial
        if not hasattr(depthai.node, "Camera"):
            raise Error("an OAK camera needs depthai 3: pip install 'edvo[oak]'", code=2)
        super().__init__(camera)

    def _start(self) -> None:
        dai = self._dai
        device = dai.Device(dai.DeviceInfo(self._serial)) if self._serial else dai.Device()
        self._pipeline = dai.Pipeline(device)
        sockets = dai.CameraBoardSocket
        left, right, colour = (
            self._pipeline.create(dai.node.Camera).build(socket)
            for socket in (sockets.CAM_B, sockets.CAM_C, sockets.CAM_A)
        )
        stereo = self._pipeline.create(dai.node.StereoDepth)
        stereo.setDefaultProfilePreset(dai.node.StereoDepth.PresetMode.ROBOTICS)
        stereo.setDepthAlign(sockets.CAM_A)
        stereo.setOutputSize(*SIZE)
        left.requestOutput(SIZE, fps=RATE).link(stereo.left)
        right.requestOutput(SIZE, fps=RATE).link(stereo.right)
        images = colour.requestOutput(
            SIZE, type=dai.ImgFrame.Type.RGB888i, fps=RATE, enableUndistortion=True
        )
        both = self._pipeline.create(dai.node.Sync)
        both.setSyncThreshold(TOGETHER)
        images.link(both.inputs["colour"])
        stereo.depth.link(both.inputs["depth"])
        self._queue = both.out.createOutputQueue(maxSize=2, blocking=False)
        k = np.array(device.readCalibration().getCameraIntrinsics(sockets.CAM_A, *SIZE), float)
        self.camera = Camera(k[0, 0], k[1, 1], k[0, 2], k[1, 2], *SIZE)
        self.origin = f"OAK {device.getDeviceName()}"
        self.depth_origin = "millimetres"
        self.notes.append("depth is in the view of the colour camera, as the device computes it")
        self._pipeline.start()

    def _read(self, seconds: float) -> Frame | None:
        if not self._pipeline.isRunning():
            raise Error("oak: the device has stopped", code=3)
        group = self._queue.get(timedelta(seconds=seconds))
        if group is None:
            return None
        colour, depth = group["colour"], group["depth"]
        stamp_ns = colour.getTimestamp() // timedelta(microseconds=1) * 1000
        rgb, units = colour.getFrame(), depth.getFrame()
        return Frame(stamp_ns, np.array(rgb, np.uint8), metres(np.array(units), MILLIMETRES))

    def _end(self) -> None:
        self._pipeline.stop()

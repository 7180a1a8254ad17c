# SPDX-License-Identifier: MIT
"""Recordings of the Azure Kinect (and Orbbec's Femto in its place): Matroska with colour, depth and the
device's calibration."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera, read_scaled
from edvo.errors import Error
from edvo.registration import DepthRegistration
from edvo.sources.base import Frame, Source, metres, require_size
from edvo.sources.listed import shrunk
from edvo.sources.phones import WIDEST, shrunk_camera
from edvo.sources.untrusted import DAMAGE, check_pixels, reading
from edvo.sources.videos import open_video

MILLIMETRES = 1000.0
MOST_WAITING = 60  # images that wait for their depth, and the other way round
LATEST_NS = 9 * 10**18
TOGETHER_NS = 17_000_000  # between a colour image and its depth
# Of each mode: the sensor's pixels as they are binned, and what is cut off left and above; the
# calibration is of the whole sensor.
DEPTH_MODES = {
    (320, 288): (512, 512, 96, 90),
    (640, 576): (1024, 1024, 192, 180),
    (512, 512): (512, 512, 0, 0),
    (1024, 1024): (1024, 1024, 0, 0),
}


def mode_of(width: int, height: int, is_depth: bool) -> tuple[int, int, int, int]:
    if is_depth:
        if (width, height) not in DEPTH_MODES:
            raise Error(f"depth of {width} x {height} pixels: no mode of an Azure Kinect", code=3)
        return DEPTH_MODES[width, height]
    whole = width * 3 // 4  # the sensor has 4:3, most modes cut it to 16:9
    return width, whole, 0, (whole - height) // 2


def camera_of(calibration: dict[str, Any], width: int, height: int, is_depth: bool) -> Camera:
    """Of CalibrationInformation's entry, whose numbers are shares of the sensor's size."""
    cx, cy, fx, fy, *rest = (float(v) for v in calibration["Intrinsics"]["ModelParameters"])
    k1, k2, k3, k4, k5, k6, _, _, p2, p1 = rest[:10]
    across, down, left, above = mode_of(width, height, is_depth)
    return Camera(
        fx * across,
        fy * down,
        cx * across - left - 0.5,
        cy * down - above - 0.5,
        width,
        height,
        (k1, k2, p1, p2, k3, k4, k5, k6),
    )


def pose_of(calibration: dict[str, Any]) -> NDArray[np.float64]:
    """camera_from_device, 4 x 4 [m]."""
    pose = np.eye(4)
    pose[:3, :3] = np.array(calibration["Rt"]["Rotation"], float).reshape(3, 3)
    pose[:3, 3] = calibration["Rt"]["Translation"]
    return pose


class AzureSource(Source):
    """Depth is registered to colour by the recording's calibration; large colour images are shrunk
    by a whole factor."""

    depth_origin = "millimetres"

    def __init__(self, path: str | Path, camera: Camera | str | Path | None = None) -> None:
        super().__init__()
        self._path = Path(path)
        self.name = self._path.stem
        self.origin = f"{path} (Azure Kinect)"
        with open_video(self._path) as video:
            colour, depth = self._streams(video)
            cameras = self._calibration(video)
            size = (colour.codec_context.width, colour.codec_context.height)
            self._shape = (depth.codec_context.height, depth.codec_context.width)
            self.frames = colour.frames or None
        check_pixels(path, *size)
        with reading(f"{path}: calibration.json", 5):
            self._set_cameras(cameras, size, camera)

    def _set_cameras(
        self, cameras: dict[str, dict[str, Any]], size: tuple[int, int], camera: Camera | str | Path | None
    ) -> None:
        own = camera_of(cameras["PV0"], *size, is_depth=False)
        depth_camera = camera_of(cameras["D0"], self._shape[1], self._shape[0], is_depth=True)
        self._factor = max(1, -(-max(size) // WIDEST))
        self.camera = shrunk_camera(own, self._factor)
        self.camera_origin = "the recording's calibration"
        if camera is not None:
            self.camera = read_scaled(camera, size, (self.camera.width, self.camera.height))
            self.camera_origin = "as given"
        motion = pose_of(cameras["PV0"]) @ np.linalg.inv(pose_of(cameras["D0"]))
        self._registration = DepthRegistration(depth_camera, self.camera, motion)
        self.notes.append(
            f"colour of {size[0]} x {size[1]} px"
            + (f", shrunk by {self._factor}" if self._factor > 1 else "")
            + f"; depth of {self._shape[1]} x {self._shape[0]} px is registered to colour here: "
            f"baseline {1000 * float(np.linalg.norm(motion[:3, 3])):.1f} mm"
        )

    def _streams(self, video: Any) -> tuple[Any, Any]:
        named = {stream.metadata.get("title", "").upper(): stream for stream in video.streams.video}
        if "COLOR" not in named or "DEPTH" not in named:
            raise Error(
                f"{self._path}: no tracks COLOR and DEPTH, as an Azure Kinect's recording has them",
                code=3,
            )
        return named["COLOR"], named["DEPTH"]

    def _calibration(self, video: Any) -> dict[str, dict[str, Any]]:
        """By location: D0 is depth, PV0 colour."""
        for stream in video.streams.attachments:
            if not stream.name.endswith("calibration.json"):
                continue
            try:
                read = json.loads(bytes(stream.data).rstrip(b"\0"))
                cameras = {
                    camera["Location"].removeprefix("CALIBRATION_CameraLocation"): camera
                    for camera in read["CalibrationInformation"]["Cameras"]
                }
                return {name: cameras[name] for name in ("D0", "PV0")}
            except DAMAGE as error:
                raise Error(f"{self._path}: its calibration.json is damaged: {error!r}", 5) from None
        raise Error(f"{self._path}: no calibration.json in the recording", code=5)

    def __iter__(self) -> Iterator[Frame]:
        with open_video(self._path) as video:
            colour, depth = self._streams(video)
            images: deque[tuple[int, NDArray[np.uint8]]] = deque(maxlen=MOST_WAITING)
            depths: deque[tuple[int, bytes]] = deque(maxlen=MOST_WAITING)
            for packet in video.demux(colour, depth):
                if packet.stream is depth:
                    if packet.size:
                        depths.append((nanoseconds(packet), bytes(packet)))
                else:
                    for picture in packet.decode():
                        rgb = shrunk(picture.to_ndarray(format="rgb24"), self._factor)
                        images.append((nanoseconds(picture), rgb))
                while images and depths and depths[-1][0] >= images[0][0]:
                    yield from self._pair(*images.popleft(), depths)
            while images and depths:
                yield from self._pair(*images.popleft(), depths)

    def _pair(
        self, stamp_ns: int, rgb: NDArray[np.uint8], depths: deque[tuple[int, bytes]]
    ) -> Iterator[Frame]:
        """With the depth nearest in time, if that is near."""
        other, data = min(depths, key=lambda entry: abs(entry[0] - stamp_ns))
        if abs(other - stamp_ns) > TOGETHER_NS:
            return
        while depths and depths[0][0] < other:
            depths.popleft()
        height, width = self._shape
        if len(data) != 2 * height * width:
            raise Error(f"{self._path}: depth is not stored as 16-bit numbers", code=3)
        units = np.frombuffer(data, ">u2").reshape(height, width).astype(np.uint16)
        frame = Frame(stamp_ns, rgb, self._registration(metres(units, MILLIMETRES)))
        yield require_size(frame, self.camera, self._path)


def nanoseconds(item: Any) -> int:
    """The stamp of a packet or a frame."""
    stamp = int(round(item.pts * item.time_base * 1_000_000_000))
    if abs(stamp) > LATEST_NS:
        raise ValueError(f"stamp {stamp} ns: no time")
    return stamp

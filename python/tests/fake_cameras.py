# SPDX-License-Identifier: MIT
"""The drivers of three live cameras, played from a script: for tests without a device."""

from __future__ import annotations

import time
from datetime import timedelta
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

import edvo

RATE_NS = 33_333_333


class Script:
    """What a device does: a list of frames (indices), "late", "half" or an exception."""

    def __init__(self, frames: list[edvo.Frame], steps: list[Any]) -> None:
        self.frames, self.steps = frames, list(steps)
        self.started = self.ended = 0
        self.fault: Exception | None = None  # at the start

    def start(self) -> None:
        if self.fault is not None:
            raise self.fault
        self.started += 1

    def next(self, seconds: float) -> Any:
        if not self.steps:
            time.sleep(min(seconds, 0.02))
            return "late"
        step = self.steps.pop(0)
        if isinstance(step, Exception):
            raise step
        return step

    def rgb(self, i: int) -> Any:
        return self.frames[i].rgb

    def millimetres(self, i: int) -> Any:
        return np.nan_to_num(1000 * self.frames[i].depth).round().astype(np.uint16)


# --- pyrealsense2 -------------------------------------------------------------------------------


def fake_realsense(script: Script, size: tuple[int, int], lens: str = "none") -> ModuleType:
    rs: Any = ModuleType("pyrealsense2")
    rs.stream = SimpleNamespace(color="color", depth="depth")
    rs.format = SimpleNamespace(rgb8="rgb8", z16="z16")
    rs.distortion = SimpleNamespace(none="none", brown_conrady="bc", inverse_brown_conrady="ibc")
    rs.camera_info = SimpleNamespace(name="name")
    coeffs = [0.0] * 5 if lens == "none" else [0.1, 0.0, 0.0, 0.0, 0.0]
    intrinsics = SimpleNamespace(
        fx=300.0, fy=301.0, ppx=160.0, ppy=120.0, width=size[0], height=size[1],
        coeffs=coeffs, model=lens,
    )  # fmt: skip

    class Image:
        def __init__(self, data: Any, i: int) -> None:
            self.data, self.i = data, i

        def get_data(self) -> Any:
            return self.data

        def get_timestamp(self) -> float:  # [ms]
            return self.i * RATE_NS * 1e-6

    class Pipeline:
        def start(self, config: Any) -> Any:
            script.start()
            sensor = SimpleNamespace(get_depth_scale=lambda: np.float32(0.001))
            device = SimpleNamespace(
                first_depth_sensor=lambda: sensor, get_info=lambda _: "Intel RealSense D435"
            )
            video = SimpleNamespace(get_intrinsics=lambda: intrinsics)
            stream = SimpleNamespace(as_video_stream_profile=lambda: video)
            return SimpleNamespace(get_device=lambda: device, get_stream=lambda _: stream)

        def try_wait_for_frames(self, timeout_ms: int) -> tuple[bool, Any]:
            step = script.next(timeout_ms / 1000)
            return (False, None) if step == "late" else (True, step)

        def stop(self) -> None:
            script.ended += 1

    class Align:
        def __init__(self, to: str) -> None:
            assert to == "color"

        def process(self, step: Any) -> Any:
            if step == "half":
                return SimpleNamespace(get_color_frame=lambda: None, get_depth_frame=lambda: None)
            return SimpleNamespace(
                get_color_frame=lambda: Image(script.rgb(step), step),
                get_depth_frame=lambda: Image(script.millimetres(step), step),
            )

    class Config:
        def enable_device(self, serial: str) -> None:
            if serial != "123":
                raise RuntimeError(f"Couldn't resolve requests: {serial}")

        def enable_stream(self, *_: Any) -> None: ...

    rs.pipeline, rs.align, rs.config = Pipeline, Align, Config
    return rs  # type: ignore[no-any-return]


# --- depthai ------------------------------------------------------------------------------------


def fake_depthai(script: Script, size: tuple[int, int]) -> ModuleType:
    dai: Any = ModuleType("depthai")
    dai.CameraBoardSocket = SimpleNamespace(CAM_A="a", CAM_B="b", CAM_C="c")

    class Output:
        def __init__(self) -> None:
            self.linked: list[Any] = []

        def link(self, to: Any) -> None:
            self.linked.append(to)

        def createOutputQueue(self, maxSize: int, blocking: bool) -> Any:
            assert not blocking
            return SimpleNamespace(get=get)

    def get(timeout: timedelta) -> Any:
        step = script.next(timeout.total_seconds())
        if step == "late":
            return None
        stamp = timedelta(microseconds=step * RATE_NS // 1000)

        def image(data: Any) -> Any:
            return SimpleNamespace(getTimestamp=lambda: stamp, getFrame=lambda: data)

        return {"colour": image(script.rgb(step)), "depth": image(script.millimetres(step))}

    class Camera:
        def build(self, socket: str) -> Camera:
            return self

        def requestOutput(self, size: Any, **_: Any) -> Output:
            return Output()

    class StereoDepth:
        PresetMode = SimpleNamespace(ROBOTICS=1)

        def __init__(self) -> None:
            self.left = self.right = object()
            self.depth = Output()

        def setDefaultProfilePreset(self, preset: int) -> None: ...
        def setDepthAlign(self, socket: str) -> None: ...
        def setOutputSize(self, width: int, height: int) -> None: ...

    class Sync:
        def __init__(self) -> None:
            self.inputs = {"colour": object(), "depth": object()}
            self.out = Output()

        def setSyncThreshold(self, threshold: timedelta) -> None: ...

    class Device:
        def __init__(self, info: Any = None) -> None:
            script.start()

        def readCalibration(self) -> Any:
            k = [[300.0, 0, 160.0], [0, 301.0, 120.0], [0, 0, 1]]
            return SimpleNamespace(getCameraIntrinsics=lambda socket, w, h: k)

        def getDeviceName(self) -> str:
            return "OAK-D"

    class Pipeline:
        def __init__(self, device: Device) -> None: ...

        def create(self, node: Any) -> Any:
            return node()

        def start(self) -> None: ...

        def isRunning(self) -> bool:
            return True

        def stop(self) -> None:
            script.ended += 1

    dai.node = SimpleNamespace(Camera=Camera, StereoDepth=StereoDepth, Sync=Sync)
    dai.ImgFrame = SimpleNamespace(Type=SimpleNamespace(RGB888i=1))
    dai.Device, dai.DeviceInfo, dai.Pipeline = Device, lambda serial: serial, Pipeline
    return dai  # type: ignore[no-any-return]


# --- openni -------------------------------------------------------------------------------------


def fake_openni(script: Script, size: tuple[int, int]) -> ModuleType:
    ni: Any = ModuleType("openni.openni2")
    ni.PIXEL_FORMAT_RGB888, ni.PIXEL_FORMAT_DEPTH_1_MM = 1, 2
    ni.IMAGE_REGISTRATION_DEPTH_TO_COLOR = 1
    ni.initialize = script.start
    waiting: list[tuple[str, int]] = []

    class Stream:
        def __init__(self, kind: str) -> None:
            self.kind = kind

        def configure_mode(self, *_: int) -> None: ...
        def set_mirroring_enabled(self, enabled: bool) -> None: ...
        def start(self) -> None: ...

        def stop(self) -> None:
            script.ended += self.kind == "colour"

        def get_horizontal_fov(self) -> float:
            return 1.0

        def read_frame(self) -> Any:
            _, i = waiting.pop(0)
            return SimpleNamespace(
                timestamp=i * RATE_NS // 1000 + (1000 if self.kind == "depth" else 0),
                width=size[0],
                height=size[1],
                get_buffer_as_uint8=lambda: script.rgb(i).reshape(-1),
                get_buffer_as_uint16=lambda: script.millimetres(i).reshape(-1),
            )

    streams = {kind: Stream(kind) for kind in ("colour", "depth")}

    def wait_for_any_stream(wanted: list[Stream], timeout: float) -> Stream | None:
        if not waiting:
            step = script.next(timeout)
            if step == "late":
                return None
            waiting.extend([("depth", step)] if step == "half" else [("depth", step), ("colour", step)])
        return streams[waiting[0][0]]

    class Device:
        def __init__(self, uri: bytes | None) -> None:
            self.create_depth_stream = lambda: streams["depth"]
            self.create_color_stream = lambda: streams["colour"]

        def is_image_registration_mode_supported(self, mode: int) -> bool:
            return True

        def set_image_registration_mode(self, mode: int) -> None: ...
        def set_depth_color_sync_enabled(self, on: bool) -> None: ...

        def get_device_info(self) -> Any:
            return SimpleNamespace(name=b"Kinect")

        def close(self) -> None: ...

    ni.Device, ni.wait_for_any_stream = Device, wait_for_any_stream
    return ni  # type: ignore[no-any-return]

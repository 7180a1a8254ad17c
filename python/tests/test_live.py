# SPDX-License-Identifier: MIT
"""Cameras on fakes of their drivers, which give and raise what the drivers do."""

from __future__ import annotations

import importlib
import sys
import threading
import time
from collections.abc import Callable, Iterator
from datetime import timedelta
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import edvo
from edvo.cli import main
from edvo.sources import live

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


Make = Callable[[Script], None]
KINDS = ("realsense", "oak", "openni")


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def plug_in(
    kind: str, camera: edvo.Camera, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[[Script], None]]:
    size = (camera.width, camera.height)
    monkeypatch.setattr("edvo.sources.oak.SIZE", size)
    monkeypatch.setattr("edvo.sources.openni.WIDTH", size[0])
    monkeypatch.setattr("edvo.sources.openni.HEIGHT", size[1])
    monkeypatch.setattr(live, "WAIT", 0.02)
    monkeypatch.setattr(live, "SILENCE", 0.3)

    def plug(script: Script) -> None:
        if kind == "realsense":
            monkeypatch.setitem(sys.modules, "pyrealsense2", fake_realsense(script, size))
        elif kind == "oak":
            monkeypatch.setitem(sys.modules, "depthai", fake_depthai(script, size))
        else:
            package: Any = ModuleType("openni")
            package.openni2 = fake_openni(script, size)
            monkeypatch.setitem(sys.modules, "openni", package)

    yield plug


def take(source: edvo.Source, count: int) -> list[edvo.Frame]:
    taken = []
    for frame in source:
        taken.append(frame)
        if len(taken) == count:
            break
    return taken


def test_frames_have_the_drivers_stamps_and_units(
    kind: str, plug_in: Callable[[Script], None], frames: list[edvo.Frame]
) -> None:
    script = Script(frames, ["late", 0, 1, 1, 2])  # a driver repeats a frame
    plug_in(script)
    source = edvo.open_source(f"camera:{kind}")
    assert source.is_live and source.name == kind and source.origin
    taken = take(source, 3)
    assert [frame.stamp_ns for frame in taken] == pytest.approx([0, RATE_NS, 2 * RATE_NS], abs=1000)
    for frame, original in zip(taken, frames):
        assert np.array_equal(frame.rgb, original.rgb)
        known = np.isfinite(original.depth)
        assert np.abs(frame.depth - original.depth)[known].max() <= 0.0006
        assert np.isnan(frame.depth[~known]).all()
    assert script.ended == 1
    script.steps = [7]  # begun again: the camera goes on
    assert take(source, 1)[0].stamp_ns == pytest.approx(7 * RATE_NS, abs=1000)
    assert (script.started, script.ended) == (2, 2)


def test_a_run_ends_when_the_camera_is_unplugged_and_keeps_what_was_done(
    kind: str, plug_in: Callable[[Script], None], frames: list[edvo.Frame], camera: edvo.Camera
) -> None:
    words = {
        "realsense": "Frame didn't arrive within 5000",
        "oak": "Communication exception - possible device error/misconfiguration. Original message "
        "'Couldn't read data from stream: 'x' (X_LINK_ERROR)'",
        "openni": "(OniStatus.ONI_STATUS_ERROR, b'Device disconnected', None)",
    }
    plug_in(Script(frames, [*range(6), "late", RuntimeError(words[kind])]))
    with pytest.raises(edvo.Error) as caught:
        edvo.run(edvo.open_source(f"camera:{kind}", camera=camera))
    assert caught.value.code == 3 and words[kind] in str(caught.value)
    run = caught.value.run
    assert run is not None and run.tracked + run.counts["dropped"] == 6


def test_a_silent_camera_is_given_up_and_a_stopped_one_is_left(
    kind: str, plug_in: Callable[[Script], None], frames: list[edvo.Frame]
) -> None:
    plug_in(Script(frames, [0]))
    source = edvo.open_source(f"camera:{kind}")
    with pytest.raises(edvo.Error, match="no frame for 0.3 s"):
        take(source, 2)
    threading.Timer(0.1, source.stop).start()
    assert take(source, 1) == []


def test_no_device_is_said_as_the_driver_says_it(
    kind: str, plug_in: Callable[[Script], None], frames: list[edvo.Frame]
) -> None:
    script = Script(frames, [])
    script.fault = RuntimeError("No device connected")
    plug_in(script)
    expected = "libOpenNI2" if kind == "openni" else "No device connected"
    with pytest.raises(edvo.Error, match=expected) as caught:
        edvo.open_source(f"camera:{kind}")
    assert caught.value.code == 3 and str(caught.value).startswith(kind)


def test_a_missing_driver_gives_one_sentence_with_the_command(
    kind: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("pyrealsense2", "depthai", "openni"):
        monkeypatch.setitem(sys.modules, name, None)
    assert main(["run", f"camera:{kind}"]) == 2
    assert f"pip install 'edvo[{kind}]'" in capfd.readouterr().err


def test_what_is_no_camera_is_refused(tmp_path: Path) -> None:
    with pytest.raises(edvo.Error, match="camera:realsense, camera:oak, camera:openni"):
        edvo.open_source("camera:webcam")
    with pytest.raises(edvo.Error, match="says its units itself"):
        edvo.open_source("camera:oak", depth_scale=1000)


def test_an_incomplete_frame_and_an_unknown_lens_stop_nothing(
    frames: list[edvo.Frame], camera: edvo.Camera, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = Script(frames, ["half", 0, "half", 1])
    size = (camera.width, camera.height)
    monkeypatch.setitem(sys.modules, "pyrealsense2", fake_realsense(script, size, "ibc"))
    source = edvo.open_source("camera:realsense/123")
    assert "lens model" in source.warnings[0] and source.camera.distortion == (0.0,) * 8
    assert len(take(source, 2)) == 2
    with pytest.raises(edvo.Error, match="Couldn't resolve requests"):
        edvo.open_source("camera:realsense/9")


@pytest.mark.parametrize(
    ("module", "names"),
    [
        (
            "pyrealsense2",
            "config.enable_device config.enable_stream pipeline.start pipeline.try_wait_for_frames "
            "pipeline.stop align.process stream.color stream.depth format.rgb8 format.z16 "
            "distortion.none distortion.brown_conrady camera_info.name video_frame.get_timestamp",
        ),
        (
            "depthai",
            "node.Camera.build node.Camera.requestOutput node.StereoDepth.setDepthAlign "
            "node.StereoDepth.setOutputSize node.StereoDepth.PresetMode.ROBOTICS "
            "node.StereoDepth.setDefaultProfilePreset node.Sync.setSyncThreshold Device.readCalibration "
            "Device.getDeviceName Pipeline.create Pipeline.isRunning Pipeline.stop "
            "ImgFrame.Type.RGB888i ImgFrame.getFrame ImgFrame.getTimestamp MessageQueue.get "
            "CalibrationHandler.getCameraIntrinsics CameraBoardSocket.CAM_A",
        ),
        (
            "openni.openni2",
            "initialize wait_for_any_stream Device.create_depth_stream Device.create_color_stream "
            "Device.is_image_registration_mode_supported Device.set_image_registration_mode "
            "Device.set_depth_color_sync_enabled Device.get_device_info VideoStream.configure_mode "
            "VideoStream.set_mirroring_enabled VideoStream.get_horizontal_fov VideoStream.read_frame "
            "VideoFrame.get_buffer_as_uint8 VideoFrame.get_buffer_as_uint16 PIXEL_FORMAT_DEPTH_1_MM",
        ),
    ],
)
def test_the_drivers_have_what_the_fakes_have(module: str, names: str) -> None:
    pytest.importorskip(module.split(".")[0])
    driver = importlib.import_module(module)
    for name in names.split():
        place: Any = driver
        for part in name.split("."):
            assert hasattr(place, part), name
            place = getattr(place, part)

# SPDX-License-Identifier: MIT
"""Cameras on fakes of their drivers, which give and raise what the drivers do."""

from __future__ import annotations

import importlib
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from fake_cameras import RATE_NS, Script, fake_depthai, fake_openni, fake_realsense

import edvo
from edvo.cli import main
from edvo.sources import live

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

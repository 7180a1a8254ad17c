# SPDX-License-Identifier: MIT
"""An Azure Kinect's recording, written by an independent library."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import edvo
from edvo.sources import AzureSource
from edvo.sources.azure import camera_of

av = pytest.importorskip("av")
if not hasattr(av.container.OutputContainer, "add_attachment"):
    pytest.skip("this PyAV writes no attachments", allow_module_level=True)

COLOUR = (1280, 720)  # of a sensor of 4:3: 120 rows are cut off above and below
DEPTH = (640, 576)
BASELINE = 0.032  # [m]


def location(name: str, camera: list[float], translation: list[float]) -> dict[str, Any]:
    cx, cy, fx, fy = camera
    return {
        "Location": f"CALIBRATION_CameraLocation{name}",
        "Intrinsics": {"ModelParameters": [cx, cy, fx, fy, *[0.0] * 10]},
        "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "Translation": translation},
    }


CALIBRATION = {
    "CalibrationInformation": {
        "Cameras": [
            location("D0", [0.5, 0.5, 0.49, 0.49], [0.0, 0.0, 0.0]),
            location("PV0", [0.5, 0.5, 0.48, 0.64], [-BASELINE, 0.0, 0.0]),
        ]
    }
}


def record(
    file: Path, count: int = 4, titles: tuple[str, str] = ("COLOR", "DEPTH"), calibration: Any = CALIBRATION
) -> Path:
    """A wall at 1 m, whose colour says which frame it is."""
    with av.open(str(file), "w", options={"allow_raw_vfw": "1"}) as out:
        video = out.add_stream("mjpeg", rate=30)
        video.width, video.height, video.pix_fmt = *COLOUR, "yuvj420p"
        depth = out.add_stream("rawvideo", rate=30)
        depth.width, depth.height, depth.pix_fmt = *DEPTH, "gray16be"
        for stream, title in zip((video, depth), titles):
            stream.metadata["title"] = title
            stream.codec_context.time_base = Fraction(1, 1000)
        if calibration is not None:
            data = calibration if isinstance(calibration, bytes) else json.dumps(calibration).encode()
            out.add_attachment("calibration.json", "application/octet-stream", data)
        for i in range(count):
            pixels = np.full((COLOUR[1], COLOUR[0], 3), 40 * i + 20, np.uint8)
            units = np.full((DEPTH[1], DEPTH[0]), 1000 + i, ">u2")
            picture = av.VideoFrame.from_ndarray(pixels, format="rgb24")
            image = av.VideoFrame(*DEPTH, "gray16be")
            image.planes[0].update(units.tobytes())
            for stream, frame, stamp in ((depth, image, 33 * i + 3), (video, picture, 33 * i)):
                frame.pts, frame.time_base = stamp, Fraction(1, 1000)
                for packet in stream.encode(frame):
                    out.mux(packet)
        for stream in (video, depth):
            for packet in stream.encode():
                out.mux(packet)
    return file


def test_colour_and_depth_come_back_registered(tmp_path: Path) -> None:
    source = edvo.open_source(record(tmp_path / "kinect.mkv"))
    assert isinstance(source, AzureSource) and source.name == "kinect"
    # 1280 x 720 is shrunk by 2; the principal point of the whole sensor is its middle.
    assert (source.camera.width, source.camera.height) == (640, 360)
    assert source.camera.cx == pytest.approx(319.5) and source.camera.cy == pytest.approx(179.5)
    assert source.camera.fx == pytest.approx(0.48 * 640) and source.camera.fy == pytest.approx(0.64 * 480)
    assert "baseline 32.0 mm" in source.notes[0]
    frames = list(source)
    assert [frame.stamp_ns for frame in frames] == [0, 33_000_000, 66_000_000, 99_000_000]
    for i, frame in enumerate(frames):
        assert abs(float(np.median(frame.rgb)) - (40 * i + 20)) <= 3
        assert float(np.nanmedian(frame.depth)) == pytest.approx(1.0 + i / 1000, abs=1e-6)
    # The wall reaches beyond the colour image above and below, and its middle has no hole.
    assert np.isfinite(frames[0].depth[100:260, 200:440]).mean() > 0.99


def test_the_modes_cut_the_sensor() -> None:
    entry = location("D0", [0.5, 0.5, 0.49, 0.49], [0, 0, 0])
    narrow = camera_of(entry, 640, 576, is_depth=True)
    assert (narrow.fx, narrow.cx, narrow.cy) == (0.49 * 1024, 512 - 192 - 0.5, 512 - 180 - 0.5)
    binned = camera_of(entry, 320, 288, is_depth=True)
    assert binned.fx == narrow.fx / 2
    assert binned.cx + 0.5 == pytest.approx((narrow.cx + 0.5) / 2)
    with pytest.raises(edvo.Error, match="no mode"):
        camera_of(entry, 641, 576, is_depth=True)


def test_what_is_no_such_recording_is_said_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "noise.mkv").write_bytes(b"no video at all" * 100)
    with pytest.raises(edvo.Error, match="cannot be read"):
        edvo.open_source(tmp_path / "noise.mkv")
    with pytest.raises(edvo.Error, match="cannot be read"):
        edvo.open_source(tmp_path / "none.mkv")
    with pytest.raises(edvo.Error, match="no tracks COLOR and DEPTH"):
        edvo.open_source(record(tmp_path / "film.mkv", titles=("a", "b")))
    for name, calibration, message in (
        ("a", None, "no calibration.json"),
        ("b", b"{", "damaged"),
        ("c", {"CalibrationInformation": {"Cameras": []}}, "damaged"),
    ):
        with pytest.raises(edvo.Error, match=message) as caught:
            edvo.open_source(record(tmp_path / f"{name}.mkv", calibration=calibration))
        assert caught.value.code == 5
    with pytest.raises(edvo.Error, match="says its units"):
        edvo.open_source(tmp_path / "film.mkv", depth_scale=1000)

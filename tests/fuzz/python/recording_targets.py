# SPDX-License-Identifier: MIT
"""Recordings of phones and of the Azure Kinect."""

from __future__ import annotations

import io
import json
import zipfile
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import av
import liblzfse
import numpy as np

from checks import check_source
from samples import DEPTH_PNG, HEIGHT, JPEG, METRES, RGB, WIDTH, Folder, exr, frames
from target import Target

META = {
    "w": WIDTH, "h": HEIGHT, "dw": WIDTH, "dh": HEIGHT, "fps": 30, "K": [15, 0, 0, 0, 15, 0, 7.5, 5.5, 1],
    "poses": [[0, 0, 0, 1, i, 0, 0] for i in range(2)], "frameTimestamps": [5.0, 5.1],
}  # fmt: skip
METADATA = json.dumps(META).encode()
R3D = Folder(
    {
        "metadata": METADATA,
        **frames("rgbd/{i}.jpg", JPEG),
        **frames("rgbd/{i}.depth", liblzfse.compress(METRES.tobytes())),
    }
)


def zipped(files: dict[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return stream.getvalue()


def test_r3d(data: bytes, folder: Path) -> None:
    """A right archive of which one file is not."""
    test_r3d_zip(zipped(R3D.with_one_replaced(data)), folder)


def test_r3d_zip(data: bytes, folder: Path) -> None:
    (folder / "phone.r3d").write_bytes(data)
    check_source(folder / "phone.r3d")


def r3d_seeds(folder: Path) -> list[bytes]:
    bomb = 300 * liblzfse.compress(bytes(1 << 20))[:-4] + b"bvx$"  # 300 MiB
    shapes = {key: value for key, value in META.items() if key not in ("dw", "dh", "frameTimestamps")}
    return [*R3D.seeds(), b"\3" + bomb, b"\0" + json.dumps(shapes).encode()]


@cache
def exr_folder(folder: Path) -> Folder:
    images = {**frames("rgb/{i}.jpg", JPEG), **frames("depth/{i}.exr", exr(folder, METRES.astype(np.float16)))}
    return Folder({"metadata.json": METADATA, **images})


def test_r3d_exr(data: bytes, folder: Path) -> None:
    files = exr_folder(folder)
    files.write(data, folder)
    check_source(folder)


def video(width: int = WIDTH, height: int = HEIGHT) -> bytes:
    stream = io.BytesIO()
    with av.open(stream, "w", format="mp4") as out:
        track: Any = out.add_stream("mpeg4", rate=30)
        track.width, track.height, track.pix_fmt = width, height, "yuv420p"
        for _ in range(2):
            picture = np.ascontiguousarray(np.resize(RGB, (height, width, 3)))
            out.mux(track.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        out.mux(track.encode())
    return stream.getvalue()


STRAY = Folder(
    {
        "rgb.mp4": video(),
        "camera_matrix.csv": b"15,0,7.5\n0,15,5.5\n0,0,1\n",
        "odometry.csv": b"timestamp, frame, x, y, z, qx, qy, qz, qw\n"
        b"1.0, 0, 0, 0, 0, 0, 0, 0, 1\n1.1, 1, 0.5, 0, 0, 0, 0, 0, 1\n",
        **frames("depth/{i:06}.png", DEPTH_PNG),
    }
)


def test_stray(data: bytes, folder: Path) -> None:
    STRAY.write(data, folder)
    check_source(folder)


def location(name: str, x: float) -> dict[str, Any]:
    return {
        "Location": f"CALIBRATION_CameraLocation{name}",
        "Intrinsics": {"ModelParameters": [0.5, 0.5, 0.49, 0.6, *[0.0] * 10]},
        "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "Translation": [x, 0.0, 0.0]},
    }


CAMERAS = {"CalibrationInformation": {"Cameras": [location("D0", 0.0), location("PV0", -0.03)]}}
DEPTH_SIZE = (320, 288)  # the smallest of its modes


def kinect(file: Path, calibration: bytes) -> None:
    with av.open(str(file), "w", format="matroska", options={"allow_raw_vfw": "1"}) as out:
        colour: Any = out.add_stream("mjpeg", rate=30)
        colour.width, colour.height, colour.pix_fmt = WIDTH, HEIGHT, "yuvj420p"
        depth: Any = out.add_stream("rawvideo", rate=30)
        depth.width, depth.height, depth.pix_fmt = *DEPTH_SIZE, "gray16be"
        for stream, title in ((colour, "COLOR"), (depth, "DEPTH")):
            stream.metadata["title"] = title
            stream.codec_context.time_base = Fraction(1, 1000)
        out.add_attachment("calibration.json", "application/octet-stream", calibration)
        pixels = av.VideoFrame.from_ndarray(RGB, format="rgb24")
        units = av.VideoFrame(*DEPTH_SIZE, "gray16be")
        units.planes[0].update(np.full(DEPTH_SIZE, 1000, ">u2").tobytes())
        for stream, frame, stamp in ((depth, units, 3), (colour, pixels, 0)):
            frame.pts, frame.time_base = stamp, Fraction(1, 1000)
            out.mux(stream.encode(frame))
        for stream in (colour, depth):
            out.mux(stream.encode())


def test_mkv(data: bytes, folder: Path) -> None:
    (folder / "kinect.mkv").write_bytes(data)
    check_source(folder / "kinect.mkv")


def mkv_seeds(folder: Path) -> list[bytes]:
    kinect(folder / "kinect.mkv", json.dumps(CAMERAS).encode())
    return [(folder / "kinect.mkv").read_bytes()]


def test_mkv_calibration(data: bytes, folder: Path) -> None:
    kinect(folder / "kinect.mkv", data)
    check_source(folder / "kinect.mkv")


TARGETS = {
    "r3d": Target(test_r3d, r3d_seeds),
    "r3d_zip": Target(test_r3d_zip, lambda _: [zipped(R3D.files)]),
    "r3d_exr": Target(test_r3d_exr, lambda folder: exr_folder(folder).seeds()),
    "stray": Target(test_stray, lambda _: STRAY.seeds()),
    "mkv": Target(test_mkv, mkv_seeds),
    "mkv_calibration": Target(test_mkv_calibration, lambda _: [json.dumps(CAMERAS).encode()]),
}

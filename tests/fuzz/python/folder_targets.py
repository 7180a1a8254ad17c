# SPDX-License-Identifier: MIT
"""Folders of images as the data sets have them, and stamps in names."""

from __future__ import annotations

import json
from pathlib import Path

import edvo
from checks import LATEST_NS, attempt, check_source, require
from edvo.sources.image_stamps import have_stamps, pair_by_name
from samples import CAMERA, DEPTH_PNG, HEIGHT, JPEG, METRES, PNG, RGB, UNITS, WIDTH, Folder, encoded, frames, npy
from target import Target

MATRIX = b"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
MATRICES = b"".join(MATRIX.replace(b"\n", b" ") + b"\n" for _ in range(2))
POSES = b"1.0 0 0 0 0 0 0 1\n1.1 1 0 0 0 0 0 1\n"
K = {"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": [15, 0, 0, 0, 15, 0, 7.5, 5.5, 1]}
OPEN3D = json.dumps(K).encode()
LISTS = {
    "rgb.txt": b"1.0 rgb/0.png\n1.1 rgb/1.png\n",
    "depth.txt": b"1.0 depth/0.png\n1.1 depth/1.png\n",
    "groundtruth.txt": POSES,
}
PAIRS = {**frames("rgb/{i}.png", PNG), **frames("depth/{i}.png", DEPTH_PNG)}
# Those that the C++ library reads for Python.
LAYOUTS = {
    "tum": Folder({**LISTS, "camera.toml": CAMERA, **PAIRS}),
    "eth3d": Folder({**LISTS, "calibration.txt": b"15 15 7.5 5.5\n", **PAIRS}),
    "association": Folder({"assoc.txt": b"1.0 rgb/0.png 1.0 depth/0.png\n", "camera.toml": CAMERA, **PAIRS}),
    "seven_scenes": Folder(
        {
            **frames("frame-{i:06}.color.png", PNG),
            **frames("frame-{i:06}.depth.png", DEPTH_PNG),
            **frames("frame-{i:06}.pose.txt", MATRIX),
            "intrinsics.txt": b"15 15 7.5 5.5",
        }
    ),
    "bundlefusion": Folder(
        {
            **frames("frame-{i:06}.color.jpg", JPEG),
            **frames("frame-{i:06}.depth.png", DEPTH_PNG),
            **frames("frame-{i:06}.pose.txt", MATRIX),
            "info.txt": b"m_calibrationColorIntrinsic = 15 0 7.5 0 0 15 5.5 0 0 0 1 0 0 0 0 1\n",
            "camera.toml": CAMERA,
        }
    ),
    "replica": Folder(
        {
            **frames("results/frame{i:06}.png", PNG),
            **frames("results/depth{i:06}.png", DEPTH_PNG),
            "traj.txt": MATRICES,
            "results/camera.toml": CAMERA,
        }
    ),
    "scannet": Folder(
        {
            **frames("color/{i}.jpg", JPEG),
            **frames("depth/{i}.png", DEPTH_PNG),
            **frames("pose/{i}.txt", MATRIX),
            "intrinsic/intrinsic_color.txt": b"15 0 7.5 0\n0 15 5.5 0\n0 0 1 0\n0 0 0 1\n",
            "intrinsic/intrinsic_depth.txt": b"15 0 7.5 0\n0 15 5.5 0\n0 0 1 0\n0 0 0 1\n",
        }
    ),
    "redwood": Folder(
        {
            **frames("image/{i:06}.jpg", JPEG),
            **frames("depth/{i:06}.png", DEPTH_PNG),
            "camera_primesense.json": OPEN3D,
        }
    ),
    "open3d": Folder(
        {
            **frames("color/{i:06}.png", PNG),
            **frames("depth/{i:06}.png", DEPTH_PNG),
            "camera_intrinsic.json": OPEN3D,
        }
    ),
    "nyu_raw": Folder({"d-1.5-2.pgm": b"P5", "r-1.5-2.ppm": b"P6"}),
}
# Those that Python reads itself.
OTHERS = {
    "other_formats": Folder(
        {
            **frames("rgb/{i}.ppm", encoded(".ppm", RGB)),
            **frames("depth/{i}.tiff", encoded(".tiff", METRES)),
            "camera.toml": CAMERA + b"depth_scale = 5000\n",
            "groundtruth.txt": POSES,
        }
    ),
    "numpy": Folder(
        {
            **frames("images/{i}.bmp", encoded(".bmp", RGB)),
            **frames("depth_images/{i}.npy", npy(UNITS)),
            "camera.yaml": b"Camera.fx: 15\nCamera.fy: 15\nCamera.cx: 7.5\nCamera.cy: 5.5\nDepthMapFactor: 5000\n",
        }
    ),
    "stamps": Folder(
        {
            **frames("rgb/170000000000{i}.png", PNG),
            **frames("depth/170000000000{i}.png", DEPTH_PNG),
            "calibration.txt": b"15 15 7.5 5.5\n",
        }
    ),
}


def layout_seeds(layouts: dict[str, Folder]) -> list[bytes]:
    return [bytes([i]) + seed for i, layout in enumerate(layouts.values()) for seed in layout.seeds()]


def check_layout(layouts: dict[str, Folder], data: bytes, folder: Path) -> None:
    chosen = list(layouts.values())[data[0] % len(layouts) if data else 0]
    chosen.write(data[1:], folder)
    check_source(folder)
    lens = edvo.Camera(15, 15, 7.5, 5.5, WIDTH, HEIGHT)
    check_source(folder, depth_camera=lens)  # depth is registered in Python then


def test_stamps(data: bytes, folder: Path) -> None:
    """Names of colour images, an empty line, names of depth images."""
    lists = [part.split(b"\n") for part in data.replace(b"\0", b"").split(b"\n\n", 1)]
    colours, depths = ([folder / f"{n.decode('utf-8', 'replace')}.png" for n in names] for names in (lists * 2)[:2])
    if not have_stamps(colours, depths):
        return
    found = attempt(lambda: pair_by_name(colours, depths), folder.name)
    for stamp, _, _ in found[0] if found else ():
        require(isinstance(stamp, int) and abs(stamp) < LATEST_NS, f"stamp {stamp}")


STAMPS = [
    b"1305031102.175304\n1305031102.211214\n\n1305031102.160407\n1305031102.226738",
    b"1700000000000\n1700000000033\n\n1700000000001\n1700000000030",
    b"1700000000000000000\n\n1700000000000000001",
]


TARGETS = {
    "layouts": Target(lambda data, folder: check_layout(LAYOUTS, data, folder), lambda _: layout_seeds(LAYOUTS)),
    "pairs": Target(lambda data, folder: check_layout(OTHERS, data, folder), lambda _: layout_seeds(OTHERS)),
    "stamps": Target(test_stamps, lambda _: STAMPS),
}

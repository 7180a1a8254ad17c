# SPDX-License-Identifier: MIT
"""Single files: images that only Python reads, cameras, trajectories, archives; runs' folders and
what servers answer."""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import requests

import edvo
from checks import attempt, check_camera, check_source, check_trajectory, require
from edvo import pulling
from edvo.cli import source_options
from edvo.finished_run import log_run
from edvo.rerun_log import Log
from edvo.sources.image_files import read_colour, read_depth
from edvo.view import open_sinks
from samples import (
    CAMERA, DEPTH_PNG, HEIGHT, JPEG, METRES, PNG, RGB, UNITS, WIDTH, Folder, encoded, exr, huge_png, npy,
)  # fmt: skip
from target import Target

COLOURS = (".png", ".jpg", ".ppm", ".tif", ".bmp")
DEPTHS = (".png", ".pgm", ".tiff", ".exr", ".npy")


def image_seeds(folder: Path) -> list[bytes]:
    colours = (PNG, JPEG, *(encoded(suffix, RGB) for suffix in COLOURS[2:]))
    tiff = encoded(".tiff", METRES)
    depths = (DEPTH_PNG, encoded(".pgm", UNITS), tiff, exr(folder, METRES), npy(METRES))
    seeds = [bytes([i]) + data for i, data in enumerate((*colours, *depths))]
    seeds += [b"\2P6\n30000 30000\n255\n", b"\6P5 # of few bytes\n99999 99999 65535\n"]
    seeds += [b"\3" + huge_png(30000), b"\x07" + huge_png(30000), b"\x09" + npy(np.zeros(3, object))]
    seeds += [b"\x07" + encoded(".tiff", UNITS), b"\x09" + npy(METRES[:, :0]), b"\x09" + npy(METRES[:1, 0])]
    return seeds


def test_image(data: bytes, folder: Path) -> None:
    suffixes = (*COLOURS, *DEPTHS)
    chosen = data[0] % len(suffixes) if data else 0
    file = folder / f"0{suffixes[chosen]}"
    file.write_bytes(data[1:])
    if chosen < len(COLOURS):
        image = attempt(lambda: read_colour(file), file.name)
        if image is not None:
            require(image.dtype == np.uint8 and image.ndim == 3 and image.shape[2] == 3, "colour")
            require(image.size > 0, "no pixels")
        return
    image = attempt(lambda: read_depth(file), file.name)
    if image is not None:
        require(image.dtype in (np.uint16, np.float32) and image.ndim == 2, f"depth {image.shape}")
        require(image.size > 0, "no pixels")


def test_camera(data: bytes, folder: Path) -> None:
    suffixes = (".toml", ".yaml", ".json", ".txt")
    file = folder / f"camera{suffixes[data[0] % len(suffixes) if data else 0]}"
    file.write_bytes(data[1:])
    camera = attempt(lambda: edvo.Camera.read(file, WIDTH, HEIGHT), file.name)
    if camera is not None:
        check_camera(camera)
        attempt(lambda: check_camera(camera.scaled_to(2 * WIDTH, 2 * HEIGHT)), "")
        back = folder / "again.toml"
        back.write_text(camera.to_toml(), encoding="utf-8")
        require(edvo.Camera.read(back) == camera, "written and read it is another camera")
    options: Any = attempt(lambda: source_options({"--colour-from-depth": str(file)}), file.name)
    require(options is None or options["colour_from_depth"].shape == (4, 4), "no matrix")


def camera_seeds(folder: Path) -> list[bytes]:
    k = [15, 0, 0, 0, 15, 0, 7.5, 5.5, 1]
    opencv = b"%YAML:1.0\n---\nimage_width: 16\nimage_height: 12\ncamera_matrix: !!opencv-matrix\n" \
             b"   rows: 3\n   cols: 3\n   dt: d\n   data: [ 15., 0., 7.5, 0., 15., 5.5, 0., 0., 1. ]\n"
    return [
        b"\0" + CAMERA,
        b"\1" + opencv,
        b"\2" + json.dumps({"width": 16, "height": 12, "intrinsic_matrix": k}).encode(),
        b"\3" + b"15 15 7.5 5.5\n",
        b"\3" + b"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
    ]


TUM = b"1.0 0 0 0 0 0 0 1\n1.1 1 0 0 0 0 0 1\n1.2 1 1 0 0 0 0 1\n"
EUROC = b"#timestamp, p\n1403636579000000000,0,0,0,1,0,0,0\n1403636579100000000,1,0,0,1,0,0,0\n"


def test_trajectory(data: bytes, folder: Path) -> None:
    file = folder / ("path.csv" if data[:1] == b"\1" else "path.tum")
    file.write_bytes(data[1:])
    trajectory = attempt(lambda: edvo.Trajectory.read(file), file.name)
    if trajectory is None:
        return
    check_trajectory(trajectory)
    attempt(lambda: edvo.evaluate(trajectory, trajectory), "")
    for suffix in (".tum", ".csv", ".kitti"):
        trajectory.write(folder / f"again{suffix}")
    if len(trajectory) and trajectory.stamps_ns[0] > 10**18:  # by their size they are nanoseconds
        again = edvo.Trajectory.read(folder / "again.csv")
        require((again.stamps_ns == trajectory.stamps_ns).all(), "written and read it has other stamps")


def zip_of(entries: dict[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name or "none", content)
    return stream.getvalue()


def zip_seeds(folder: Path) -> list[bytes]:
    pairs = {"a/rgb/0.ppm": encoded(".ppm", RGB), "a/depth/0.tiff": encoded(".tiff", METRES)}
    return [zip_of({**pairs, "a/camera.toml": CAMERA}), zip_of({"walk.mcap": b"none", "__MACOSX/x": b""})]


def test_zip(data: bytes, folder: Path) -> None:
    file = folder / "walk.zip"
    file.write_bytes(data)
    check_source(file)
    names = {path.name for path in folder.iterdir()}
    require(names <= {file.name, "cache"}, f"unpacked beside its folder: {names}")


def test_zip_entries(data: bytes, folder: Path) -> None:
    """Names and contents of entries in turn, of a zip that is itself right."""
    fields = data.split(b"\0")
    names = [field.decode("utf-8", "replace") for field in fields[::2]]
    names = [re.sub(r"\s", "_", name) for name in names]  # errors quote names as they are
    test_zip(zip_of(dict(zip(names, fields[1::2]))), folder)


def entry_seeds(folder: Path) -> list[bytes]:
    camera = b"camera.toml\0fx = 1\nfy = 1\ncx = 0\ncy = 0\n"
    return [camera + b"\0rgb/0.ppm\0P6 1 1 255 \1\1\1\0depth/0.pgm\0P5 1 1 65535 \1\1", b"../x.npy\0x\0/y.npy\0y"]


FRAME = {
    "index": 0, "stamp": "1.0", "status": "tracked", "keyframe_reason": "first", "loss_cause": None,
    "pose": [0, 0, 0, 0, 0, 0, 1], "inlier_ratio": 0.9, "overlap": 1.0, "ms": {"total": 3.0},
}  # fmt: skip
SKIPPED = {"index": 1, "stamp": "1.1", "status": "skipped", "reason": "cut off"}
RUN = Folder(
    {
        "frames.jsonl": "".join(json.dumps(line) + "\n" for line in (FRAME, SKIPPED)).encode(),
        "trajectory.tum": TUM,
        "keyframes.tum": TUM,
        "summary.json": json.dumps({"evaluation": {"ground_truth": "groundtruth.txt"}}).encode(),
    }
)


@cache
def log() -> Log:
    """One for all: each keeps threads of its own until the end."""
    made = Log()
    open_sinks(made.out, os.devnull, live=False, with_images=False)
    return made


def test_run_folder(data: bytes, folder: Path) -> None:
    RUN.write(data, folder)
    attempt(lambda: log_run(log(), folder), folder.name)


class Answer:
    """What a server answers: a status, headers and a body."""

    def __init__(self, data: bytes) -> None:
        status, length, tag, self._body = (data.split(b"\n", 3) + [b""] * 4)[:4]
        self.status_code = int.from_bytes(status[:2], "big") % 600
        self.reason = "because"
        named = {"Content-Length": length, "ETag": tag}
        self.headers = {name: value.decode("latin-1") for name, value in named.items() if value}

    def __enter__(self) -> Answer:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def raise_for_status(self) -> None:
        if self.status_code >= 400:
            raise requests.HTTPError(response=self)

    def iter_content(self, size: int) -> Iterator[bytes]:
        for i in range(0, len(self._body), size):
            yield self._body[i : i + size]


NOTES = (".sha256", ".part", ".part.tag", "")  # beside what is pulled, and itself


def test_pull(data: bytes, folder: Path) -> None:
    """A download, with one file of an earlier one."""
    name = "tum/fr1/xyz"
    item = pulling.known_items()[name]
    note, _, answer = data[1:].partition(b"\0")
    item.file.parent.mkdir(parents=True)
    if data:
        item.file.with_name(item.file.name + NOTES[data[0] % len(NOTES)]).write_bytes(note)
        if data[0] % len(NOTES) == 0:
            item.file.write_bytes(b"x")
    with mock.patch("requests.get", lambda *_, **__: Answer(answer)), mock.patch("time.sleep"):
        file = attempt(lambda: pulling.pull(name, quiet=True), item.file.name)
    require(file is None or file.is_file(), "not there")


def pull_seeds(folder: Path) -> list[bytes]:
    ok = (200).to_bytes(2, "big")
    return [
        b"\1\0" + ok + b'\n3\n"tag"\nabc',
        b"\2xyz\0" + (206).to_bytes(2, "big") + b'\n3\n"tag"\nabc',
        b"\0" + b"0" * 64 + b"\0" + ok,
        b"\1ab\0" + (416).to_bytes(2, "big") + b"\n\n\n",
    ]


TARGETS = {
    "images": Target(test_image, image_seeds),
    "camera": Target(test_camera, camera_seeds),
    "trajectory": Target(test_trajectory, lambda _: [b"\0" + TUM, b"\1" + EUROC]),
    "zip": Target(test_zip, zip_seeds),
    "zip_entries": Target(test_zip_entries, entry_seeds),
    "run_folder": Target(test_run_folder, lambda _: RUN.seeds()),
    "pull": Target(test_pull, pull_seeds),
}

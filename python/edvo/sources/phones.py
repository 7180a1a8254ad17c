# SPDX-License-Identifier: MIT
"""Recordings of phones with a depth sensor: Record3D and Stray Scanner."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Callable, Iterator
from itertools import count, takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error
from edvo.registration import DepthRegistration
from edvo.sources import lzfse
from edvo.sources.base import Frame, Source, metres, require_size
from edvo.sources.image_files import decode_image, opencv, read_depth
from edvo.sources.listed import Entry, ListedSource, shrunk
from edvo.sources.untrusted import LARGEST_FILE, MOST_PIXELS, check_pixels, reading
from edvo.sources.videos import open_video
from edvo.stamp import from_seconds
from edvo.trajectory import Trajectory

WIDEST = 960  # [px]; larger colour images are shrunk by a whole factor
# ARKit's camera looks along -z with y up; ours along z with y down.
ARKIT = np.diag([1.0, -1.0, -1.0, 1.0])


def shrunk_camera(camera: Camera, factor: int) -> Camera:
    width, height = camera.width // factor, camera.height // factor
    cut = Camera(
        camera.fx, camera.fy, camera.cx, camera.cy, width * factor, height * factor
    )
    return cut.scaled_to(width, height)


class Files:
    """A folder or a zip archive (.r3d)."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with reading(path):
            self._zip = None if path.is_dir() else zipfile.ZipFile(path)
            self._names = set(self._zip.namelist()) if self._zip is not None else set()

    def read(self, name: str) -> bytes:
        with reading(self._path / name):
            if self._zip is None:
                return (self._path / name).read_bytes()
            size = self._zip.getinfo(name).file_size
            if size > LARGEST_FILE:
                raise ValueError(f"{size} bytes, at most {LARGEST_FILE} are read")
            return self._zip.read(name)

    def has(self, name: str) -> bool:
        if self._zip is not None:
            return name in self._names
        return (self._path / name).is_file()


def is_record3d(path: Path) -> bool:
    if path.is_file() and path.suffix == ".r3d":
        return True
    is_unpacked = (path / "metadata").is_file() and (path / "rgbd").is_dir()
    return path.is_dir() and (is_unpacked or is_record3d_exr(path))


def is_record3d_exr(path: Path) -> bool:
    has_images = (path / "rgb").is_dir() and next((path / "depth").glob("*.exr"), None) is not None
    return has_images and (path / "metadata.json").is_file()


def decode_jpeg(data: bytes, file: Path) -> NDArray[np.uint8]:
    bgr = decode_image(np.frombuffer(data, np.uint8), opencv().IMREAD_COLOR, file)
    return np.ascontiguousarray(bgr[:, :, ::-1], np.uint8)


def exr_numbers(path: Path) -> list[int]:
    """Of the frames that have both images."""
    stems = (file.stem for file in (path / "depth").glob("*.exr"))
    return sorted(int(s) for s in stems if s.isdecimal() and (path / f"rgb/{s}.jpg").is_file())


def archive_numbers(files: Files) -> list[int]:
    return list(takewhile(lambda i: files.has(f"rgbd/{i}.jpg"), count()))


def depth_bytes(files: Files, path: Path, i: int) -> bytes:
    with reading(path / f"rgbd/{i}.depth"):
        return lzfse.decompress(files.read(f"rgbd/{i}.depth"), 4 * MOST_PIXELS)


def depth_size_of(files: Files, path: Path, meta: dict[str, Any], number: int) -> tuple[int, int]:
    """Height and width: of an EXR, as the metadata say, or of colour's proportions."""
    if is_record3d_exr(path):
        height, width = read_depth(path / f"depth/{number}.exr").shape
        return int(height), int(width)
    stated = (int(meta.get("dh", 0)), int(meta.get("dw", 0)))
    if 0 not in stated:
        return stated
    width, height = int(meta["w"]), int(meta["h"])
    pixels = len(depth_bytes(files, path, 0)) // 4
    ratio = round((pixels / (width * height)) ** -0.5, 6)
    return round(height / ratio), round(width / ratio)


def open_record3d(path: Path) -> ListedSource:
    """rgbd/N.jpg, rgbd/N.depth (LZFSE, float32 [m]), metadata (JSON); or as exported with EXR:
    rgb/N.jpg, depth/N.exr [m], metadata.json, of which images may be missing.
    """
    with reading(path):
        return read_record3d(path, Files(path))


def read_record3d(path: Path, files: Files) -> ListedSource:
    is_exr = is_record3d_exr(path)
    meta = json.loads(files.read("metadata.json" if is_exr else "metadata"))
    k = np.array(meta["K"], float).reshape(3, 3).T
    width, height = int(meta["w"]), int(meta["h"])
    check_pixels(path, width, height)
    camera = Camera(k[0, 0], k[1, 1], k[0, 2], k[1, 2], width, height)
    colours = "rgb" if is_exr else "rgbd"
    numbers = exr_numbers(path) if is_exr else archive_numbers(files)
    if not numbers:
        raise Error(f"{path}: Record3D's metadata, but no {colours}/0.jpg", code=3)
    depth_size = depth_size_of(files, path, meta, numbers[0])
    check_pixels(path, depth_size[1], depth_size[0])
    factor = max(1, -(-max(width, height) // WIDEST))
    camera = shrunk_camera(camera, factor)
    depth_camera = camera.scaled_to(depth_size[1], depth_size[0])

    def colour(i: int) -> Callable[[], NDArray[np.uint8]]:
        name = f"{colours}/{i}.jpg"
        return lambda: shrunk(decode_jpeg(files.read(name), path / name), factor)

    def depth(i: int) -> Callable[[], NDArray[np.float32]]:
        def read() -> NDArray[np.float32]:
            if is_exr:
                return metres(read_depth(path / f"depth/{i}.exr"), 1.0)
            with reading(path / f"rgbd/{i}.depth"):
                values = np.frombuffer(depth_bytes(files, path, i), np.float32)
                return metres(values.reshape(depth_size), 1.0)

        return read

    stamps = meta.get("frameTimestamps")
    if not stamps:
        period = 1 / float(meta.get("fps", 30))
        stamps = [i * period for i in range(numbers[-1] + 1)]
    numbers = [i for i in numbers if i < len(stamps)]
    stamps_ns = [from_seconds(float(stamps[i])) for i in numbers]
    source = ListedSource(
        [Entry(stamp, colour(i), depth(i)) for stamp, i in zip(stamps_ns, numbers)],
        DepthRegistration(depth_camera, camera),
    )
    describe(source, path, "Record3D", camera, "K in its metadata", depth_size)
    poses = np.array(meta.get("poses", []), float).reshape(-1, 7)
    known = [k for k, i in enumerate(numbers) if i < len(poses)]
    if known:
        posed = poses[[numbers[k] for k in known]]
        times = np.array([stamps_ns[k] for k in known], np.int64)
        matrices = Trajectory(times, np.hstack([posed[:, 4:], posed[:, :4]])).poses @ ARKIT
        refer(source, "ARKit's poses in its metadata", times, matrices)
    return source


def describe(
    source: Source, path: Path, what: str, camera: Camera, origin: str, depth: tuple[int, int]
) -> None:
    source.name = path.stem
    source.origin = f"{path} ({what})"
    source.camera = camera
    source.camera_origin = origin
    source.notes.append(
        f"depth of {depth[1]} x {depth[0]} px is brought to colour of "
        f"{camera.width} x {camera.height} px"
    )


def refer(
    source: Source, where: str, stamps_ns: NDArray[np.int64], poses: NDArray[np.float64]
) -> None:
    """The phone's own poses, if they are some: a recording is of use without them."""
    try:
        source.ground_truth = Trajectory.from_poses(stamps_ns, poses)
    except (Error, ValueError) as error:
        source.warnings.append(f"{where} are left out: {error}")
        return
    source.is_reference_only = True
    source.ground_truth_origin = f"reference: {where} (odometry, not ground truth)"
    source.notes.append(source.ground_truth_origin)


def is_stray(path: Path) -> bool:
    return (path / "rgb.mp4").is_file() and (path / "camera_matrix.csv").is_file()


class StraySource(Source):
    """Stray Scanner: rgb.mp4, depth/N.png [mm], camera_matrix.csv, odometry.csv."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._path = path
        self._depths = sorted((path / "depth").glob("*.png"))
        if not self._depths:
            raise Error(f"{path}: Stray Scanner's rgb.mp4, but no depth/*.png", code=3)
        width, height = self._video_size()
        self._factor = max(1, -(-max(width, height) // WIDEST))
        with reading(path / "camera_matrix.csv", 5):
            k = np.loadtxt(path / "camera_matrix.csv", delimiter=",")
            camera = Camera(k[0, 0], k[1, 1], k[0, 2], k[1, 2], width, height)
            camera = shrunk_camera(camera, self._factor)
        shape = read_depth(self._depths[0]).shape
        depth_size = (int(shape[0]), int(shape[1]))
        self._registration = DepthRegistration(
            camera.scaled_to(depth_size[1], depth_size[0]), camera
        )
        describe(self, path, "Stray Scanner", camera, "camera_matrix.csv", depth_size)
        self.frames = len(self._depths)
        with reading(path / "odometry.csv"):
            self._stamps = self._read_odometry()

    def _video_size(self) -> tuple[int, int]:
        with open_video(self._path / "rgb.mp4") as video:
            stream = video.streams.video[0]
            width, height = stream.codec_context.width, stream.codec_context.height
            check_pixels(self._path / "rgb.mp4", width, height)
            return width, height

    def _read_odometry(self) -> list[int]:
        file = self._path / "odometry.csv"
        if not file.is_file():
            self.warnings.append(f"{file.name} is not there: 60 frames per second are assumed")
            return [round(1e9 * i / 60) for i in range(len(self._depths))]
        rows = list(csv.reader(io.StringIO(file.read_text(encoding="utf-8"))))
        header = [field.strip() for field in rows[0]]
        columns = [header.index(name) for name in ("timestamp", "x", "y", "z", "qx", "qy", "qz", "qw")]
        table = np.array([[float(row[c]) for c in columns] for row in rows[1:] if row])
        stamps = np.array([from_seconds(float(stamp)) for stamp in table[:, 0]], np.int64)
        poses = Trajectory(stamps, table[:, 1:]).poses
        refer(self, "odometry.csv of the phone", stamps, poses)
        return [int(stamp) for stamp in stamps]

    def __iter__(self) -> Iterator[Frame]:
        file = self._path / "rgb.mp4"
        with open_video(file) as video:
            for i, picture in enumerate(video.decode(video=0)):
                if i >= min(len(self._depths), len(self._stamps)):
                    return
                rgb = shrunk(picture.to_ndarray(format="rgb24"), self._factor)
                depth = metres(read_depth(self._depths[i]), 1000.0)
                with reading(self._depths[i]):  # of another size than the first one
                    registered = self._registration(depth)
                yield require_size(Frame(self._stamps[i], rgb, registered), self.camera, file)

# SPDX-License-Identifier: MIT
"""Two folders of images in formats that the C++ library does not read, and NYU's raw recordings."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera, read_scaled
from edvo.errors import Error
from edvo.registration import DepthRegistration
from edvo.sources.base import metres
from edvo.sources.image_files import COLOUR_SUFFIXES, DEPTH_SUFFIXES, read_colour, read_depth
from edvo.sources.listed import Entry, ListedSource

COLOUR_FOLDERS = ("rgb", "color", "colour", "image", "images")
DEPTH_FOLDERS = ("depth", "depths")
RATE = 30.0  # [Hz] of images without stamps
NYU = re.compile(r"^[rd]-\d+\.\d+-\d+\.p[pg]m$")


def is_nyu_raw(path: Path) -> bool:
    return any(NYU.match(file.name) for file in path.glob("d-*.pgm"))


def refuse_nyu_raw(path: Path) -> Error:
    return Error(
        f"{path}: NYU's raw recordings hold Kinect disparities that belong to another camera than "
        "colour; run the data set's toolbox (get_synched_frames, project_depth_map) and open its "
        "colour and 16-bit depth images",
        code=3,
    )


def images_in(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    files = [f for f in folder.iterdir() if f.suffix.lower() in suffixes and f.name[0] != "."]
    return sorted(files, key=lambda f: [int(n) for n in re.findall(r"\d+", f.stem)] or [0])


def find_folders(path: Path) -> tuple[Path, Path] | None:
    colour = next((path / name for name in COLOUR_FOLDERS if (path / name).is_dir()), None)
    depth = next((path / name for name in DEPTH_FOLDERS if (path / name).is_dir()), None)
    return (colour, depth) if colour and depth else None


def open_pairs(
    path: Path,
    camera: Camera | str | Path | None,
    camera_size: tuple[int, int],
    depth_scale: float | None,
    depth_camera: Camera | str | Path | None = None,
    colour_from_depth: NDArray[np.float64] | None = None,
) -> ListedSource:
    """Images of the same order in both folders; depth may be of a camera of its own."""
    folders = find_folders(path)
    if folders is None:
        raise Error(f"{path}: no folders of colour and depth images", code=3)
    colours = images_in(folders[0], COLOUR_SUFFIXES)
    depths = images_in(folders[1], DEPTH_SUFFIXES)
    if not colours or len(colours) != len(depths):
        raise Error(
            f"{path}: {len(colours)} colour and {len(depths)} depth images; as many of each are "
            "needed where their names are not stamps",
            code=3,
        )
    first_depth = read_depth(depths[0])
    is_float = first_depth.dtype == np.float32
    units = depth_scale or (1.0 if is_float else 1000.0)
    rgb = read_colour(colours[0])
    size = (rgb.shape[1], rgb.shape[0])
    depth_size = (first_depth.shape[1], first_depth.shape[0])
    chosen, origin = choose_camera(path, camera, camera_size, size)
    registration = None
    if depth_camera is not None:
        own = read_scaled(depth_camera, (0, 0), depth_size)
        registration = DepthRegistration(own, chosen, colour_from_depth)
    elif depth_size != size:
        raise Error(
            f"{depths[0]}: depth of {depth_size[0]} x {depth_size[1]} px, colour of {size[0]} x "
            f"{size[1]} px; --depth-camera FILE and --colour-from-depth FILE say how they belong "
            "together",
            code=3,
        )

    def colour(file: Path) -> Callable[[], NDArray[np.uint8]]:
        return lambda: read_colour(file)

    def depth(file: Path) -> Callable[[], NDArray[np.float32]]:
        return lambda: metres(read_depth(file), units)

    source = ListedSource(
        [
            Entry(round(1e9 * i / RATE), colour(c), depth(d))
            for i, (c, d) in enumerate(zip(colours, depths))
        ],
        registration,
    )
    source.name = path.name
    source.origin = f"{path} (images in {folders[0].name} and {folders[1].name})"
    source.camera, source.camera_origin = chosen, origin
    source.notes.append(f"no time stamps, so {RATE:g} frames per second are assumed")
    source.notes.append(
        f"depth in {'metres (float)' if is_float and depth_scale is None else f'{units:g} units per metre'}"
    )
    if registration is not None:
        source.notes.append("depth is registered to colour here")
    return source


def choose_camera(
    path: Path,
    camera: Camera | str | Path | None,
    camera_size: tuple[int, int],
    size: tuple[int, int],
) -> tuple[Camera, str]:
    if camera is not None:
        return read_scaled(camera, camera_size, size), "as given"
    for name in ("camera.toml", "camera.yaml", "calibration.txt", "intrinsics.txt"):
        if (path / name).is_file():
            return Camera.read(path / name, *size), f"{path / name}, which is in the folder"
    raise Error(f"{path}: the camera is not known; give it with --camera FILE", code=5)

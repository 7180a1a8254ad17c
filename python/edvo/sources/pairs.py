# SPDX-License-Identifier: MIT
"""Two folders of images in formats that the C++ library does not read, and NYU's raw recordings."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera, read_scaled
from edvo.errors import Error
from edvo.registration import DepthRegistration
from edvo.sources.base import metres
from edvo.sources.depth_cameras import read_depth_camera
from edvo.sources.image_files import COLOUR_SUFFIXES, DEPTH_SUFFIXES, read_colour, read_depth
from edvo.sources.image_stamps import have_stamps, pair_by_name, written_stamps
from edvo.sources.listed import Entry, ListedSource
from edvo.trajectory import Trajectory

COLOUR_FOLDERS = ("rgb", "color", "colour", "image", "images")
DEPTH_FOLDERS = ("depth", "depths", "depth_image", "depth_images")
CAMERA_FILES = (
    "camera.toml", "camera.yaml", "calibration.txt", "intrinsics.txt", "intrinsic.txt", "camera.txt",
    "intrinsic/camera.txt", "intrinsic/intrinsic.txt", "intrinsic/intrinsics.txt",
)  # fmt: skip
LISTS = ("rgb.txt", "depth.txt", "assoc*.txt")  # say stamps and pairs themselves
PICTURES = (".jpg", ".jpeg")  # of depth
SCALE = re.compile(r"^\s*(?:depth_scale|(?:RGBD\.)?DepthMapFactor)\s*[:=]\s*([\d.eE+]+)", re.MULTILINE)
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
    """Of colour and depth; their names may have capitals."""
    try:
        folders = {file.name.lower(): file for file in sorted(path.iterdir()) if file.is_dir()}
    except OSError:
        return None  # the C++ library says why it cannot be read
    colour = next((folders[name] for name in COLOUR_FOLDERS if name in folders), None)
    depth = next((folders[name] for name in DEPTH_FOLDERS if name in folders), None)
    return (colour, depth) if colour and depth else None


def needs_python(path: Path) -> bool:
    """Two folders of images that the C++ library does not know by name, format or stamps."""
    folders = find_folders(path)
    if folders is None or any(next(path.glob(name), None) for name in LISTS):
        return False
    colours, depths = images_in(folders[0], COLOUR_SUFFIXES), images_in(folders[1], DEPTH_SUFFIXES)
    is_known = folders[0].name in COLOUR_FOLDERS and folders[1].name in DEPTH_FOLDERS[:2]
    if not is_known or not any(f.suffix.lower() == ".png" for f in depths):
        return True
    if not any(f.suffix.lower() in (".png", *PICTURES) for f in colours):
        return True
    return have_stamps(colours, depths)


def stated_scale(file: Path | None) -> float | None:
    """Depth units per metre that a camera file states."""
    if file is None:
        return None
    found = SCALE.search(file.read_text(encoding="utf-8", errors="replace"))
    if not found:
        return None
    try:
        scale = float(found[1])
    except ValueError:
        scale = math.nan
    if not 0 < scale < math.inf:
        raise Error(f"{file}: depth_scale {found[1]}: no number of units per metre", code=5)
    return scale


def choose_units(
    given: float | None, file: Path | None, is_float: bool
) -> tuple[float, str]:
    """Units per metre, and why."""
    if given is not None:
        return given, f"depth in {given:g} units per metre, as given"
    if is_float:
        return 1.0, "depth in metres (float)"
    stated = stated_scale(file)
    if stated and file is not None:
        return stated, f"depth in {stated:g} units per metre (depth_scale in {file.name})"
    return 1000.0, "depth in 1000 units per metre (assumed; --depth-scale says otherwise)"


def pair_files(path: Path, folders: tuple[Path, Path]) -> tuple[list[tuple[int, Path, Path]], int, str]:
    """Stamp [ns] and both files of each frame, the delay of depth [ns], and how they were paired."""
    colours = images_in(folders[0], COLOUR_SUFFIXES)
    depths = images_in(folders[1], DEPTH_SUFFIXES)
    if not depths and images_in(folders[1], PICTURES):
        raise Error(
            f"{folders[1]}: depth as JPEG, a picture of depth of 8 bits, blurred at its edges; record "
            "16-bit PNG or TIFF",
            code=3,
        )
    if colours and depths and have_stamps(colours, depths):
        frames, pairing = pair_by_name(colours, depths)
        note = pairing.note(len(colours), len(depths)) + ", by the stamps in their names"
        return frames, pairing.depth_delay_ns, note
    if not colours or len(colours) != len(depths):
        raise Error(
            f"{path}: {len(colours)} colour and {len(depths)} depth images; as many of each are "
            "needed where their names are not stamps",
            code=3,
        )
    listed = path / "timestamps.txt"
    stamps = written_stamps(listed, colours)
    if stamps is not None:
        return list(zip(stamps, colours, depths)), 0, f"time stamps from {listed}"
    numbered = [(round(1e9 * i / RATE), c, d) for i, (c, d) in enumerate(zip(colours, depths))]
    return numbered, 0, f"no time stamps, so {RATE:g} frames per second are assumed"


def open_pairs(
    path: Path,
    camera: Camera | str | Path | None,
    camera_size: tuple[int, int],
    depth_scale: float | None,
    depth_camera: Camera | str | Path | None = None,
    colour_from_depth: NDArray[np.float64] | None = None,
) -> ListedSource:
    """Images of the same stamps or order in both folders; depth may be of a camera of its own."""
    folders = find_folders(path)
    if folders is None:
        raise Error(f"{path}: no folders of colour and depth images", code=3)
    frames, delay, paired = pair_files(path, folders)
    _, first_colour, first = frames[0]
    raw, rgb = read_depth(first), read_colour(first_colour)
    size, depth_size = (rgb.shape[1], rgb.shape[0]), (raw.shape[1], raw.shape[0])
    chosen, origin, file = choose_camera(path, camera, camera_size, size)
    units, said = choose_units(depth_scale, file, raw.dtype == np.float32)
    registration = None
    if depth_camera is not None:
        own = read_depth_camera(depth_camera, depth_size)
        registration = DepthRegistration(own, chosen, colour_from_depth)
    elif depth_size != size:
        raise Error(
            f"{first}: depth of {depth_size[0]} x {depth_size[1]} px, colour of {size[0]} x "
            f"{size[1]} px; --depth-camera FILE and --colour-from-depth FILE say how they belong "
            "together",
            code=3,
        )
    source = ListedSource(
        [Entry(stamp, partial(read_colour, c), partial(read_metres, d, units)) for stamp, c, d in frames],
        registration,
    )
    source.name = path.name
    source.origin = f"{path} (images in {folders[0].name} and {folders[1].name})"
    source.camera, source.camera_origin = chosen, origin
    source.depth_delay_ns = delay
    source.notes += [paired, said]
    if (path / "groundtruth.txt").is_file():
        source.ground_truth = Trajectory.read(path / "groundtruth.txt")
        source.ground_truth_origin = str(path / "groundtruth.txt")
    if registration is not None:
        source.notes.append("depth is registered to colour here")
    return source


def read_metres(file: Path, units: float) -> NDArray[np.float32]:
    return metres(read_depth(file), units)


def choose_camera(
    path: Path,
    camera: Camera | str | Path | None,
    camera_size: tuple[int, int],
    size: tuple[int, int],
) -> tuple[Camera, str, Path | None]:
    """With where it is from, in words and as a file."""
    if camera is not None:
        file = None if isinstance(camera, Camera) else Path(camera)
        return read_scaled(camera, camera_size, size), "as given", file
    for name in CAMERA_FILES:
        if (path / name).is_file():
            chosen = read_scaled(path / name, camera_size, size)
            return chosen, f"{path / name}, which is in the folder", path / name
    raise Error(f"{path}: the camera is not known; give it with --camera FILE", code=5)

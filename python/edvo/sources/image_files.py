# SPDX-License-Identifier: MIT
"""Image files that the C++ library does not read: PGM and PPM, TIFF and EXR, numpy's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.errors import Error, missing_extra

COLOUR_SUFFIXES = (".png", ".jpg", ".jpeg", ".ppm", ".tif", ".tiff", ".bmp")
DEPTH_SUFFIXES = (".png", ".pgm", ".tif", ".tiff", ".exr", ".npy")


def read_netpbm(file: Path) -> NDArray[Any]:
    """Binary PGM (P5) and PPM (P6), 8 or 16 bits."""
    data = file.read_bytes()
    fields: list[bytes] = []
    place = 0
    while len(fields) < 4 and place < len(data):
        while place < len(data) and data[place : place + 1].isspace():
            place += 1
        if data[place : place + 1] == b"#":
            place = data.find(b"\n", place) + 1 or len(data)
            continue
        end = place
        while end < len(data) and not data[end : end + 1].isspace():
            end += 1
        fields.append(data[place:end])
        place = end
    try:
        kind, (width, height, largest) = fields[0], [int(field) for field in fields[1:]]
        channels = {b"P5": 1, b"P6": 3}[kind]
        dtype = np.dtype(">u2" if largest > 255 else "u1")
        pixels = np.frombuffer(data, dtype, width * height * channels, place + 1)
    except (KeyError, ValueError, IndexError):
        raise Error(f"{file}: no binary PGM or PPM image, or cut off", code=3) from None
    image = pixels.astype(dtype.newbyteorder("="))
    return image.reshape((height, width, channels) if channels > 1 else (height, width))


def read_opencv(file: Path) -> NDArray[Any]:
    try:
        import cv2
    except ImportError:
        raise missing_extra(f"reading {file.name}", "opencv-python-headless", "ros") from None
    image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise Error(f"{file}: cannot be decoded", code=3)
    return np.asarray(image)


def read_exr(file: Path) -> NDArray[np.float32]:
    """H x W: of an image with one channel, or its depth (Z) or first colour."""
    try:
        import OpenEXR
    except ImportError:
        raise missing_extra(f"reading {file.name}", "OpenEXR", "record3d") from None
    try:
        with OpenEXR.File(str(file), separate_channels=True) as image:
            channels = image.channels()
            name = next((name for name in ("Z", "Y", "R") if name in channels), next(iter(channels)))
            return np.array(channels[name].pixels, np.float32)
    except Exception as error:  # noqa: BLE001: the library raises several kinds
        raise Error(f"{file}: cannot be decoded: {error}", code=3) from None


def read_colour(file: Path) -> NDArray[np.uint8]:
    """H x W x 3, RGB."""
    suffix = file.suffix.lower()
    if suffix in (".png", ".jpg", ".jpeg"):
        return np.asarray(_core.read_colour(file))
    if suffix == ".ppm":
        image = read_netpbm(file)
    else:
        image = read_opencv(file)
        image = image[:, :, 2::-1] if image.ndim == 3 else image
    if image.ndim == 2:
        image = np.repeat(image[:, :, None], 3, axis=2)
    if image.dtype == np.uint16:
        image = image >> 8
    return np.ascontiguousarray(image, np.uint8)


def read_depth(file: Path) -> NDArray[Any]:
    """H x W as stored: 16-bit units, or float32 metres (EXR, float TIFF, .npy)."""
    suffix = file.suffix.lower()
    if suffix == ".png":
        return np.asarray(_core.read_depth(file))
    if suffix == ".pgm":
        image = read_netpbm(file)
    elif suffix == ".npy":
        image = np.load(file)
    elif suffix == ".exr":
        image = read_exr(file)
    elif suffix in DEPTH_SUFFIXES:
        image = read_opencv(file)
    else:
        raise Error(f"{file}: depth as {suffix or 'this'} is not read", code=3)
    if image.ndim == 3:
        image = image[:, :, 0]
    if image.dtype in (np.float64, np.float16):
        image = image.astype(np.float32)
    if image.dtype not in (np.uint16, np.float32):
        raise Error(
            f"{file}: depth of {image.dtype}; 16-bit or float is needed (8-bit depth is a picture "
            "of depth)",
            code=3,
        )
    return image

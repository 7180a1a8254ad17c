# SPDX-License-Identifier: MIT
"""Images that the C++ library does not read: PGM and PPM, TIFF and EXR, numpy's; and those in
memory."""

from __future__ import annotations

from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.errors import Error, missing_extra
from edvo.sources.image_size import said_size
from edvo.sources.untrusted import check_pixels, one_line, reading

COLOUR_SUFFIXES = (".png", ".jpg", ".jpeg", ".ppm", ".tif", ".tiff", ".bmp")
DEPTH_SUFFIXES = (".png", ".pgm", ".tif", ".tiff", ".exr", ".npy")


def opencv(purpose: str = "decoding compressed images") -> Any:
    try:
        import cv2
    except ImportError:
        raise missing_extra(purpose, "opencv-python-headless", "ros") from None
    return cv2


def decode_image(data: NDArray[np.uint8], flags: int, what: object) -> NDArray[Any]:
    """A PNG, JPEG, TIFF or BMP as OpenCV has it. Raises edvo.Error for what is cut off or none."""
    cv2 = opencv()
    size = said_size(data.tobytes())
    if size is not None:
        check_pixels(what, *size)
    try:
        image = cv2.imdecode(data, flags) if size is not None else None
    except cv2.error:
        image = None
    if image is None:
        hint = "" if size is not None else " (PNG, JPEG, TIFF and BMP are read)"
        raise Error(f"{what}: {len(data)} bytes, damaged or cut off, cannot be decoded{hint}", code=3)
    return np.asarray(image)


def read_netpbm(file: Path) -> NDArray[Any]:
    """Binary PGM (P5) and PPM (P6), 8 or 16 bits."""
    with reading(file):
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
        check_pixels(file, width, height)
        dtype = np.dtype(">u2" if largest > 255 else "u1")
        pixels = np.frombuffer(data, dtype, width * height * channels, place + 1)
    except (KeyError, ValueError, IndexError):
        raise Error(f"{file}: no binary PGM or PPM image, or cut off", code=3) from None
    image = pixels.astype(dtype.newbyteorder("="))
    return image.reshape((height, width, channels) if channels > 1 else (height, width))


def read_opencv(file: Path) -> NDArray[Any]:
    unchanged = opencv(f"reading {file.name}").IMREAD_UNCHANGED
    with reading(file):
        return decode_image(np.frombuffer(file.read_bytes(), np.uint8), unchanged, file)


def read_npy(file: Path) -> NDArray[Any]:
    # Mapped: memory for what its header says is asked for only if the file has it.
    with reading(file, 3, SyntaxError, TokenError):  # its header is a literal of Python
        image = np.load(file, mmap_mode="r")
        if not isinstance(image, np.ndarray) or image.ndim not in (2, 3):
            raise ValueError("no image: H x W numbers are expected")
        check_pixels(file, image.shape[1], image.shape[0])
        return np.array(image, image.dtype.newbyteorder("="))


def read_exr(file: Path) -> NDArray[np.float32]:
    """H x W: of an image with one channel, or its depth (Z) or first colour."""
    try:
        import OpenEXR
    except ImportError:
        raise missing_extra(f"reading {file.name}", "OpenEXR", "record3d") from None
    try:
        with OpenEXR.File(str(file), header_only=True) as image:
            (left, top), (right, bottom) = image.header()["dataWindow"]
            check_pixels(file, int(right) - int(left) + 1, int(bottom) - int(top) + 1)
        with OpenEXR.File(str(file), separate_channels=True) as image:
            channels = image.channels()
            name = next((name for name in ("Z", "Y", "R") if name in channels), next(iter(channels)))
            return np.array(channels[name].pixels, np.float32)
    except Error:
        raise
    except Exception as error:  # noqa: BLE001: the library raises several kinds
        raise Error(f"{file}: cannot be decoded: {one_line(error)}", code=3) from None


def read_colour(file: Path) -> NDArray[np.uint8]:
    """H x W x 3, RGB."""
    suffix = file.suffix.lower()
    if suffix in (".png", ".jpg", ".jpeg"):
        return np.asarray(_core.read_colour(file))
    if suffix == ".ppm":
        image = read_netpbm(file)
    else:
        image = read_opencv(file)
        image = image[:, :, 2::-1] if image.ndim == 3 and image.shape[2] > 2 else image
    if image.ndim == 2:
        image = np.repeat(image[:, :, None], 3, axis=2)
    if image.dtype == np.uint16:
        image = image >> 8
    if image.dtype != np.uint8 or image.shape[2] != 3:
        raise Error(f"{file}: no colour image of 8 or 16 bits, but {image.dtype}", code=3)
    return np.ascontiguousarray(image, np.uint8)


def read_depth(file: Path) -> NDArray[Any]:
    """H x W as stored: 16-bit units, or float32 metres (EXR, float TIFF, .npy)."""
    suffix = file.suffix.lower()
    if suffix == ".png":
        return np.asarray(_core.read_depth(file))
    if suffix == ".pgm":
        image = read_netpbm(file)
    elif suffix == ".npy":
        image = read_npy(file)
    elif suffix == ".exr":
        image = read_exr(file)
    elif suffix in DEPTH_SUFFIXES:
        image = read_opencv(file)
    else:
        raise Error(f"{file}: depth as {suffix or 'this'} is not read", code=3)
    if image.ndim == 3 and image.shape[2] > 0:
        image = image[:, :, 0]
    if image.dtype in (np.float64, np.float16):
        image = image.astype(np.float32)
    if image.dtype not in (np.uint16, np.float32) or image.ndim != 2:
        raise Error(
            f"{file}: depth of {image.dtype}; 16-bit or float is needed (8-bit depth is a picture "
            "of depth)",
            code=3,
        )
    return image

# SPDX-License-Identifier: MIT
"""Images, cameras and poses in ROS messages."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error
from edvo.sources.base import metres
from edvo.sources.image_files import decode_image, opencv
from edvo.sources.rvl import decode_rvl
from edvo.sources.untrusted import check_pixels

COLOUR = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "8UC3": 3, "mono8": 1, "8UC1": 1}
BAYER = {"bayer_rggb8": "BG", "bayer_bggr8": "RG", "bayer_gbrg8": "GR", "bayer_grbg8": "GB"}
DEPTH = {"16UC1", "mono16", "32FC1", "Z16"}
MILLIMETRES = 1000.0  # REP 118: 16-bit depth
FARTHEST = 1e9  # [m] of a position: beyond, sums of squares lose all digits


def stamp_ns(message: Any) -> int:
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def rows(message: Any, dtype: str, channels: int) -> NDArray[Any]:
    """The pixels of an Image message; rows may be padded."""
    check_pixels(f"image, {encoding_of(message)}", message.width, message.height)
    kind = np.dtype(dtype).newbyteorder(">" if message.is_bigendian else "<")
    width = message.width * channels * kind.itemsize
    data = np.asarray(message.data, np.uint8)
    if message.step < width or data.size < message.step * message.height:
        raise Error(
            f"image of {message.width} x {message.height} px, {encoding_of(message)}: "
            f"{data.size} bytes, {message.step} a row, are too few",
            code=3,
        )
    lines = data[: message.step * message.height].reshape(message.height, message.step)
    pixels = np.ascontiguousarray(lines[:, :width]).view(kind).astype(dtype, copy=False)
    return pixels.reshape((message.height, message.width, channels)[: 3 if channels > 1 else 2])


def is_png16(data: Any) -> bool:
    """A PNG image of one channel of 16 bits, by its header."""
    head = bytes(data[:26])
    return head[:8] == b"\x89PNG\r\n\x1a\n" and head[24:26] == b"\x10\0"


def kind_of(message: Any) -> str:
    """"colour", "depth" or "" (neither)."""
    if hasattr(message, "format"):
        text = message.format.lower()
        is_depth = "compresseddepth" in text or text.startswith(("16uc1", "mono16", "32fc1"))
        return "depth" if is_depth or is_png16(message.data) else "colour"
    if message.encoding in DEPTH:
        return "depth"
    return "colour" if message.encoding in COLOUR or message.encoding in BAYER else ""


def encoding_of(message: Any) -> str:
    """In one line, whatever the message says."""
    return " ".join(str(getattr(message, "format", "") or getattr(message, "encoding", "")).split())


def is_picture(message: Any) -> bool:
    """Of one channel of 8 bits, which hold no depth."""
    return encoding_of(message).startswith(("8UC1", "mono8"))


def decode_colour(message: Any) -> NDArray[np.uint8]:
    """H x W x 3, RGB."""
    if hasattr(message, "format"):
        data = np.asarray(message.data, np.uint8)
        bgr = decode_image(data, opencv().IMREAD_COLOR, f"compressed image ({encoding_of(message)})")
        return np.ascontiguousarray(bgr[:, :, ::-1])
    encoding = message.encoding
    if encoding in BAYER:
        cv2 = opencv()
        code = getattr(cv2, f"COLOR_Bayer{BAYER[encoding]}2RGB")
        return np.asarray(cv2.cvtColor(rows(message, "uint8", 1), code), np.uint8)
    if encoding not in COLOUR:
        raise Error(f"image encoding {encoding_of(message)}: not read; known are {', '.join(COLOUR)}", code=3)
    pixels = rows(message, "uint8", COLOUR[encoding])
    if pixels.ndim == 2:
        return np.repeat(pixels[:, :, None], 3, axis=2)
    ordered = pixels[:, :, 2::-1] if encoding in ("bgr8", "bgra8", "8UC3") else pixels[:, :, :3]
    return np.ascontiguousarray(ordered)


def decode_depth(message: Any, units_per_metre: float | None) -> NDArray[np.float32]:
    """H x W, [m]. Units, unless given, by the encoding: 32FC1 metres, 16-bit millimetres."""
    is_float = encoding_of(message).startswith("32FC1")
    units = units_per_metre or (1.0 if is_float else MILLIMETRES)
    if hasattr(message, "format"):
        return decode_compressed_depth(message, units)
    if is_float:
        return metres(rows(message, "float32", 1), units)
    if message.encoding not in DEPTH:
        raise Error(
            f"depth encoding {encoding_of(message)}: not read, 16UC1 or 32FC1 is needed (8-bit depth is "
            "a picture of depth)",
            code=3,
        )
    return metres(rows(message, "uint16", 1), units)


def decode_compressed_depth(message: Any, units: float) -> NDArray[np.float32]:
    """image_transport's compressedDepth: a header of 12 bytes, then a PNG, or width, height and RVL;
    or its compressed: a PNG."""
    data = np.asarray(message.data, np.uint8)
    if "compresseddepth" not in message.format.lower():
        return decode_png_depth(data, encoding_of(message), units)
    if len(data) < 20:
        raise Error(f"depth compressed as {encoding_of(message)}: only {len(data)} bytes", code=3)
    _, a, b = struct.unpack("<iff", data[:12].tobytes())
    if "rvl" in message.format.lower():
        width, height = struct.unpack("<II", data[12:20].tobytes())
        check_pixels(f"depth compressed as {encoding_of(message)}", width, height)
        image: Any = decode_rvl(data[20:], height, width)
    else:
        what = f"depth compressed as {encoding_of(message)}"
        image = decode_image(data[12:], opencv().IMREAD_UNCHANGED, what)
    if image.dtype != np.uint16 or image.ndim != 2:
        raise Error(f"depth compressed as {encoding_of(message)}: no 16-bit image", code=3)
    if message.format.startswith("32FC1"):  # quantized inverse depth
        with np.errstate(divide="ignore"):
            depth = np.float32(a) / (image.astype(np.float32) - np.float32(b))
        depth[image == 0] = np.nan
        return metres(depth, units)
    return metres(image, units)


def decode_png_depth(data: NDArray[np.uint8], format: str, units: float) -> NDArray[np.float32]:
    what = f"depth compressed as {format}"
    image = decode_image(data, opencv().IMREAD_UNCHANGED, what)
    if image.dtype != np.uint16 or image.ndim != 2:
        raise Error(
            f"{what}: {8 * image.dtype.itemsize} bits, a picture of depth; record it as 16-bit PNG "
            "or compressedDepth",
            code=3,
        )
    return metres(image, units)


def camera_from(message: Any, unsized: tuple[int, int], is_rectified: bool = False) -> Camera:
    """The camera of a CameraInfo message, or that of its rectified images.

    ``unsized``: width and height of one that does not say them.
    """
    width, height = (message.width, message.height) if message.width > 0 else unsized
    if is_rectified:
        p = np.asarray(getattr(message, "p", getattr(message, "P", None)), float)
        if p[0] > 0:
            fx, fy, cx, cy = float(p[0]), float(p[5]), float(p[2]), float(p[6])
            return Camera(fx, fy, cx, cy, width, height)
    k = np.asarray(getattr(message, "k", getattr(message, "K", None)), float)
    d = [float(value) for value in getattr(message, "d", getattr(message, "D", []))]
    model = message.distortion_model
    equidistant = model in ("equidistant", "fisheye")
    most = 4 if equidistant else 8
    known = ("", "none", "plumb_bob", "rational_polynomial", "equidistant", "fisheye")
    if any(d) and (model not in known or any(d[most:])):
        raise Error(
            f"CameraInfo: distortion model {model!r} with {len(d)} coefficients is not read, only "
            "plumb_bob, rational_polynomial and equidistant",
            code=5,
        )
    if not k[0] > 0:
        raise Error("CameraInfo: no focal length (the camera was not calibrated)", code=5)
    fx, fy, cx, cy = float(k[0]), float(k[4]), float(k[2]), float(k[5])
    return Camera(fx, fy, cx, cy, width, height, tuple(d[:most]), equidistant)


def pose_from(translation: Any, rotation: Any) -> NDArray[np.float64]:
    """4 x 4 of a Vector3 or Point and a Quaternion message. Raises edvo.Error for numbers that are
    none, or too large for a place."""
    q = np.array([rotation.x, rotation.y, rotation.z, rotation.w], float)
    position = np.array([translation.x, translation.y, translation.z], float)
    if not (np.abs(position) <= FARTHEST).all() or not (np.abs(q) <= FARTHEST).all():
        raise Error(f"pose {[*position.tolist(), *q.tolist()]}: no place in space", code=3)
    norm = np.linalg.norm(q)
    x, y, z, w = q / norm if norm > 1 / FARTHEST else (0.0, 0.0, 0.0, 1.0)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = position
    return pose

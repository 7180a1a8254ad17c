# SPDX-License-Identifier: MIT
"""Small inputs of every kind, to begin with."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 16, 12
CAMERA = b"fx = 15\nfy = 15\ncx = 7.5\ncy = 5.5\n"
RGB = np.random.default_rng(1).integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
METRES = np.linspace(1, 3, WIDTH * HEIGHT, dtype=np.float32).reshape(HEIGHT, WIDTH)
UNITS = np.round(METRES * 1000).astype(np.uint16)


def encoded(suffix: str, image: NDArray[np.generic]) -> bytes:
    return bytes(cv2.imencode(suffix, image)[1])


PNG, JPEG, DEPTH_PNG = encoded(".png", RGB), encoded(".jpg", RGB), encoded(".png", UNITS)


def huge_png(side: int) -> bytes:
    """Few bytes that say to be very many."""
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", side, side, 16, 0, 0, 0, 0)
    rows = zlib.compress(bytes(1 << 16))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def npy(array: NDArray[np.generic]) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def exr(folder: Path, image: NDArray[np.generic]) -> bytes:
    import OpenEXR

    file = folder / "sample.exr"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"R": np.ascontiguousarray(image)}).write(str(file))
    data = file.read_bytes()
    file.unlink()
    return data


@dataclass(frozen=True)
class Folder:
    """Files of which an input replaces one: its first byte says which, the rest is the content."""

    files: dict[str, bytes]

    def seeds(self) -> list[bytes]:
        return [bytes([i]) + data for i, data in enumerate(self.files.values())]

    def with_one_replaced(self, data: bytes) -> dict[str, bytes]:
        chosen = data[0] % len(self.files) if data else 0
        return {
            name: data[1:] if i == chosen else old for i, (name, old) in enumerate(self.files.items())
        }

    def write(self, data: bytes, folder: Path) -> None:
        for name, content in self.with_one_replaced(data).items():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)


def frames(pattern: str, *contents: bytes, count: int = 2) -> dict[str, bytes]:
    """Files by names with {i} (a number) and the same content each."""
    return {pattern.format(i=i): contents[i % len(contents)] for i in range(count)}

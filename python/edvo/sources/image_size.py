# SPDX-License-Identifier: MIT
"""The size that an encoded image says to have: a few bytes can make a decoder ask for gigabytes."""

from __future__ import annotations

import struct

Size = tuple[int, int]  # width, height [px]


def said_size(data: bytes) -> Size | None:
    """Of a PNG, JPEG, BMP or TIFF image; None for anything else, or if it is cut off before that."""
    try:
        if data[:8] == b"\x89PNG\r\n\x1a\n":
            return size_of_png(data)
        if data[:2] == b"\xff\xd8":
            return size_of_jpeg(data)
        if data[:2] == b"BM":
            width, height = struct.unpack_from("<ii", data, 18)
            return int(width), abs(int(height))
        if data[:4] in (b"II*\0", b"MM\0*"):
            return size_of_tiff(data)
    except struct.error:
        pass
    return None


def size_of_png(data: bytes) -> Size | None:
    """None if a chunk says to be longer than the data: OpenCV asks for memory for all of it."""
    _, first, width, height = struct.unpack_from(">I4sII", data, 8)
    place, kind = 8, b""
    while place < len(data) and kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, place)
        place += 12 + length
    return (int(width), int(height)) if first == b"IHDR" and place <= len(data) else None


def size_of_jpeg(data: bytes) -> Size | None:
    """Of its frame header, which stands behind segments of other kinds."""
    place = 2
    while True:
        mark, kind, length = struct.unpack_from(">BBH", data, place)
        if mark != 0xFF:
            return None
        if kind == 0xFF:  # padding
            place += 1
        elif 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack_from(">HH", data, place + 5)
            return int(width), int(height)
        elif kind == 0x01 or 0xD0 <= kind <= 0xD9:  # without a length
            place += 2
        else:
            place += 2 + length


def size_of_tiff(data: bytes) -> Size | None:
    """Of its first image: tags 256 and 257."""
    order = "<" if data[:1] == b"I" else ">"
    (place,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, place)
    sides = {}
    for i in range(count):
        tag, kind = struct.unpack_from(order + "HH", data, place + 2 + 12 * i)
        if tag in (256, 257):
            number = {3: "H", 4: "I"}.get(kind)
            if number is None:
                return None
            (sides[tag],) = struct.unpack_from(order + number, data, place + 10 + 12 * i)
    return (int(sides[256]), int(sides[257])) if len(sides) == 2 else None

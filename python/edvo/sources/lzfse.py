# SPDX-License-Identifier: MIT
"""LZFSE, Apple's compression, with a limit to what it unpacks to: its library takes any size for
granted that the data say."""

from __future__ import annotations

import struct

from edvo.errors import Error, missing_extra
from edvo.sources.untrusted import reading

WHAT = "data compressed as LZFSE"


def unpacked_size(data: bytes) -> int:
    """Sum of what its blocks say. Raises edvo.Error where they do not follow each other to an end."""
    place, size = 0, 0
    with reading(WHAT):
        while (kind := data[place : place + 4]) != b"bvx$":
            (raw,) = struct.unpack_from("<I", data, place + 4)
            if kind == b"bvx-":
                place += 8 + raw
            elif kind == b"bvxn":
                place += 12 + struct.unpack_from("<I", data, place + 8)[0]
            elif kind == b"bvx2":
                literals, matches, states = struct.unpack_from("<QQQ", data, place + 8)
                head = states & 0xFFFFFFFF
                place += max(head, 32) + (literals >> 20 & 0xFFFFF) + (matches >> 40 & 0xFFFFF)
            else:
                raise ValueError(f"no block at byte {place}")
            size += raw
    return size


def decompress(data: bytes, most: int) -> bytes:
    """Raises edvo.Error for what is damaged, or has more than ``most`` bytes."""
    try:
        import liblzfse
    except ImportError:
        raise missing_extra("Record3D's depth", "pyliblzfse", "record3d") from None
    size = unpacked_size(data)
    if not 0 < size <= most:
        raise Error(f"{WHAT}: {size} bytes, at most {most} are expected", code=3)
    with reading(WHAT, 3, liblzfse.error):
        return bytes(liblzfse.decompress(data))
